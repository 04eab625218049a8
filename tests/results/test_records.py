"""What results remember of bodies and scenes: made again, or refused, never another."""

from __future__ import annotations

import json

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.results.records import BodyRecord
from support.files.model_files import fields, write_npz


def again(body):
    """The body of a record that went through a file."""
    return BodyRecord(json.loads(json.dumps(BodyRecord.of(body).data)), "a file").make()


def test_a_model_that_says_no_gender_is_found_again(tmp_path):
    body = Body.load(write_npz(tmp_path / "mine.npz", fields()))
    assert body.gender == "unknown"
    np.testing.assert_array_equal(again(body).rest_vertices, body.rest_vertices)


def test_a_template_of_a_file_is_found_again_and_an_array_is_refused(tmp_path):
    path = write_npz(tmp_path / "mine.npz", fields())
    template = 1.2 * fields()["v_template"].astype(float)
    lines = "".join(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in template)
    (tmp_path / "subject.obj").write_text(lines)
    body = Body.load(path, v_template=tmp_path / "subject.obj")
    np.testing.assert_array_equal(again(body).rest_vertices, body.rest_vertices)
    with pytest.raises(FileError, match=r"template came from no file\. .*body="):
        again(Body.load(path, v_template=template))

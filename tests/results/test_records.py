"""What results remember of bodies and scenes: made again, or refused, never another."""

from __future__ import annotations

import json

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.results.records import BodyRecord, SceneRecord
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


def test_what_a_model_s_text_does_not_read_may_be_missing():
    """Plugins and looks of URDF; of MJCF what no file can be called is not there."""
    robot = (
        '<robot name="r"><link name="a"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '<visual><geometry><mesh filename="nope.stl"/></geometry></visual>'
        '<collision><geometry><box size="1 1 1"/></geometry></collision></link>'
        '<gazebo><plugin name="c" filename="libcontrol.so"/></gazebo></robot>'
    )
    long = f'<mujoco><asset><mesh name="m" file="{"a" * 300}.obj"/></asset></mujoco>'
    document = {"articulated": {"arm": {"xml": robot}, "thing": {"xml": long}}}
    assert list(SceneRecord(document, "a file").missing()) == ["thing"]

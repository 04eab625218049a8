"""Genders as files spell them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, HalfPhysicsWarning
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.gender_names import gender_named, said_gender
from support.files.amass_files import fields, write
from support.files.layouts import movement, quiet

SPELLINGS = ["female", "Female", " FEMALE ", "f", "F", b"female", "b'female'", np.array("f"),
             np.array(["female"]), np.array(b"f"), np.array("female", dtype=object),
             np.array(["f"], dtype=object)]  # fmt: skip


@pytest.mark.parametrize("said", SPELLINGS, ids=repr)
def test_every_spelling_is_understood(tmp_path, said):
    assert hp.Motion.load(write(tmp_path / "a.npz", fields("smplh") | {"gender": said})).gender == (
        "female"
    )
    translation, turns = movement(12, up="z")
    person = {"trans": translation, "root_orient": turns[:, 0], "gender": said}
    person["pose_body"] = turns[:, 1:22].reshape(12, 63)
    (tmp_path / "a.pkl").write_bytes(pickle.dumps({"person1": person}))
    assert quiet(tmp_path / "a.pkl").motion.gender == "female"


def test_none_is_no_gender(tmp_path):
    assert said_gender(Record("f", {})) is said_gender(Record("f", {"gender": None})) is None
    path = write(tmp_path / "a.npz", fields("smplh") | {"gender": np.array(None)})
    with pytest.warns(HalfPhysicsWarning, match="no gender in field 'gender': taken as neutral"):
        assert hp.Motion.load(path).gender == "neutral"


def test_other_words_are_left_to_who_refuses_them(tmp_path):
    assert gender_named("Robot") == "robot"
    with pytest.raises(FileError, match="'gender': found 3, expected text"):
        said_gender(Record("f", {"gender": 3}))
    with pytest.raises(FileError, match="'gender': found 'robot', expected one of neutral"):
        hp.Motion.load(write(tmp_path / "a.npz", fields("smplh") | {"gender": "Robot"}))

"""3DPW: pickles of Python 2 with several people, at 60 Hz."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from support.files import recorded_sets as sets
from support.files.wrong_files import broken_bytes_are_refused, hostile_is_refused, refused

PEOPLE = [sets.person(seed, tuple(range(22))) for seed in (5, 6)]


def written(tmp_path, content=None):
    path = tmp_path / "downtown_walking_00.pkl"
    content = sets.threedpw_fields(PEOPLE) if content is None else content
    path.write_bytes(sets.python2_pickle(content))
    return path


@pytest.mark.parametrize("axes", [sets.Y_UP, sets.Z_UP], ids=["y", "z"])
def test_both_people_at_60_hertz(tmp_path, axes):
    both = sets.load(written(tmp_path, sets.threedpw_fields(PEOPLE, axes))).motions
    for motion, someone, gender in zip(both, PEOPLE, ("male", "female"), strict=True):
        assert (motion.fps, motion.model, motion.gender) == (60.0, "smpl", gender)
        assert motion.betas.tolist() == sets.BETAS.tolist()
        assert sets.off(motion, someone) < sets.DOUBLE


def test_one_person_and_files_with_the_images_rate_only(tmp_path):
    one = hp.Motion.load(written(tmp_path), clip="1", frames=(2, 8))
    assert sets.off(one, tuple(a[2:8] for a in PEOPLE[1])) < sets.DOUBLE
    content = sets.threedpw_fields(PEOPLE)
    del content["poses_60Hz"], content["trans_60Hz"]
    slow = sets.load(written(tmp_path, content)).motions
    assert [motion.fps for motion in slow] == [30.0, 30.0]
    assert sets.off(slow[0], tuple(a[::2] for a in PEOPLE[0])) < sets.DOUBLE
    content["campose_valid"][0][2:4] = 0
    with pytest.warns(hp.HalfPhysicsWarning, match="not known in 2 images"):
        hp.Motion.load(written(tmp_path, content), clip="0")


WRONG = [
    ("no list", "poses_60Hz", lambda a: 3, "found int, expected a list"),
    (
        "one list shorter",
        "trans_60Hz",
        lambda a: a[:1],
        "found 1 people, expected an array for person 1",
    ),
    ("a wrong width", "poses_60Hz", lambda a: [p[:, :66] for p in a], r"'poses'.*\(T, 72\)"),
    ("fewer places", "trans_60Hz", lambda a: [p[:-1] for p in a], "different length"),
    ("NaN", "trans_60Hz", lambda a: [p + np.nan for p in a], "'trans'.*NaN"),
    ("a gender of nobody", "genders", lambda a: ["x", "y"], "gender: found 'x'"),
]


@pytest.mark.parametrize(
    ("key", "spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG]
)
def test_wrong_files(tmp_path, key, spoil, message):
    content = sets.threedpw_fields(PEOPLE)
    content[key] = spoil(content[key])
    refused(written(tmp_path, content), message)


def test_hostile_and_broken_files(tmp_path):
    hostile_is_refused(tmp_path / "b.pkl", sets.threedpw_fields(PEOPLE), "betas")
    broken_bytes_are_refused(written(tmp_path))

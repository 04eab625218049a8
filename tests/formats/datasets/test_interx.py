"""Inter-X: two people, each in a file of a folder."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from support.files import recorded_sets as sets
from support.files.wrong_files import (
    broken_bytes_are_refused,
    changed,
    put,
    refused,
    usual,
    without,
)

PEOPLE = [sets.person(seed, (*range(22), *range(25, 55))) for seed in (0, 1)]


def test_both_people_with_hands_upright_at_120(tmp_path):
    folder = sets.interx(tmp_path, PEOPLE)
    both = sets.load(folder).motions
    assert len(both) == 2
    for motion, someone in zip(both, PEOPLE, strict=True):
        assert (motion.fps, motion.model, motion.gender) == (120.0, "smplx", "female")
        assert np.abs(motion.betas - sets.BETAS).max() < sets.SINGLE
        assert sets.off(motion, someone) < sets.SINGLE


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_one_of_them(tmp_path):
    folder = sets.interx(tmp_path, PEOPLE)
    with pytest.warns(hp.HalfPhysicsWarning, match="of 2 people 'P1' is read"):
        assert sets.off(hp.Motion.load(folder), PEOPLE[0]) < sets.SINGLE
    assert sets.off(hp.Motion.load(folder, clip="P2", hands="flat"), PEOPLE[1]) < sets.SINGLE
    with pytest.warns(hp.HalfPhysicsWarning, match=r"120 fps and a flat hand are taken \(fps=, ha"):
        motion = hp.Motion.load(folder / "P2.npz", frames=(3, 9))
    assert len(motion) == 6
    assert sets.off(motion, tuple(a[3:9] for a in PEOPLE[1])) < sets.SINGLE
    assert [clip.format for clip in hp.clips(tmp_path)] == ["interx"]


WRONG = [
    *usual("trans"),
    *usual("root_orient"),
    ("no body", without("pose_body"), "'pose_body' is missing"),
    ("no left hand", without("pose_lhand"), "'pose_lhand' is missing"),
    ("a flat body", changed("pose_body", lambda a: a.reshape(len(a), -1)), r"\(T, 21, 3\)"),
    ("hands of MANO", changed("pose_rhand", lambda a: a[:, :4]), r"\(T, 15, 3\)"),
    ("a gender of nobody", put("gender", np.array("cat")), "gender"),
    ("a million metres", changed("trans", lambda a: a * 1e6), "m/s"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(tmp_path, spoil, message):
    folder = sets.interx(tmp_path, PEOPLE)
    content = sets.interx_fields(PEOPLE[0])
    spoil(content)
    np.savez(folder / "P1.npz", **content)
    refused(folder / "P1.npz", message)


def test_broken_files_and_one_who_is_missing(tmp_path):
    folder = sets.interx(tmp_path, PEOPLE)
    broken_bytes_are_refused(folder / "P1.npz")
    (folder / "P1.npz").unlink()
    assert sets.off(sets.load(folder).motion, PEOPLE[1]) < sets.SINGLE
    with pytest.raises(hp.HalfPhysicsError, match="no 'P1', expected one of its 1 people"):
        hp.Motion.load(folder, clip="P1")

"""InterHuman: two people in one pickle."""

from __future__ import annotations

import pytest

import halfphysics as hp
from support.files import recorded_sets as sets
from support.files.wrong_files import (
    broken_bytes_are_refused,
    hostile_is_refused,
    refused,
    uneven,
    usual,
)

PEOPLE = [sets.person(seed, tuple(range(22))) for seed in (2, 3)]


def written(tmp_path, content=None):
    return sets.dump(tmp_path / "1.pkl", content or sets.interhuman_fields(PEOPLE))


def test_both_people_z_up_at_their_rate(tmp_path):
    both = sets.load(written(tmp_path)).motions
    for motion, someone in zip(both, PEOPLE, strict=True):
        assert (motion.fps, motion.model, motion.gender) == (59.94, "smplh", "male")
        assert motion.betas.tolist() == sets.BETAS.tolist()
        assert sets.off(motion, someone) < sets.SINGLE
    one = hp.Motion.load(written(tmp_path), clip="person2", frames=(2, 7))
    assert sets.off(one, tuple(a[2:7] for a in PEOPLE[1])) < sets.SINGLE


def test_a_file_without_a_rate_has_that_of_the_data_set(tmp_path):
    content = sets.interhuman_fields(PEOPLE)
    del content["mocap_framerate"]
    assert sets.load(written(tmp_path, content)).motions[0].fps == 59.94


CASES = [*usual("trans"), *usual("pose_body"), *map(uneven, ("trans", "pose_body", "betas"))]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in CASES], ids=[c[0] for c in CASES])
def test_wrong_people(tmp_path, spoil, message):
    content = sets.interhuman_fields(PEOPLE)
    spoil(content["person1"])
    refused(written(tmp_path, content), message)


def test_wrong_and_hostile_files(tmp_path):
    content = sets.interhuman_fields(PEOPLE)
    refused(written(tmp_path, {**content, "person1": 3}), "'person1': found int, expected a dict")
    refused(
        written(tmp_path, {**content, "mocap_framerate": -1.0}), "'mocap_framerate'.*above|betw"
    )
    hostile_is_refused(tmp_path / "2.pkl", content, "frames")
    broken_bytes_are_refused(written(tmp_path))

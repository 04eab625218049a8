"""Options of a command line and of sweeps: a recorded carry, adapted to whoever it is played by."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.formats import losses
from halfphysics.formats.loading import MotionOptions
from halfphysics.motion.skeleton import JOINT_INDEX

ARM = [JOINT_INDEX[f"left_{joint}"] for joint in ("collar", "shoulder", "elbow")]


def read(path, options=None, **said):
    """The sequence of a file by its options, and the warnings of reading it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sequence = (options or MotionOptions()).sequence(path, **said)
    return sequence, [str(each.message) for each in caught]


def test_all_that_was_assumed_and_adapted_is_one_line(carried_file):
    sequence, told = read(carried_file)
    (line,) = told
    assert "\n" not in line
    assert line.count(str(carried_file)) == 1
    for part in ("clip 'sub1_suitcase_000': ", "bones", "weighs", "'ground'", "adapted to what"):
        assert part in line
    assert [hold.object for hold in sequence.motion.holds] == ["suitcase"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        direct = hp.load_sequence(carried_file)
    assert [str(each.message) for each in caught] == told
    assert caught[0].filename == __file__
    assert np.array_equal(direct.motion.rotations, sequence.motion.rotations)


def test_adapting_and_the_grip_are_options(carried_file):
    whole, _ = read(carried_file)
    bare, told = read(carried_file, MotionOptions(adapt=False))
    assert "adapted to what is held" not in told[0]
    assert bare.motion.holds == ()
    assert bare.motion.recorded is None
    assert np.array_equal(bare.motion.rotations, whole.motion.recorded.rotations)
    touching, told = read(carried_file, MotionOptions(grip=False))
    assert "adapted to what is held" in told[0]
    assert "pressing" not in told[0]
    assert touching.motion.holds[0].force == 0.0
    with pytest.warns(hp.HalfPhysicsWarning):
        again = hp.load_sequence(carried_file, grip=False).motion
    assert np.array_equal(again.rotations, touching.motion.rotations)
    for other in ("replayed", "none"):
        assert read(carried_file, MotionOptions(objects=other))[0].motion.holds == ()


def test_a_motion_file_keeps_neither_hold_nor_record_and_says_so(carried_file, tmp_path):
    sequence, _ = read(carried_file)
    lost = losses(sequence.motion, tmp_path / "a.npz")
    assert [line for line in lost if "what the hands hold" in line] != []
    assert losses(sequence.motion.bare(), tmp_path / "a.npz") == [
        line for line in lost if "what the hands hold" not in line
    ]
    sequence.motion.save(tmp_path / "a.npz")
    again = hp.Motion.load(tmp_path / "a.npz")
    assert again.holds == ()
    assert again.recorded is None
    assert np.array_equal(again.rotations, sequence.motion.rotations)


def test_hands_are_adapted_to_the_body_that_plays(carried_file):
    small = hp.Body.default(stature=1.6)
    mine, _ = read(carried_file, body=lambda own, motion: small)
    theirs, _ = read(carried_file)
    assert mine.body is small
    assert not np.array_equal(mine.motion.rotations, theirs.motion.rotations)
    other = dataclasses.replace(theirs, body=small).adapted()
    assert np.array_equal(other.motion.rotations, mine.motion.rotations)


def test_a_firmer_body_is_asked_for_less_to_press_as_hard(carried_file):
    """Targets go less far beyond the surface: by M + lambda diag(I), of which M is a part."""
    firm, _ = read(carried_file, settings=hp.Settings(stiffness=4.0))
    usual, _ = read(carried_file)
    touching, _ = read(carried_file, MotionOptions(grip=False))
    assert firm.settings.stiffness == 4.0
    assert firm.motion.holds[0].force == usual.motion.holds[0].force
    hold = usual.motion.holds[0]
    middle = (hold.first + hold.last) // 2
    beyond = [
        np.linalg.norm((each.motion.rotations - touching.motion.rotations)[middle, ARM])
        for each in (usual, firm)
    ]
    assert 0.25 * beyond[0] < beyond[1] < 0.6 * beyond[0]


def test_without_a_floor(carried_file):
    sequence, told = read(carried_file, ground=False)
    assert not sequence.scene.statics
    assert "'ground'" not in told[0]


@pytest.mark.parametrize("grip", [True, False])
def test_adapted_again_is_the_same(carried_file, grip):
    sequence, _ = read(carried_file)
    again = sequence.adapted(grip=grip)
    other, _ = read(carried_file, MotionOptions(grip=grip))
    assert np.array_equal(again.motion.rotations, other.motion.rotations)
    assert again.motion.recorded is sequence.motion.recorded


def test_where_nothing_is_held_the_sequence_stays_itself():
    story = hp.scenarios.load("kick_ball")
    assert story.adapted() is story

"""Results are cut to the frames asked for, clips and truths alike, and have their own floor."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli.judge import Options
from halfphysics.errors import InputError
from halfphysics.formats.loading import MotionOptions
from halfphysics.judging.judge import judge_one
from halfphysics.judging.played import played
from halfphysics.judging.tasks import Task
from halfphysics.judging.truths import truth_of
from support.made_clips import walk


@pytest.fixture
def result(tmp_path):
    """A result of 8 frames with a ball, in a file."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(2.0, 0.0, 0.1))
    path = tmp_path / "result.npz"
    hp.simulate(walk()[:8], scene).save(path)
    return path


def test_frames_cut_people_and_objects(result):
    whole = hp.Result.load(result)
    for frames, part in (("2:6", slice(2, 6)), (":-3", slice(-3)), (None, slice(None))):
        found = played(result, MotionOptions(frames=frames))
        own = whole.people[0].motion.translation[part]
        np.testing.assert_array_equal(found.motions[0].translation, own)
        ball = whole.objects["ball"].position[part]
        np.testing.assert_array_equal(found.objects["ball"].position, ball)


def test_a_result_is_judged_in_the_frames_of_its_truth(result):
    """In those asked for, whichever of the two is a result."""
    cut = Options(motion_file=MotionOptions(frames="0:5"))
    hp.Result.load(result).people[0].motion.save(result.with_name("motion.npz"))
    for clip in ("result.npz", "motion.npz"):
        for truth in ("result.npz", "motion.npz"):
            task = Task(result.with_name(clip), truth=result.with_name(truth))
            (one,) = judge_one((task, cut))
            assert one.verdict is not None, one.error
            assert one.verdict.frames == 5
            assert one.verdict["mpjpe_global_mm"] < 1e-2  # files keep float32


def test_fewer_than_two_frames_are_refused(result):
    with pytest.raises(InputError, match=r"frames: found 7:, but .*result\.npz has 8 frames"):
        played(result, MotionOptions(frames="7:"))


@pytest.mark.parametrize("floor", [-1.0, "lowest"])
def test_a_result_has_the_floor_of_its_scene(result, floor):
    """People would be moved away from their scene, or a true person from the true ball."""
    how = MotionOptions(floor=floor)
    message = rf"floor: found {floor}, but .*result\.npz is a result, which stands on the floor"
    with pytest.raises(InputError, match=message):
        truth_of(result, how, None, objects=True)
    (one,) = judge_one((Task(result), Options(motion_file=how)))
    assert one.verdict is None
    assert one.error.startswith("floor: found")

"""The option `floor`: heights of people, things and scene."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats.floor import on_floor
from halfphysics.formats.loading import MotionOptions
from halfphysics.results.result import ObjectTrack
from halfphysics.simulation.sequence import Sequence
from support.files.layouts import quiet
from support.files.wrong_axes import walker, written

#: Sums of doubles [m].
ROUNDING = 1e-9
UP = np.array([0.0, 0.0, 0.7])


@pytest.fixture
def floating(tmp_path):
    motion = walker()
    return written(
        "amass-smplx", motion.with_frames(motion.translation + UP, motion.rotations), tmp_path
    )


def lowest(motion, body=None):
    return float((body or hp.Body.default()).vertices(motion)[..., 2].min())


def test_who_floats_or_is_sunk_is_told(floating, tmp_path):
    with pytest.warns(HalfPhysicsWarning, match=r"soles are 0\.\d\d m above z = 0.*floor='lowest'"):
        found = hp.Motion.load(floating)
    assert abs(lowest(found) - 0.7) < 0.02
    motion = walker()
    sunk = motion.with_frames(motion.translation - UP, motion.rotations)
    with pytest.warns(HalfPhysicsWarning, match=r"soles are 0\.\d\d m below z = 0"):
        hp.load_sequence(written("amass-smplx", sunk, tmp_path))


def test_a_floor_that_is_said_is_silent(floating):
    assert abs(lowest(hp.Motion.load(floating, floor="lowest"))) < ROUNDING
    found = hp.Motion.load(floating, floor=0.7)
    assert np.abs(found.translation - walker().translation).max() < ROUNDING
    assert np.array_equal(
        hp.load_sequence(floating, floor=0.7).motion.translation, found.translation
    )


def test_a_sequence_moves_as_a_whole():
    motion = walker()
    scene = hp.Scene()
    scene.add_static("table", hp.Box((1, 1, 0.1)), position=(2, 0, 0.4))
    scene.add_object("cup", hp.Sphere(0.05), mass=0.2, position=(2, 0, 0.5))
    path = np.linspace([2, 1, 0.5], [2, 2, 0.5], 9)
    scene.add_moving("cart", hp.Box((0.2, 0.2, 0.2)), path, fps=30.0)
    scene.friction("table", "cup", 0.3)
    track = ObjectTrack(position=path, quaternion=np.tile([1.0, 0, 0, 0], (9, 1)))
    found = on_floor(Sequence(motion, scene, recorded={"cart": track}), 0.25)
    assert np.allclose(motion.translation - found.motion.translation, [0, 0, 0.25], atol=ROUNDING)
    assert np.allclose(found.scene.statics["table"].position, [2, 0, 0.15])
    assert np.allclose(found.scene.objects["cup"].position, [2, 0, 0.25])
    assert np.allclose(found.scene.objects["cart"].positions[:, 2], 0.25)
    assert np.allclose(found.recorded["cart"].position[:, 2], 0.25)
    assert found.scene.friction_of("table", "cup") == 0.3
    assert np.allclose(scene.statics["table"].position, [2, 0, 0.4])  # a copy is moved


def test_recorded_things_move_along(carried_file):
    as_it_is = quiet(carried_file, adapt=False, ground=False)
    moved = quiet(carried_file, adapt=False, floor=-0.5)
    (before,), (after,) = as_it_is.recorded.values(), moved.recorded.values()
    assert np.allclose(after.position - before.position, [0, 0, 0.5])
    assert np.allclose(moved.motion.translation - as_it_is.motion.translation, [0, 0, 0.5])
    ground = moved.scene.statics["ground"]
    assert ground.shape.offset + ground.position[2] == 0.0  # where the caller said it


def test_the_lowest_skin_is_that_of_the_body_that_is_chosen(floating):
    tall = hp.Body.default(stature=1.95)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = MotionOptions(floor="lowest").sequence(floating, body=lambda own, motion: tall)
    assert abs(lowest(found.motion, tall)) < ROUNDING

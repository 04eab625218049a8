"""Warnings of a start in mid-air."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.simulation.floating_start import FLOATING
from support.as_it_is import as_it_is

UPRIGHT = np.array([np.pi / 2, 0.0, 0.0])


def standing(tmp_path, height: float = 0.0, root=UPRIGHT) -> hp.Motion:
    """A person at rest, from a file, with the lowest vertex at `height` [m]."""
    rotations = np.zeros((2, 55, 3))
    rotations[:, 0] = root
    motion = hp.Motion(np.zeros((2, 3)), rotations, 30.0).grounded(hp.Body.default(), height)
    motion.save(tmp_path / "a.npz")
    return hp.Motion.load(tmp_path / "a.npz", up="z")


def floor() -> hp.Scene:
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    return scene


def said(motion: hp.Motion, scene: hp.Scene, settings: hp.Settings | None = None) -> list[str]:
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always", HalfPhysicsWarning)
        hp.simulate(motion, scene, settings=settings)
    return [str(w.message) for w in seen]


def test_in_mid_air(tmp_path):
    with pytest.warns(HalfPhysicsWarning, match="person starts 30 cm above floor.*grounded") as w:
        hp.simulate(standing(tmp_path, 0.3), floor())
    assert w[0].filename == __file__


@pytest.mark.parametrize("height", [0.0, 0.002, FLOATING - 0.001])
def test_on_the_floor(tmp_path, height):
    assert said(standing(tmp_path, height), floor()) == []


def test_sunken_is_said_once(tmp_path):
    (message,) = said(standing(tmp_path, -0.06), floor(), as_it_is())
    assert "the start is not clear" in message


def test_who_is_put_on_the_floor_does_not_start_in_it(tmp_path):
    assert said(standing(tmp_path, -0.06), floor()) == []


def test_no_floor_or_no_file(tmp_path):
    assert said(standing(tmp_path, 0.3), hp.Scene()) == []
    motion = standing(tmp_path, 0.3)
    made = hp.Motion(motion.translation, motion.rotations, 30.0)
    assert said(made, floor()) == []


@pytest.mark.parametrize("kind", ["box", "mesh", "object"])
def test_on_something_above_the_floor(tmp_path, kind):
    scene = floor()
    box = hp.Box([2.0, 2.0, 0.5])
    if kind == "object":
        scene.add_object("crate", box, mass=50.0, position=[0, 0, 0.25])
    else:
        shape = box if kind == "box" else hp.Mesh(*box.triangles())
        scene.add_static("crate", shape, position=[0, 0, 0.25])
    assert said(standing(tmp_path, 0.505), scene) == []
    (message,) = said(standing(tmp_path, 0.8), scene)
    assert "30 cm above crate" in message


def test_lying_on_a_bed_with_the_feet_out(tmp_path):
    motion = standing(tmp_path, 0.6, root=np.zeros(3))  # z forward at rest: on the back
    body = hp.Body.default()
    back = body.vertices(motion, frames=0)
    trunk = back[body.weights.argmax(axis=1) == 9]
    scene = floor()
    scene.add_static(
        "bed", hp.Box([0.6, 0.8, 0.2]),
        position=[0, trunk[:, 1].mean(), trunk[:, 2].min() - 0.1 - 0.01],
    )  # fmt: skip
    assert not any("on nothing" in message for message in said(motion, scene))

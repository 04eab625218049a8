"""Friction on layers: by the pressure, as on a hard floor."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder, Plane, Sphere
from halfphysics.scene.scene import Scene
from support.soft import closed_forms as forms
from support.soft.scenes import LYING, on_floor, run, soft

G, MU = forms.G, 0.5
MASS, SIZE = 10.0, (0.4, 0.4, 0.1)
STIFFNESS = 1e5


def on_slope(angle, shape, height, turn=(1.0, 0.0, 0.0, 0.0), damping=5e3, stiffness=STIFFNESS):
    """A layer that falls along +x at an angle [rad], and a thing on it; the slope's turn."""
    tilt = rot.exp([0.0, angle, 0.0])
    scene = Scene()
    layer = soft(stiffness, damping)
    scene.add_static("slope", Plane(), quaternion=tilt, friction=1.0, soft=layer)
    scene.add_object(
        "thing",
        shape,
        mass=MASS,
        friction=MU,
        position=rot.rotate(tilt, [0.0, 0.0, height]),
        quaternion=rot.multiply(tilt, np.asarray(turn)),
    )
    return scene, tilt


@pytest.mark.parametrize("share", [0.97, 1.03])
@pytest.mark.parametrize(("fps", "substeps"), [(30, 8), (60, 4), (120, 4)])
def test_the_friction_angle(share, fps, substeps):
    """A box holds below the angle of friction and slides above it, as on a hard slope."""
    angle = np.arctan(MU) * share
    # At its depth from the start, so that it does not fall first.
    sunk = MASS * G * np.cos(angle) / (STIFFNESS * SIZE[0] * SIZE[1])
    scene, _ = on_slope(angle, Box(SIZE), 0.05 - sunk)
    result = run(scene, 2.0, fps, substeps)
    way = np.linalg.norm(result.poses[-1, :3] - result.poses[0, :3])
    if share < 1.0:
        assert way < 2e-3
    else:
        expected = (
            0.5 * G * (np.sin(angle) - MU * np.cos(angle)) * 2.0 * (2.0 + 1.0 / fps / substeps)
        )
        assert way == pytest.approx(expected, rel=0.05)


def test_sliding_stops_where_friction_says():
    sunk = MASS * G / (STIFFNESS * SIZE[0] * SIZE[1])
    scene = on_floor(
        soft(STIFFNESS, 5e3), Box(SIZE), 0.05 - sunk, MASS, friction=0.4, velocity=(2.0, 0.0, 0.0)
    )
    result = run(scene, 1.2)
    assert result.poses[-1, 0] == pytest.approx(2.0**2 / (2.0 * 0.4 * G), rel=0.02)
    assert np.abs(result.poses[-1, :3] - result.poses[-9, :3]).max() < 1e-4


@pytest.mark.parametrize(("shape", "share"), [(Sphere(0.1), 0.4), (Cylinder(0.1, 0.3), 0.5)])
def test_rolling_down_a_stiff_layer(shape, share):
    """a = g sin / (1 + I / (m r^2)), on a layer without damping so stiff that it sinks by 1 mm."""
    angle, stiffness = 0.2, 2e7 if isinstance(shape, Sphere) else 6e6
    force = (
        (lambda d: forms.ball_force(stiffness, 0.1, d))
        if isinstance(shape, Sphere)
        else (lambda d: forms.cylinder_force(stiffness, 0.1, 0.3, d))
    )
    sunk = forms.sink(force, MASS * G * np.cos(angle), 0.05)
    scene, _ = on_slope(angle, shape, 0.1 - sunk, LYING, damping=0.0, stiffness=stiffness)
    result = run(scene, 1.0, fps=60, substeps=8)
    way = np.linalg.norm(result.poses[-1, :3] - result.poses[0, :3])
    assert way == pytest.approx(0.5 * G * np.sin(angle) / (1.0 + share), rel=0.03)

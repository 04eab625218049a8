"""Airborne frames: thrown, lifted, standing and squatting people."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.metrics.airborne import (
    GRAVITY,
    airborne,
    centre_of_mass,
    free_fall,
    smoothed,
)
from halfphysics.scene.scene import Scene
from support.people import t_pose


def jump(fps, flight=0.6, stand=0.5, height=0.0):
    """Upright, still, then thrown up to land where it started, then still again."""
    t = np.arange(round((2 * stand + flight) * fps) + 1) / fps - stand
    z = np.where((t > 0) & (t < flight), 0.5 * GRAVITY * t * (flight - t), 0.0)
    return t_pose(np.stack([0 * t, 0 * t, z + height], axis=1), fps), (t > 0) & (t < flight)


@pytest.mark.parametrize("height", [-0.03, 0.0, 0.03, 2.0])
@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_a_jump_is_airborne_between_its_ends(fps, height):
    motion, flies = jump(fps, height=height)
    found = airborne(motion, Body.default())
    # Frames beside the flight are not yet still: one at each end.
    near = flies | np.roll(flies, 1) | np.roll(flies, -1)
    assert not found[~near].any()
    # The low pass rounds the ends of the flight; up to a tenth of a second of it is put right.
    edge = round(0.05 * fps)
    inner = flies.copy()
    inner[:-edge] &= flies[edge:]
    inner[edge:] &= flies[:-edge]
    assert inner.sum() > 0.4 * fps
    assert found[inner].all()


def test_who_is_moved_through_the_air_is_not_airborne():
    t = np.arange(60) / 30.0
    zero = np.zeros_like(t)
    for z in (zero + 0.5, 0.8 * t, 0.3 * np.sin(2.0 * t)):
        motion = t_pose(np.stack([1.5 * t, zero, z], axis=1))
        assert not airborne(motion, Body.default()).any()


def test_who_drops_into_a_squat_is_not_airborne():
    """The pelvis falls freely for 0.25 s and is caught, the feet stay where they are."""
    t = np.arange(46) / 30.0 - 0.5
    drop = np.where(t < 0.0, 0.0, np.where(t < 0.25, 0.5 * GRAVITY * t * t, 0.3))
    motion = t_pose(np.stack([0 * t, 0 * t, -drop], axis=1))
    body = Body.default()
    still = body.vertices(motion, 0)

    class Planted(Body):
        """Its lower legs do not take part in the fall."""

        def vertices(self, motion, frames=None, **more):
            moved = super().vertices(motion, frames, **more)
            feet = still[:, 2] < still[:, 2].min() + 0.5
            moved[..., feet, :] = still[feet]
            return moved

    planted = Planted(**{name: getattr(body, name) for name in body.__dataclass_fields__})
    assert airborne(motion, body).any()
    assert not airborne(motion, planted).any()


def test_too_few_frames_are_not_airborne():
    assert not airborne(t_pose(np.zeros((3, 3))), Body.default()).any()


def test_the_centre_of_mass_is_that_of_the_parts():
    body = Body.default()
    motion = t_pose([[0.0, 0, 0], [0.1, 0.2, 0.3]])
    first, second = centre_of_mass(motion, body)
    assert second - first == pytest.approx([0.1, 0.2, 0.3])
    pelvis, head = body.joints(motion)[0, [0, 15]]
    assert pelvis[2] < first[2] < head[2]


def test_the_low_pass_has_no_phase_and_keeps_lines():
    t = np.linspace(0.0, 2.0, 200)
    assert smoothed(2.0 + 3.0 * t, 100.0) == pytest.approx(2.0 + 3.0 * t, abs=1e-9)
    slow = np.sin(2 * np.pi * t)
    assert np.abs(smoothed(slow, 100.0) - slow)[30:-30].max() < 0.01
    assert np.abs(smoothed(np.sin(2 * np.pi * 30 * t), 100.0))[30:-30].max() < 0.01
    assert smoothed(slow, 10.0) is slow  # the cutoff is above what the rate can show


def test_a_jump_on_the_moon_falls_as_the_moon_has_it():
    gravity, flight = 1.62, 2.0
    t = np.arange(180) / 60.0 - 0.5
    z = np.where((t > 0) & (t < flight), 0.5 * gravity * t * (flight - t), 0.0)
    motion = t_pose(np.stack([0 * t, 0 * t, z], axis=1), 60.0)
    assert not airborne(motion, Body.default()).any()
    scene = Scene(gravity=gravity)
    found = airborne(motion, Body.default(), free_fall(scene))
    assert found[(t > 0.1) & (t < flight - 0.1)].all()
    assert free_fall(Scene(gravity=0.0)) == free_fall(None) == GRAVITY

"""Frames of primitives by their own formulas, and what a judge sees of them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from support.judges.coal_scene import Watch
from support.soft.frames import Seen, frame_of, hard

LAYER = hp.Soft(thickness=0.02, stiffness=1e5, law="linear")


def test_frames_lie_a_thickness_below():
    assert np.allclose(frame_of(Box((0.2, 0.3, 0.4)), LAYER).size, (0.16, 0.26, 0.36))
    assert frame_of(Sphere(0.1), LAYER).radius == pytest.approx(0.08)
    capsule = frame_of(Capsule(0.1, 0.3), LAYER)
    assert (capsule.radius, capsule.length) == pytest.approx((0.08, 0.3))
    cylinder = frame_of(Cylinder(0.1, 0.3), LAYER)
    assert (cylinder.radius, cylinder.length) == pytest.approx((0.08, 0.26))
    assert frame_of(Plane((0, 0, 1), 0.5), LAYER).offset == pytest.approx(0.48)
    assert frame_of(Sphere(0.1), None).radius == 0.1


def test_a_mesh_of_a_box_has_the_frame_of_the_box():
    from halfphysics.geometry.mesh import Mesh

    made = trimesh.creation.box((0.2, 0.3, 0.4))
    frame = frame_of(Mesh(made.vertices, made.faces), LAYER)
    low, high = np.min(frame.vertices, axis=0), np.max(frame.vertices, axis=0)
    np.testing.assert_allclose(high - low, (0.16, 0.26, 0.36), atol=1e-9)


def test_a_judge_sees_the_frames():
    """A ball that touches the surface is a thickness away from the frame."""
    scene = hp.Scene()
    scene.add_static("floor", Plane(), soft=hp.Soft(thickness=0.015, stiffness=1e5))
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, 0.1))
    simulator = hp.Simulator(scene, body=[])
    start = simulator.world.start([])[0]
    for frames, gap in ((True, 0.015), (False, 0.0)):
        seen = Seen(simulator, hard(scene, frames=frames))
        found, names = Watch(seen).gap(start, statics="things")
        assert found == pytest.approx(gap, abs=1e-6)
        assert set(names) == {"ball", "floor"}

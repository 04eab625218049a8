"""Places that can carry: sparse, near, slow, facing the surface, whatever its shape and motion."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.support import estimate
from halfphysics.support.patches import HEIGHT, REACH, SPEED, find_patches
from halfphysics.support.skin_grid import PITCH, skin_grid
from halfphysics.support.surfaces import surfaces_of
from support.standing import raised, standing

FEET = [JOINT_INDEX[f"{s}_{j}"] for s in ("left", "right") for j in ("ankle", "foot")]


@pytest.fixture(scope="module")
def body():
    return hp.Body.default(stature=1.75, mass=70.0)


def patches(body, motion, scene, tracks=None):
    surfaces = surfaces_of(scene, tracks or {}, (), None, len(motion))
    return find_patches(body, motion, surfaces)


def floor(shape=None, **options):
    scene = hp.Scene()
    scene.add_static("floor", shape or hp.Plane(), **options)
    return scene


def test_the_grid_is_sparse_and_covers_the_skin(body):
    grid = skin_grid(body)
    assert 2000 < len(grid.vertex) < 4000
    assert (np.diff(grid.part) >= 0).all()
    assert np.array_equal(grid.part, body.weights[grid.vertex].argmax(axis=1))
    assert np.linalg.norm(grid.normal, axis=1) == pytest.approx(1.0)
    rest = body.rest_vertices
    away = np.linalg.norm(rest[:, None] - rest[grid.vertex][None, :], axis=-1).min(axis=1)
    assert np.percentile(away, 95) < 1.2 * PITCH
    assert skin_grid(body) is grid


def test_soles_carry_who_stands(body):
    motion = standing(body)
    found = patches(body, motion, floor())
    assert set(found.part) <= set(FEET)
    count = np.bincount(found.frame)
    assert (count == count[0]).all()
    assert 60 < count[0] < 200
    assert found.normal == pytest.approx(np.tile([0.0, 0.0, 1.0], (len(found), 1)))
    assert found.position[:, 2] == pytest.approx(0.0, abs=1e-12)
    assert (found.ready > 0.0).all()
    assert found.ready.max() == pytest.approx(1.0)
    assert (found.friction == 1.0).all()


def test_nothing_carries_out_of_reach(body):
    motion = standing(body)
    up = raised(motion, REACH + 1e-3)
    assert len(patches(body, up, floor())) == 0


@pytest.mark.parametrize("height", [0.0, HEIGHT, 2.0 * HEIGHT])
def test_readiness_falls_with_height(body, height):
    motion = standing(body)
    up = raised(motion, height)
    found = patches(body, up, floor())
    expected = (np.exp(-0.5 * (height / HEIGHT) ** 2) - 0.02) / 0.98
    assert found.ready.max() == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("fps", [30.0, 60.0, 240.0])
def test_readiness_falls_with_speed(body, fps):
    motion = standing(body, frames=30, fps=fps)
    t = np.arange(30) / fps
    path = motion.translation + np.outer(t, [SPEED, 0.0, 0.0])
    found = patches(body, hp.Motion(path, motion.rotations, fps), floor())
    assert found.ready.max() == pytest.approx(0.5, abs=0.01)


def test_speed_is_relative_to_what_moves(body):
    """On a platform that moves along, the feet stand."""
    motion, fps = standing(body, frames=30), 60.0
    t = np.arange(30) / fps
    path = np.outer(t, [1.0, 0.0, 0.2])
    moving = hp.Motion(motion.translation + path, motion.rotations, fps)
    scene = hp.Scene()
    scene.add_moving("lift", hp.Box((3.0, 3.0, 0.2)), path - (0.0, 0.0, 0.1), fps=fps)
    track = scene.objects["lift"].at(t)
    found = patches(body, moving, scene, {"lift": Track(*track)})
    assert found.ready.max() == pytest.approx(1.0)
    assert found.position[:, 2] == pytest.approx(path[found.frame, 2], abs=1e-9)
    scene.add_static("floor", hp.Plane(offset=-5.0))
    still = patches(body, moving, floor())
    assert still.ready.max() < 0.1


class Track:
    def __init__(self, position, quaternion):
        self.position, self.quaternion = position, quaternion


def test_all_shapes_of_a_floor_carry_alike(body):
    """Half-space, box, closed mesh and a sheet of two triangles: the same forces."""
    box = hp.Box((4.0, 4.0, 1.0))
    sheet = hp.Mesh(
        np.array([[-2.0, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    motion = standing(body)
    sunk = raised(motion, -0.01)
    turned = rot.exp([0.0, 0.0, 0.7])
    scenes = [
        floor(),
        floor(box, position=(0.0, 0.0, -0.5), quaternion=turned),
        floor(hp.Mesh(*box.triangles()), position=(0.0, 0.0, -0.5)),
        floor(sheet),
    ]
    first, *rest = (estimate(sunk, scene, body=body) for scene in scenes)
    for other in rest:
        assert other.force == pytest.approx(first.force, abs=0.02 * first.weight)
        assert other.cop == pytest.approx(first.cop, abs=0.01)


def test_what_people_pass_through_carries_nobody(body):
    scene = floor()
    scene.ignore("person", "floor")
    assert len(patches(body, standing(body), scene)) == 0


def test_friction_is_that_of_the_pair(body):
    scene = floor()
    scene.friction("person/left_foot", "floor", 0.3)
    found = patches(body, standing(body), scene)
    left = found.part == JOINT_INDEX["left_foot"]
    assert (found.friction[left] == 0.3).all()
    assert (found.friction[~left] == 1.0).all()

"""Skin hulls in the core: their corners and Jacobians against the body's own skinning."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.world import World
from support.as_it_is import as_it_is

ROUNDING = 1e-13  # rounding of coordinates of about 1 m [m]
STEP = 1e-5  # step of the finite differences [rad, m]
# Central differences of positions of about 1 m: their rounding over the step, and its square.
DIFFERENCES = 1e-7


@cache
def body(bent: bool) -> hp.Body:
    """The default body, or the same body with random pose blend shapes of centimetres."""
    plain = hp.Body.default()
    if not bent:
        return plain
    rng = np.random.default_rng(5)
    posedirs = 0.003 * rng.standard_normal((len(plain.rest_vertices), 3, 486))
    return dataclasses.replace(plain, posedirs=posedirs)


def world(bent: bool) -> World:
    return build_world([body(bent)], hp.Scene(), as_it_is(contact="skin"))


def vertices_of(built: World, hull: int) -> np.ndarray:
    return built.stepper.shape_vertices(hull).astype(np.int64)


def random_pose(seed: int) -> hp.Pose:
    rng = np.random.default_rng(seed)
    return hp.Pose(rng.normal(size=3), 0.5 * rng.standard_normal((55, 3)))


@pytest.mark.slow
@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("seed", [0, 1])
def test_corners_are_the_skins_vertices(bent: bool, seed: int) -> None:
    built, pose = world(bent), random_pose(seed)
    qpos = built.targets([pose])
    skin, hulls = body(bent).vertices(pose), body(bent).skin_corners
    for h in range(len(hulls.part)):
        mine = vertices_of(built, h)
        assert sorted(mine) == sorted(hulls.vertex[hulls.first[h] : hulls.first[h + 1]])
        corners = built.stepper.shape_points(qpos, h)
        np.testing.assert_allclose(corners, skin[mine], atol=10 * ROUNDING, rtol=0.0)


@pytest.mark.parametrize("bent", [False, True])
def test_jacobians_are_the_derivatives_of_the_skin(bent: bool) -> None:
    """All dofs: six of the root, and three of each joint, in the child's frame."""
    built, pose = world(bent), random_pose(7)
    qpos, hulls = built.targets([pose]), body(bent).skin_corners
    rng = np.random.default_rng(1)
    chosen = rng.choice(len(hulls.part), 6, replace=False)
    corners = [int(rng.integers(hulls.first[h + 1] - hulls.first[h])) for h in chosen]
    vertices = np.array(
        [vertices_of(built, int(h))[c] for h, c in zip(chosen, corners, strict=True)]
    )
    slopes = np.zeros((len(chosen), 3, built.nv))
    for dof in range(built.nv):
        velocity = np.zeros(built.nv)
        velocity[dof] = 1.0
        ends = []
        for t in (STEP, -STEP):
            q = built.stepper.integrate(qpos, velocity, t)
            translation, rotations = built.people[0].pose(q, np.eye(3))
            ends.append(body(bent).vertices(hp.Pose(translation, rotations), indices=vertices))
        slopes[:, :, dof] = (ends[0] - ends[1]) / (2.0 * STEP)
    for k, (h, c) in enumerate(zip(chosen, corners, strict=True)):
        jacobian = built.stepper.shape_jacobian(qpos, int(h), c)
        np.testing.assert_allclose(jacobian, slopes[k], atol=DIFFERENCES, rtol=0.0)


def test_rigid_parts_and_skin_carry_one_mass() -> None:
    """The collision shape does not change the mass."""
    skin, parts = world(False), build_world([body(False)], hp.Scene(), as_it_is(contact="parts"))
    qpos = skin.targets([random_pose(3)])
    np.testing.assert_array_equal(
        skin.stepper.inertia_matrix(qpos), parts.stepper.inertia_matrix(qpos)
    )


@pytest.mark.parametrize("drive_time", [None, 0.02])
def test_a_skin_with_blend_shapes_is_held_exactly(drive_time: float | None) -> None:
    """A hand with random blend shapes strikes a table top: no vertex passes its face."""
    bent = body(True)
    rotations = np.zeros((31, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    swing = np.linspace(0.0, 1.0, 31)
    for joint, side in (("left_shoulder", 1.0), ("right_shoulder", -1.0)):
        rotations[:, hp.JOINT_NAMES.index(joint), 2] = -side * 0.8 * swing
    rotations[:, 1:] += 0.1 * np.random.default_rng(2).standard_normal((54, 3))
    motion = hp.Motion(np.zeros((31, 3)), rotations, 30.0)
    lowest = bent.vertices(motion[0])[:, 2].min()
    hands = bent.joints(motion[0])[hp.JOINT_NAMES.index("left_wrist")]
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(offset=lowest - 0.01))
    scene.add_static(
        "table", hp.Box((3.0, 3.0, 0.02)), position=(hands[0] + 1.2, 0.0, hands[2] - 0.15)
    )
    assert hp.metrics.penetration(motion, bent, scene).depth_max_mm > 5.0
    settings = as_it_is(contact="skin", drive_time=drive_time, record="substeps")
    result = hp.simulate(motion, scene, body=bent, settings=settings)
    assert result.lost_time.sum() == 0.0
    assert len(result.contacts.frame) > 0
    assert result.substeps is not None
    found = hp.metrics.penetration(result.substeps.motions[0], bent, scene)
    assert found.rate_percent == 0.0
    assert found.depth_max_mm == 0.0


def test_rotations_are_what_the_core_takes() -> None:
    built, pose = world(False), random_pose(11)
    qpos = built.targets([pose])
    _, rotations = built.people[0].pose(qpos, np.eye(3))
    np.testing.assert_allclose(
        rot.to_matrix(rot.exp(rotations)), rot.to_matrix(rot.exp(pose.rotations)), atol=1e-14
    )

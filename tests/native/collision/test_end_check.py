"""The end check alone keeps bodies out, where candidates fail; and says where nothing does."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from halfphysics import _native
from halfphysics.body.body import Body
from halfphysics.geometry.colliders import hull_collider
from halfphysics.geometry.shapes import Box, Mesh, Plane
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator
from support.judges.coal_shapes import coal_hull, coal_shape
from support.people import along_x

pytest.importorskip("coal")

#: The check lets overlaps pass up to this [m].
BREACH = 1e-6


@pytest.fixture(scope="module")
def body():
    return Body.default()


def obstacles():
    """Statics ahead of a person who goes along x, by kind."""
    wall = Box((0.02, 3.0, 3.0))
    return {
        "hull": (wall, (0.2, 0.0, 0.0)),
        "mesh": (Mesh(*wall.triangles()), (0.2, 0.0, 0.0)),
        "half-space": (Plane((-1.0, 0.0, 0.0), -0.2), (0.0, 0.0, 0.0)),
    }


def walked(body, kind, blind, substeps=4):
    """A walk at 1.5 m/s into an obstacle; breaches (n, 4), smallest clearance and lost time."""
    shape, position = obstacles()[kind]
    scene = Scene()
    scene.add_static("obstacle", shape, position=position)
    motion = along_x(1.5, 16, -0.4)
    simulator = Simulator(scene, body=body, settings=Settings(substeps=substeps), fps=motion.fps)
    simulator.reset(motion[0])
    core = simulator.world.stepper
    core.blind(blind)
    breaches, lost, clearance = [], 0.0, np.inf
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t])
        breaches.append(core.breaches())
        lost += frame.lost_time
        clearance = min(clearance, core.clearance())
    return np.concatenate(breaches), clearance, lost


@pytest.mark.parametrize("kind", ["hull", "mesh", "half-space"])
def test_no_candidate_is_needed_to_stay_clear(body, kind):
    """Without any candidate steps end where the check finds an overlap: time is lost instead."""
    breaches, clearance, lost = walked(body, kind, blind=1)
    assert not len(breaches)
    assert clearance >= -1.1 * BREACH
    assert lost > 0.1


@pytest.mark.parametrize("kind", ["hull", "mesh", "half-space"])
def test_what_is_committed_all_the_same_is_reported(body, kind):
    breaches, clearance, _ = walked(body, kind, blind=2)
    assert clearance < -0.01
    assert len(breaches)
    assert breaches[:, 3].max() > 0.005


@pytest.mark.parametrize("kind", ["hull", "mesh", "half-space"])
def test_contacts_leave_the_check_nothing_to_do(body, kind):
    breaches, clearance, lost = walked(body, kind, blind=0)
    assert not len(breaches)
    assert clearance > 0.0
    assert lost == 0.0


def test_the_frame_of_a_simulator_names_its_breaches(body):
    scene = Scene()
    scene.add_static("wall", Box((0.02, 3.0, 3.0)), position=(0.2, 0.0, 0.0))
    motion = along_x(1.5, 16, -0.4)
    simulator = Simulator(scene, body=body, fps=motion.fps)
    assert not len(simulator.reset(motion[0]).breaches)
    assert not len(simulator.step(motion[1]).breaches)
    simulator.world.stepper.blind(2)
    found = [simulator.step(motion[t]).breaches for t in range(2, len(motion))]
    rows = [row for told in found for row in told.described(simulator.world.names)]
    assert rows
    assert all("mm inside wall" in row for row in rows)
    assert not len(simulator.reset(motion[0]).breaches)


def test_a_result_has_no_breaches(body):
    scene = Scene()
    scene.add_static("wall", Box((0.02, 3.0, 3.0)), position=(0.2, 0.0, 0.0))
    result = simulate(along_x(1.5, 16, -0.4), scene, body=body)
    assert len(result.contacts)
    assert not len(result.breaches)
    assert "let inside" not in result.summary()


@pytest.mark.parametrize("known", [0, 3])
def test_the_gap_from_triangles_is_a_bound_and_an_overlap_is_seen(known):
    """Against coal; directions that are known beforehand, right or wrong, change no sign."""
    rng = np.random.default_rng(5 + known)
    seen = {True: 0, False: 0}
    for _ in range(150):
        corners = rng.normal(size=(60, 1, 3)) + rng.normal(scale=0.3, size=(60, 3, 3))
        vertices = corners.reshape(-1, 3)
        faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
        points = rng.normal(size=(20, 3)) * rng.uniform(0.02, 0.3) + rng.normal(size=3)
        hull = hull_collider(points)
        axes = rng.normal(size=(known, 3))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        gap = _native.triangle_gap(vertices, faces, hull.vertices, hull.radius, hull.rim, axes)
        exact = coal.distance(
            coal_hull(points),
            coal.Transform3s.Identity(),
            coal_shape(Mesh(vertices, faces), solid=False),
            coal.Transform3s.Identity(),
            coal.DistanceRequest(),
            coal.DistanceResult(),
        )
        if abs(exact) < BREACH:
            continue
        seen[exact > 0.0] += 1
        assert (gap > 0.0) == (exact > 0.0)
        assert exact < 0.0 or gap <= exact + BREACH
    assert min(seen.values()) > 20

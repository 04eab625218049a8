"""The same outcome at every frame rate, number of substeps, mesh resolution and place."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.scene.scene import Scene
from support.soft.scenes import on_floor, run, soft

#: Frame rates and substeps a frame.
STEPS = [(30, 4), (30, 8), (30, 16), (60, 4), (60, 8), (120, 4), (120, 16)]


@pytest.fixture(scope="module")
def slides():
    """A box that is let go on the surface sliding and turning, at every rate: deepest sink, end.

    Not from above: a fall takes half a substep less than it should, which is the integrator's.
    """

    def one(fps, substeps):
        scene = on_floor(
            soft(5e4, 800.0),
            Box((0.3, 0.3, 0.2)),
            0.1,
            8.0,
            friction=0.5,
            velocity=(1.5, 0.4, 0.0),
            angular_velocity=(0.0, 0.0, 2.0),
        )
        result = run(scene, 1.5, fps, substeps)
        return (0.1 - result.height).max(), result.poses[-1]

    return {steps: one(*steps) for steps in STEPS}


@pytest.mark.parametrize("steps", STEPS, ids=str)
def test_frame_rate_and_substeps(slides, steps):
    """Sink, place and turn within 2 % of the finest."""
    sink, end = slides[steps]
    finest, exact = slides[120, 16]
    assert sink == pytest.approx(finest, rel=0.02)
    way = np.linalg.norm(exact[:2])
    # Friction stops a slide and a spin up to a substep of their start too early: first order.
    h = 1.0 / (steps[0] * steps[1])
    late, late_turn = 1.55 * h, 2.0 * h
    assert np.linalg.norm(end[:3] - exact[:3]) <= 0.02 * way + late
    turned = rot.log(rot.multiply(rot.conjugate(exact[3:]), end[3:]))
    assert np.linalg.norm(turned) <= 0.02 * np.linalg.norm(rot.log(exact[3:])) + late_turn


def seat(pitch):
    """A sofa's seat: a closed block 0.6 m wide with a bulging top, faces of about `pitch` [m]."""
    import trimesh

    n = max(2, round(0.6 / pitch))
    x = np.linspace(-0.3, 0.3, n + 1)
    grid = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    top = 0.25 - 0.15 * (grid**2).sum(axis=1)
    upper = np.column_stack([grid, top])
    lower = np.column_stack([grid, np.zeros(len(grid))])
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    up = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    faces = [up, up[:, ::-1] + len(grid)]
    rim = np.concatenate([at[:, 0], at[-1, 1:], at[-2::-1, -1], at[0, -2:0:-1]])
    nxt = np.roll(rim, -1)
    faces += [
        np.column_stack([rim, rim + len(grid), nxt]),
        np.column_stack([nxt, rim + len(grid), nxt + len(grid)]),
    ]
    return trimesh.Trimesh(np.concatenate([upper, lower]), np.concatenate(faces), process=False)


def sunk(pitch, shape, height):
    """How far a thing sinks into the middle of the seat [m]."""
    scene = Scene()
    scene.add_static("sofa", seat(pitch), soft=soft(1e5, 5e3, thickness=0.1))
    scene.add_object("thing", shape, mass=12.0, position=(0.013, 0.007, 0.25 + height))
    result = run(scene, 1.2)
    return 0.25 + height - result.height[-1]


def test_the_seat_is_closed():
    import trimesh

    one = seat(0.05)
    assert isinstance(one, trimesh.Trimesh)
    assert one.is_watertight
    assert one.volume > 0.0


@pytest.mark.parametrize(("shape", "height"), [(Sphere(0.12), 0.12), (Box((0.3, 0.2, 0.1)), 0.05)])
def test_remeshing_the_sofa_changes_nothing(shape, height):
    """Faces of 1 to 5 cm: the same sink within 3 %."""
    depths = {pitch: sunk(pitch, shape, height) for pitch in (0.01, 0.02, 0.035, 0.05)}
    finest = depths[0.01]
    assert 0.01 < finest < 0.09
    for pitch, depth in depths.items():
        assert depth == pytest.approx(finest, rel=0.03), pitch


def test_a_mesh_is_as_soft_as_the_box_that_it_is():
    import trimesh

    ends = []
    for shape in (Box((0.8, 0.8, 0.3)), trimesh.creation.box((0.8, 0.8, 0.3))):
        scene = Scene()
        scene.add_static("seat", shape, position=(0, 0, -0.15), soft=soft(1e5, 3e3, thickness=0.1))
        scene.add_object("ball", Sphere(0.12), mass=12.0, position=(0.05, 0.02, 0.12))
        ends.append(run(scene, 1.2).poses[-1])
    depths = [0.12 - end[2] for end in ends]
    assert depths[0] == pytest.approx(depths[1], rel=0.01)


@pytest.mark.parametrize("law", ["linear", "foam"])
def test_a_scene_turned_and_moved_gives_the_same(law):
    """Gravity, layer and things turned and moved together: to a hundredth of a millimetre.

    What foam remembers is kept in cells along the world's axes: half a millimetre.
    """
    ends = []
    turns = [np.zeros(3), np.array([0.4, -0.7, 1.1])]
    for turn, shift in zip(turns, (np.zeros(3), np.array([3.0, -2.0, 1.0])), strict=True):
        q = rot.exp(turn)
        scene = Scene(gravity=rot.rotate(q, [0.0, 0.0, -9.81]))
        scene.add_static(
            "seat",
            Box((1.0, 1.0, 0.3)),
            position=shift + rot.rotate(q, [0.0, 0.0, -0.15]),
            quaternion=q,
            soft=soft(5e4, 800.0, law=law),
        )
        scene.add_object(
            "box",
            Box((0.2, 0.15, 0.1)),
            mass=5.0,
            position=shift + rot.rotate(q, [0.0, 0.0, 0.12]),
            quaternion=rot.multiply(q, rot.exp([0.2, 0.1, 0.0])),
            velocity=rot.rotate(q, [0.5, 0.0, 0.0]),
        )
        result = run(scene, 0.8)
        ends.append(rot.rotate(rot.conjugate(q), result.poses[:, :3] - shift))
    assert np.abs(ends[0] - ends[1]).max() < (5e-4 if law == "foam" else 1e-5)

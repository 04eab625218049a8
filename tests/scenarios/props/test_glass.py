"""A hollow wine glass with stem and foot, in one hand: as its own wedges and cut by coacd."""

from __future__ import annotations

import os
from functools import cache

import numpy as np
import pytest
import trimesh

from evidence.runs.grasping import judge
from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, RIGHT_HAND_JOINTS
from halfphysics.scenarios.props.lathe import turn
from halfphysics.scenarios.props.vessels import vessel
from halfphysics.scenarios.stories import grasp_glass
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.grasp_limits import (
    CREEP,
    FALL,
    FORCE,
    FREED,
    JITTER,
    PEAK,
    SETTLED,
    SLIP,
    SPREAD,
    TURN,
)

pytestmark = pytest.mark.slow

RATES = (30.0, 120.0)
CUP = [[0.0, 0.04, 0.0], [0.01, 0.05, 0.0], [0.01, 0.05, 0.045], [0.1, 0.06, 0.055]]


@cache
def played(fps):
    sequence, times = grasp_glass.planned(shape="wine", fps=fps)
    result = simulate(sequence.motion, sequence.scene, body=sequence.body)
    return sequence, times, result, judge(result, sequence.body)


def judged(times, grasp):
    """Conditions on any held glass; the force may differ where the bowl narrows."""
    begin, end = times["grasp"][1], times["open"][0]
    assert grasp.slip(begin, end) <= SLIP
    assert grasp.turned(begin, end) <= TURN
    assert FORCE[0] <= grasp.force(begin, end)[0] <= FORCE[1]
    assert grasp.force(begin, end)[2] <= PEAK
    assert grasp.freed(end) <= FREED
    assert np.abs(grasp.fall(end) + 9.81).max() <= FALL


@pytest.mark.parametrize("fps", RATES)
def test_it_stays_in_the_hand_until_that_opens(fps):
    _, times, _, grasp = played(fps)
    judged(times, grasp)
    still = (times["hold"][0] + SETTLED, times["hold"][1])
    assert grasp.force(*still)[1] <= SPREAD
    assert grasp.jitter(*still) <= JITTER
    assert grasp.creep(*still) <= CREEP
    assert grasp.world[-1, 2] < 0.2  # it fell


def test_it_is_turned_upside_down():
    _, times, result, grasp = played(30.0)
    upright = rot.to_matrix(result.objects["glass"].quaternion)[:, 2, 2]
    assert upright[grasp.rows(*times["turn"])].min() < -0.95


def test_the_hand_never_enters_the_wall():
    sequence, _, result, _ = played(30.0)
    part = np.argmax(sequence.body.weights, axis=1)
    hand = np.flatnonzero(np.isin(part, [JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS]))
    skin = sequence.body.vertices(result.motion, indices=hand)
    track = result.objects["glass"]
    local = (skin - track.position[:, None]) @ rot.to_matrix(track.quaternion)
    near = local[np.linalg.norm(local, axis=-1) < 0.15]
    assert sequence.scene.objects["glass"].shape.depth(near).max() == 0.0


def test_its_pieces_are_the_glass():
    made = vessel("wine")
    mesh = trimesh.Trimesh(made.shape.vertices, made.shape.faces, process=False)
    assert mesh.is_watertight
    assert not mesh.is_convex
    volume = sum(trimesh.Trimesh(p.vertices, p.faces).volume for p in made.pieces)
    np.testing.assert_allclose(volume, mesh.volume, rtol=1e-9)
    error = played(30.0)[0].scene.objects["glass"].decomposition
    assert max(error.outside_mm, error.inside_mm) < 1e-6


def test_its_inertia_is_that_of_the_hollow_glass():
    made = played(30.0)[0].scene.objects["glass"]
    mesh = trimesh.Trimesh(made.shape.vertices, made.shape.faces, process=False)
    np.testing.assert_allclose(made.com, mesh.center_mass, atol=1e-9)
    mesh.density = made.mass / mesh.volume
    np.testing.assert_allclose(made.inertia, mesh.moment_inertia, rtol=1e-6, atol=1e-12)


def test_a_cup_as_pieces():
    cup = turn(CUP, sides=12)
    assert len(cup.pieces) == 1 + 12
    assert cup.mesh.closed
    inside, wall = (
        [0.0, 0.0, 0.05],
        [0.0525 * np.cos(np.pi / 12), 0.0525 * np.sin(np.pi / 12), 0.05],
    )
    assert (cup.mesh.depth([inside, wall]) > 0.0).tolist() == [False, True]


@pytest.mark.skipif(not os.environ.get("HALFPHYSICS_LONG"), reason="cutting takes a minute")
def test_coacd_cuts_a_glass_that_is_held_as_well():
    pytest.importorskip("coacd")
    sequence, times = grasp_glass.planned(shape="wine", stages=("lift", "shake", "turn", "open"))
    glass, scene = sequence.scene.objects["glass"], Scene()
    for name, static in sequence.scene.statics.items():
        scene.add_static(name, static.shape, position=static.position, friction=static.friction)
    scene.add_object("glass", glass.shape, mass=0.3, friction=0.8, position=glass.position)
    result = simulate(sequence.motion, scene, body=sequence.body)
    judged(times, judge(result, sequence.body))


@pytest.mark.parametrize(
    ("profile", "message"),
    [
        ([[0.0, 0.1]], "rows of height, outer and inner radius"),
        ([[0.0, 0.1, 0.0], [-1.0, 0.1, 0.0]], "heights that rise"),
        ([[0.0, 0.1, 0.0], [1.0, 0.1, 0.2]], "outer radii larger"),
        ([[0.0, 0.1, 0.0], [1.0, 0.1, 0.05]], "give the height of the floor twice"),
    ],
)
def test_profiles_that_are_none(profile, message):
    with pytest.raises(InputError, match=message):
        turn(profile)


def test_unknown_shapes_are_said():
    with pytest.raises(InputError, match="shape: found 'bottle', expected 'tumbler' or 'wine'"):
        scenarios.load("grasp_glass", shape="bottle")

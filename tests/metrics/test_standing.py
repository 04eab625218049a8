"""The summary's lines about standing: the numbers of the measures, and what is left out."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Plane
from halfphysics.metrics.standing import SAMPLED, standing
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.people import t_pose
from support.results.random_result import touching

FRAMES = 40


def stood(frames=FRAMES, floor=True):
    scene = Scene()
    if floor:
        scene.add_static("floor", Plane())
    low = Body.default().vertices(t_pose(np.zeros((2, 3))), 0)[:, 2].min()
    return simulate(t_pose(np.tile([0.0, 0.0, 0.002 - low], (frames, 1))), scene)


@pytest.fixture(scope="module")
def still():
    return stood()


def test_who_stands_still(still):
    assert standing(still, 0) == [
        "floats in 0 % of the frames, by 0 mm at most; reference: 0 %",
        "feet in stance slide 0.00 mm a frame, 0.0 mm at most; reference: 0.00 mm",
    ]


def test_who_is_lifted_slides_and_leans(still):
    person = still.people[0]
    rotations = person.motion.rotations.copy()
    lean = rot.exp([0.0, np.deg2rad(2.0), 0.0])
    rotations[-1, 0] = rot.log(rot.multiply(lean, rot.exp(rotations[-1, 0])))
    path = person.motion.translation.copy()
    path[:, 0] += 0.003 * np.arange(FRAMES)
    path[FRAMES // 2 :, 2] += 0.04
    moved = dataclasses.replace(person, motion=person.motion.with_frames(path, rotations))
    hit = touching([5], [JOINT_INDEX["head"]], [0], [[0.0, 0.0, 40.0]])
    result = dataclasses.replace(still, people=(moved,), contacts=hit)
    force = metrics.net_force(result)
    lines = standing(result, 0)
    assert lines[0].startswith("floats in 50 % of the frames, by 4")
    assert lines[0].endswith("reference: 0 %")
    weight = metrics.unsupported_weight(result)
    assert 45.0 < weight.percent < 55.0
    assert lines[1] == (
        f"held up by nothing in {weight.percent:.0f} % of the frames, by "
        f"{weight.missing.max():.0f} % of the weight at most"
    )
    assert lines[2].startswith("feet in stance slide 3.")
    assert lines[3] == (
        f"net force of contacts {force.peak_weights:.2f} body weights at most, 0.00 held for 50 ms"
    )
    up = metrics.path_offset(result).end_height_mm
    assert up == pytest.approx(40.0, abs=1.0)
    assert lines[4] == (
        f"ends 117 mm beside its path and {up:.0f} mm above, tilted by 2.0°; tilted by 2.0° at most"
    )
    assert set(lines) <= {line.strip() for line in result.summary().splitlines()}


def test_no_floor_no_floating():
    assert standing(stood(floor=False), 0) == []


def test_a_long_result_is_sampled():
    result = stood(3 * SAMPLED + 1)
    assert standing(result, 0)[0] == "floats in 0 % of the frames, by 0 mm at most; reference: 0 %"

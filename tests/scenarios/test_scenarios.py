"""Scenarios: the penetrations of their references, and how they are built."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.errors import InputError
from halfphysics.metrics.airborne import airborne
from halfphysics.metrics.range_violations import TOLERANCE
from halfphysics.metrics.unsupported import unsupported_from
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.scenarios.props import stage
from halfphysics.support.estimate import estimate

#: How far a joint of a reference may be beyond its range [degrees]: that of `range_violations`.
RANGE = TOLERANCE
#: Joints beyond it, and how far [degrees]: the hand is behind an open lid, before the chest, with
#: the elbow bent to its end and the wrist to its side. With the laptop farther away the arm is too
#: short for the lid; with other elbows and fingers the hand jerks, or pushes too hard.
BEYOND = {("close_laptop", "right_wrist"): 34.0, ("close_laptop", "right_elbow"): 2.5}
#: Frames not in a jump in which over 5 % of the weight may be unsupported [%]: as the limit of
#: `support.ground.limits`. Only `climb_onto_bed` has more than 1: a leg is thrown onto the bed.
UNSUPPORTED = 5.0
#: Scenario -> the option that says how far a body goes into something, its least and its most.
BOUNDS = {
    "climb_onto_bed": ("sink", 0.04, 0.12),
    "crawl_under_table": ("hunch", 0.0, 0.075),
    "fly_with_ball": ("squeeze", 0.0, 0.08),
    "sit_on_bed": ("sink", 0.0, 0.1),
    "sit_on_sofa": ("sink", 0.0, 0.15),
    "step_back_onto_cabinet": ("sink", 0.0, 0.15),
    "stretch_on_bed": ("sink", 0.0, 0.12),
}
#: Who flies on purpose, without weight.
IN_THE_AIR = {"fly_with_ball"}


def depths(sequence, name: str, frames: range | None = None, person: int = 0) -> np.ndarray:
    """Depth of every skin vertex inside one item of the scene [m], (frames, V)."""
    thing = sequence.scene.statics.get(name) or sequence.scene.objects[name]
    motion = sequence.motions[person]
    frames = range(len(motion)) if frames is None else frames
    skin = sequence.bodies[person].vertices(motion, frames=frames)
    local = (skin - thing.position) @ rot.to_matrix(thing.quaternion)
    return np.stack([thing.shape.depth(points) for points in local])


def parts_inside(sequence, depth: np.ndarray) -> set[int]:
    part = np.argmax(sequence.body.weights, axis=1)
    return set(part[(depth > 0.0).any(axis=0)].tolist())


@pytest.fixture(scope="module")
def doorway():
    return scenarios.load("doorway")


@pytest.mark.slow
@pytest.mark.parametrize("name", scenarios.names())
def test_every_scenario_starts_clear_and_walks_on_the_floor(name):
    sequence = scenarios.load(name)
    assert scenarios.describe(name).endswith(".")
    for person, (motion, body) in enumerate(zip(sequence.motions, sequence.bodies, strict=True)):
        for thing in (*sequence.scene.statics, *sequence.scene.objects):
            assert depths(sequence, thing, range(1), person).max() <= 0.0
        lowest = body.vertices(motion)[..., 2].min()
        assert lowest > 2.0 * sequence.settings.clearance  # walking itself is undisturbed


@pytest.mark.parametrize("name", scenarios.names())
def test_what_a_person_is_asked_is_humanly_possible(name):
    """References walk, sit and reach into things, but joints turn as far as joints do, and nobody
    leans on the air.
    """
    check_possible(name, scenarios.load(name))


@pytest.mark.parametrize("name", BOUNDS)
def test_what_an_option_allows_is_humanly_possible(name):
    option, least, most = BOUNDS[name]
    for value in (least, most):
        check_possible(name, scenarios.load(name, **{option: value}))
    for value in (least - 1e-6, most + 1e-6, np.nan, "deep"):
        with pytest.raises(InputError, match=f"^{option}: expected a number from {least:g} to"):
            scenarios.load(name, **{option: value})


def check_possible(name, sequence):
    for motion, body in zip(sequence.motions, sequence.bodies, strict=True):
        ranges = JointRanges.of(body)
        angles = ranges.angles(motion.rotations)
        beyond = np.degrees(np.maximum(ranges.lower - angles, angles - ranges.upper)).max(axis=2)
        most = np.full(len(JOINT_NAMES), RANGE)
        for (story, joint), degrees in BEYOND.items():
            if story == name:
                most[JOINT_INDEX[joint]] = degrees
                assert beyond[:, JOINT_INDEX[joint]].max() > RANGE, "stale"
        worst = int((beyond.max(axis=0) - most).argmax())
        assert (beyond.max(axis=0) <= most).all(), (JOINT_NAMES[worst], beyond[:, worst].max())
        missing = np.nan_to_num(estimate(motion, sequence.scene, body=body).residual_percent)
        report = unsupported_from(np.maximum(missing, 0.0), airborne(motion, body))
        if name in IN_THE_AIR:
            assert report.percent > UNSUPPORTED, "stale"
        else:
            assert report.percent <= UNSUPPORTED


def test_the_story_is_told_in_order(doorway):
    deep = {name: depths(doorway, name) for name in ("right_jamb", "table", "ball")}
    first = [int(np.flatnonzero((depth > 0.0).any(axis=1))[0]) for depth in deep.values()]
    assert first == sorted(first)
    assert 8.0 <= doorway.motion.duration <= 10.0
    # Deep enough to be seen, not so deep that going on is hopeless. The table top is 4 cm
    # thick: no depth exceeds half of that.
    assert 0.03 < deep["right_jamb"].max() < 0.10
    assert 0.015 < deep["table"].max() <= 0.02
    right_arm = {JOINT_INDEX[f"right_{n}"] for n in ("shoulder", "elbow", "wrist")}
    met = parts_inside(doorway, deep["right_jamb"])
    assert right_arm <= met
    assert JOINT_INDEX["head"] not in met
    assert JOINT_INDEX["left_hip"] in parts_inside(doorway, deep["table"])
    met = parts_inside(doorway, deep["ball"])  # the other foot passes it by
    assert JOINT_INDEX["right_foot"] in met
    assert met <= {JOINT_INDEX[f"right_{n}"] for n in ("knee", "ankle", "foot")}
    for thing in ("left_jamb", "lintel"):
        assert depths(doorway, thing, range(50, 90)).max() <= 0.0


def test_the_ball_is_touched_when_the_foot_is_fast(doorway):
    ball = depths(doorway, "ball", range(140, 180))
    first = 140 + int(np.flatnonzero((ball > 0.0).any(axis=1))[0])
    toe = doorway.body.joints(doorway.motion)[:, JOINT_INDEX["right_foot"]]
    speed = np.linalg.norm(np.diff(toe, axis=0), axis=1) * doorway.motion.fps
    assert speed[first] > 0.8 * speed.max()
    direction = toe[first] - toe[first - 1]
    assert direction[0] > 0.9 * np.linalg.norm(direction)


def test_options_reach_the_scene():
    sequence = scenarios.load("kick_ball", mass=2.0, friction=0.1, fps=60)
    ball = sequence.scene.objects["ball"]
    assert (ball.mass, ball.friction) == (2.0, 0.1)
    assert np.isclose(ball.position[2], stage.BALL_RADIUS)
    assert sequence.motion.fps == 60.0
    slow = scenarios.load("kick_ball", fps=30)
    assert np.allclose(slow.scene.objects["ball"].position, ball.position)  # the same ball
    wall = scenarios.load("walk_into_wall", speed=1.0, thickness=0.02).scene.statics["wall"]
    assert wall.shape.size[0] == 0.02
    assert scenarios.options("kick_ball")["mass"] == 0.43


def test_the_wall_is_walked_through_at_the_speed_asked():
    sequence = scenarios.load("walk_into_wall", speed=1.5, fps=30)
    pelvis = sequence.body.joints(sequence.motion)[:, 0, 0]
    at = int(np.argmax(pelvis > 2.0))
    assert 0 < at < len(pelvis) - 1
    assert abs((pelvis[at + 1] - pelvis[at - 1]) * 15.0 - 1.5) < 0.03


def test_unknown_names_and_options_are_named():
    with pytest.raises(InputError, match=r"scenario: found 'dorway', expected one of .*doorway"):
        scenarios.load("dorway")
    with pytest.raises(InputError, match="unknown option 'weight', expected one of fps, mass"):
        scenarios.load("doorway", weight=3)


@pytest.mark.parametrize("name", scenarios.names())
@pytest.mark.parametrize("fps", [np.nan, np.inf, 0.0, -1.0, 1e9, "fast"])
def test_impossible_rates_are_refused_before_anything_is_built(name, fps):
    with pytest.raises(InputError, match=r"^fps: found .*, expected (a positive|at most 10000)"):
        scenarios.load(name, fps=fps)


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("jump_on_bed", {"jumps": 1.5}, "jumps: found 1.5, expected 1 to 20, a whole number"),
        ("jump_on_bed", {"jumps": True}, "jumps: found True"),
        ("jump_on_bed", {"jumps": 21}, "jumps: found 21"),
        ("shake_hands", {"shakes": 2.5}, "shakes: found 2.5, expected 0 to 50, a whole number"),
        ("shake_hands", {"shakes": -1}, "shakes: found -1"),
        ("grasp_glass", {"hold": 1e9}, r"hold: expected a number from 0 to 60 \[s\]"),
    ],
)
def test_impossible_counts_and_times_are_refused(name, options, said):
    with pytest.raises(InputError, match=f"^{said}"):
        scenarios.load(name, **options)

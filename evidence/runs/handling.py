"""Objects handled or kicked by a person: the runs of Figure 5 and their measures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from evidence.model import Outcome
from evidence.runs import grasping, lifting, playing
from halfphysics import scenarios
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.stories import grasp_glass, place_glass
from halfphysics.simulation.sequence import Sequence

Values = Mapping[str, Any]

#: Gravity [m/s^2].
GRAVITY = 9.81


def grasp(options: Values, choice: Values, strip: bool, quick: bool) -> Outcome:
    """A glass in one hand, until the hand opens."""
    sequence, times = grasp_glass.planned(**options)
    return _glass(sequence, times, choice, strip, quick)


def drop(options: Values, choice: Values, strip: bool, quick: bool) -> Outcome:
    """A glass is released above the place of a removed table."""
    sequence, times = place_glass.planned(**options)
    return _glass(sequence, times, choice, strip, quick)


def _glass(
    sequence: Sequence,
    times: Mapping[str, tuple[float, float]],
    choice: Values,
    strip: bool,
    quick: bool,
) -> Outcome:
    result = playing.run(sequence, choice)
    found = grasping.judge(result, result.people[0].body)
    begin, end = times["grasp"][1], times["open"][0]
    freed = found.freed(end)
    fall = found.fall(end) if np.isfinite(freed) else np.empty(0)
    values = {
        "slip": found.slip(begin, end),
        "turn": found.turned(begin, end),
        "force": found.force(begin, end)[0],
        "rise": float(1e3 * (found.world[:, 2].max() - found.world[0, 2])),
        "freed": float(freed) if np.isfinite(freed) else None,
        "fall": float(-fall.mean()) if len(fall) else None,
        "fall_error": float(np.abs(fall + GRAVITY).max()) if len(fall) else None,
        "deepest": playing.penetration(result, quick=quick).depth_max_mm,
    }
    opened = round(end * result.fps)
    frames = [opened, len(result) - 1]
    if not quick:
        frames = [round(begin * result.fps), opened, opened + 10, len(result) - 1]
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick, frames=frames))


def lift(options: Values, choice: Values, strip: bool, quick: bool) -> Outcome:
    """A suitcase between two palms."""
    result = playing.play("lift_suitcase", options, choice)
    return Outcome(
        values=lifting.judged(result, quick=quick),
        pictures=playing.strip(result, strip, quick=quick),
    )


def kick(options: Values, choice: Values, strip: bool, quick: bool) -> Outcome:
    """A ball that is kicked."""
    result = playing.play("kick_ball", options, choice)
    track = result.objects["ball"]
    turned = playing.joint_angles(result.reference, result.motion).max(axis=0)
    speed = playing.object_speed(result, "ball")
    at = playing.first_touch(result, "ball")
    values = {
        "speed": float(speed.max()),
        "speeds": speed.tolist(),
        "fps": result.fps,
        "height": float(np.ptp(track.position[:, 2])),
        "moved": float(np.linalg.norm(track.position - track.position[0], axis=1).max()),
        "ankle": float(turned[JOINT_INDEX["right_ankle"]]),
        "deepest": playing.penetration(result, quick=quick).depth_max_mm,
    }
    frames = [at - 1, at + 1] if quick else [at - 2, at, at + 1, at + 4]
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick, frames=frames))


def monitor(options: Values, choice: Values, strip: bool, quick: bool) -> Outcome:
    """An object without contact, compared with a run in which the person stands still."""
    sequence = scenarios.load("reach_past_monitor", **options)
    motion = sequence.motions[0]
    result = playing.run(sequence, choice)
    still = motion.with_frames(
        np.repeat(motion.translation[:1], len(motion), axis=0),
        np.repeat(motion.rotations[:1], len(motion), axis=0),
    )
    alone = playing.run(Sequence(still, sequence.scene, sequence.body), choice)
    pairs = [(result.objects[k], alone.objects[k]) for k in result.objects]
    different = sum(
        int((a.position != b.position).sum() + (a.quaternion != b.quaternion).sum())
        for a, b in pairs
    )
    moved = max(float(np.abs(a.position - a.position[0]).max()) for a, _ in pairs)
    values = {
        "moved": moved,
        "different": different,
        "deepest": playing.penetration(result, quick=quick).depth_max_mm,
    }
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick))


def jointed(
    scenario: str, joint: str, options: Values, choice: Values, strip: bool, quick: bool
) -> Outcome:
    """An articulated object that a hand moves."""
    result = playing.play(scenario, options, choice)
    values = {
        "end": float(result.joints[joint][-1]),
        "deepest": playing.penetration(result, quick=quick).depth_max_mm,
    }
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick))

"""Scenarios in which hands hold an object: a suitcase between two palms, a glass in one hand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.bench.clips import body
from halfphysics.bench.pressing import Play, pressed
from halfphysics.bench.record import Options, Record
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.stories.lift_suitcase import UP

Array = NDArray[np.float64]

#: Position (T, 3) and quaternion (T, 4) of the hand or hands that hold an object.
Holder = Callable[[Motion], tuple[Array, Array]]

#: Stages of the motion in which the hand holds the glass.
STAGES = ("lift", "shake", "walk", "turn")
#: Time at which the glass is lifted [s]; frames of each scenario in a quick run.
_UP, _QUICK_LIFT, _QUICK_GLASS = 3.2, slice(0, 75), slice(39, 100)


def lift(options: Options) -> Iterator[Record]:
    """A suitcase of 5 kg between two flat palms, both drives."""
    yield from _handled("lift", "5 kg", "lift_suitcase", {}, _between, UP, _QUICK_LIFT, options)


def glass(options: Options) -> Iterator[Record]:
    """A glass of 0.3 kg in one hand, both drives."""
    chosen = {"stages": STAGES}
    yield from _handled(
        "glass", "0.3 kg", "grasp_glass", chosen, _in_hand, _UP, _QUICK_GLASS, options
    )


def _handled(
    case: str,
    name: str,
    scenario: str,
    chosen: dict[str, Any],
    holder: Holder,
    up: float,
    quick: slice,
    options: Options,
) -> Iterator[Record]:
    play = played(scenario, **chosen)
    motion = play.motion
    first = round(up * motion.fps)
    if options.quick:
        motion, first = motion[quick], first - quick.start
    (item,) = play.scene.objects
    for record, result, moved in pressed(
        case, name, Play(motion=motion, scene=play.scene), options
    ):
        sides = [(m, objects[item]) for m, objects in ((result.motion, result.objects), moved)]
        ours, theirs = (slip(*holder(m), track, first) for m, track in sides)
        rise, its_rise = (1000.0 * float(np.ptp(track.position[:, 2])) for _, track in sides)
        checks = {"lifted [mm]": (rise, its_rise), "slip [mm]": (ours, theirs)}
        yield replace(record, checks={**checks, **record.checks})


def played(scenario: str, **chosen: Any) -> Play:
    """The motion and the scene of a scenario of one person, told with options of its own."""
    told = scenarios.load(scenario, body=body(), **chosen)
    return Play(motion=told.motions[0], scene=told.scene)


def slip(position: Array, quaternion: Array, track: ObjectTrack, first: int) -> float:
    """Largest displacement of an object relative to its holder since frame `first` [mm]."""
    held = rot.rotate(rot.conjugate(quaternion), track.position - position)[first:]
    return 1000.0 * float(np.linalg.norm(held - held[0], axis=1).max())


def _between(motion: Motion) -> tuple[Array, Array]:
    """The midpoint of both wrists; the walk is straight, so its frame does not turn."""
    positions, _ = body().joint_frames(motion)
    wrists = [JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"]]
    return positions[:, wrists].mean(axis=1), np.tile([1.0, 0.0, 0.0, 0.0], (len(motion), 1))


def _in_hand(motion: Motion) -> tuple[Array, Array]:
    positions, quaternions = body().joint_frames(motion)
    wrist = JOINT_INDEX["right_wrist"]
    return positions[:, wrist], quaternions[:, wrist]

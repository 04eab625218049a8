"""A clip that presses on a scene, timed beside the peer: what the cases with contact share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halfphysics.bench.clips import SUBSTEPS, body, drives
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.record import Checks, Options, Record
from halfphysics.bench.timing import in_turns
from halfphysics.motion import Motion
from halfphysics.result import Result
from halfphysics.scene import Scene
from halfphysics.simulation import follow
from halfphysics.simulator import Simulator

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Play:
    """A motion, what it meets, and what that is for the peer.

    Attributes:
        motion: Of the default body.
        scene: Statics and objects.
        hulls: Name of a static mesh -> points of its convex pieces, for the peer.
    """

    motion: Motion
    scene: Scene
    hulls: Mapping[str, Sequence[Array]] = field(default_factory=dict)


def pressed(
    case: str, name: str, play: Play, options: Options
) -> Iterator[tuple[Record, Result, Array]]:
    """Both drives at stiffness 1 beside the peer.

    Yields:
        The record, our result, and the peer's coordinates (T, nq).
    """
    who, motion = body(), play.motion
    frames = len(motion) - 1
    peer = MujocoLoop(who, motion.fps, SUBSTEPS, play.scene, play.hulls)
    targets = peer.coordinates(motion.translation, motion.rotations, motion.axes)
    for label, settings in drives(SUBSTEPS, 1.0):
        simulator = Simulator(play.scene, body=who, settings=settings, fps=motion.fps)
        timing = in_turns(
            lambda s=simulator: follow(s, [motion]),  # type: ignore[misc]
            lambda: peer.play(targets),
            options,
        )
        result, theirs = timing.result, timing.peer_result
        checks: Checks = {
            "contacts per substep": (contacts(simulator, motion), peer.contacts(targets)),
            "penetration [mm]": (
                1000.0 * peer.deepest(coordinates(peer, result)),
                1000.0 * peer.deepest(theirs),
            ),
            "time lost [ms]": (1000.0 * float(result.lost_time.sum()), None),
            **solving(simulator, motion),
        }
        record = Record(
            case=case,
            setting=f"{name}, {label}",
            frames=frames,
            ours=timing.rates(frames),
            peer=timing.peer_rates(frames),
            checks=checks,
        )
        yield record, result, theirs


def coordinates(peer: MujocoLoop, result: Result) -> Array:
    """A result as the peer's coordinates (T, nq); objects are centred in their frames."""
    motion = result.motion
    qpos = peer.coordinates(motion.translation, motion.rotations, motion.axes)
    at = peer.model.nq - 7 * len(result.objects)
    for track in result.objects.values():
        qpos[:, at : at + 3] = track.position
        qpos[:, at + 3 : at + 7] = track.quaternion
        at += 7
    return qpos


def contacts(simulator: Simulator, motion: Motion) -> float:
    """Contact points that the solver has at once, mean over the frames of their largest number."""
    simulator.reset(motion[0])
    counts = [simulator.step(motion[t]).diagnostics["contacts"] for t in range(1, len(motion))]
    return float(np.mean(counts))


def solving(simulator: Simulator, motion: Motion) -> Checks:
    """Time of the contact solver per substep that has contacts [us], median and p95.

    Empty where the core keeps no times.
    """
    core = simulator.world.stepper
    if not hasattr(core, "keep_times"):
        return {}
    core.keep_times(True)
    try:
        follow(simulator, [motion])
        times = np.asarray(core.solve_times())
    finally:
        core.keep_times(False)
    times = times[times > 0.0]
    middle, high = 1e6 * np.percentile(times, [50, 95]) if len(times) else (0.0, 0.0)
    return {"solve median [us]": (float(middle), None), "solve p95 [us]": (float(high), None)}

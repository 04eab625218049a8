"""Nothing in the way: how fast a motion is followed, and how exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfphysics import metrics
from halfphysics.bench.clips import SUBSTEPS, body, clips, drives
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import measure, simulators
from halfphysics.motion import Motion
from halfphysics.simulation import follow
from halfphysics.simulator import Simulator

Array = NDArray[np.float64]

#: A side of a comparison: plays a clip and returns the motion that came of it.
Side = Callable[[], Motion]


def free(options: Options) -> Iterator[Record]:
    """Motion in, motion out."""

    def ours(simulator: Simulator, motion: Motion) -> Side:
        return lambda: follow(simulator, [motion]).motion

    def theirs(peer: MujocoLoop, motion: Motion) -> Side:
        return lambda: peer.run(motion)

    yield from _compared("free", ours, theirs, options)


def live(options: Options) -> Iterator[Record]:
    """Pose in, pose out, frame by frame."""

    def ours(simulator: Simulator, motion: Motion) -> Side:
        poses = [motion[t] for t in range(len(motion))]

        def play() -> Motion:
            came = [simulator.reset(poses[0]).pose]
            came += [simulator.step(pose).pose for pose in poses[1:]]
            return motion.with_frames(
                np.array([p.translation for p in came]), np.array([p.rotations for p in came])
            )

        return play

    def theirs(peer: MujocoLoop, motion: Motion) -> Side:
        poses = [motion[t] for t in range(len(motion))]

        def play() -> Motion:
            peer.reset(poses[0])
            came = [(poses[0].translation, poses[0].rotations)]
            came += [peer.step(pose) for pose in poses[1:]]
            return motion.with_frames(
                np.array([translation for translation, _ in came]),
                np.array([rotations for _, rotations in came]),
            )

        return play

    yield from _compared("live", ours, theirs, options)


def stepper(options: Options) -> Iterator[Record]:
    """The native core alone against the peer's loop alone; coordinates in, coordinates out."""
    who = body()
    for name, motion in clips(options):
        frames = len(motion) - 1
        for substeps in (1, SUBSTEPS):
            peer = MujocoLoop(who, motion.fps, substeps)
            targets = peer.coordinates(motion.translation, motion.rotations, motion.axes)
            for label, settings in drives(substeps, 0.0, 1.0):
                skin, parts = simulators(who, settings, motion.fps)
                yield measure(
                    "stepper",
                    f"{name}, N={substeps}, {label}",
                    frames,
                    options,
                    ours=core_loop(skin, motion),
                    parts=core_loop(parts, motion),
                    peer=lambda p=peer, t=targets: p.play(t),  # type: ignore[misc]
                ).record


def core_loop(simulator: Simulator, motion: Motion) -> Callable[[], Array]:
    """The core's loop over a motion, targets ready; returns the last coordinates (nq,)."""
    core = simulator.world.stepper
    targets = simulator.world.motion_coordinates([motion])
    start = simulator.world.start([motion[0]])
    dt, substeps = simulator.dt, simulator.settings.substeps_for(simulator.dt)

    def play() -> Array:
        core.reset(*start)
        for target in targets[1:]:
            core.frame(target, dt, substeps, False)
        last: Array = core.qpos()
        return last

    return play


def _compared(
    case: str,
    ours: Callable[[Simulator, Motion], Side],
    theirs: Callable[[MujocoLoop, Motion], Side],
    options: Options,
) -> Iterator[Record]:
    who = body()
    for name, motion in clips(options):
        for substeps in (1, SUBSTEPS):
            peer = theirs(MujocoLoop(who, motion.fps, substeps), motion)
            for label, settings in drives(substeps, 0.0, 1.0):
                skin, parts = simulators(who, settings, motion.fps)
                done = measure(
                    case,
                    f"{name}, N={substeps}, {label}",
                    len(motion) - 1,
                    options,
                    ours=ours(skin, motion),
                    parts=ours(parts, motion),
                    peer=peer,
                )
                mine, its = (metrics.mpjpe(m, motion, who) for m in (done.ours, done.peer))
                yield replace(done.record, checks={"MPJPE [mm]": (mine, its)})

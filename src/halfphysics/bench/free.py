"""Free motion without obstacles: the speed and accuracy of following a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfphysics import metrics
from halfphysics.bench.clips import SUBSTEPS, body, clips
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import driven, followed
from halfphysics.motion.motion import Motion
from halfphysics.simulation.simulator import Simulator

Array = NDArray[np.float64]

#: A side of a comparison: plays a clip and returns the simulated motion.
Side = Callable[[], Motion]


def free(options: Options) -> Iterator[Record]:
    """Whole motions: motion in, motion out."""

    def ours(simulator: Simulator, motion: Motion) -> Side:
        play = followed(simulator, motion)
        return lambda: play().motion

    def theirs(peer: MujocoLoop, motion: Motion) -> Side:
        return lambda: peer.run(motion)

    yield from _compared("free", ours, theirs, options)


def live(options: Options) -> Iterator[Record]:
    """Single poses: pose in, pose out, frame by frame."""

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
    for name, motion in clips(options):
        for substeps in (1, SUBSTEPS):
            peer = MujocoLoop(body(), motion.fps, substeps)
            for _, done in driven(
                "stepper",
                f"{name}, N={substeps}",
                motion,
                options,
                ours=core_loop,
                peer=peer.player(motion),
                substeps=substeps,
                stiffness=(0.0, 1.0),
            ):
                yield done.record


def core_loop(simulator: Simulator, motion: Motion) -> Callable[[], Array]:
    """The core's loop over precomputed targets of a motion; returns the last coordinates (nq,)."""
    core = simulator.world.stepper
    targets = simulator.world.motion_coordinates([motion])
    simulator.world.reset([motion[0]])  # the firmness too, which the core keeps when it is reset
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
    person = body()
    for name, motion in clips(options):
        for substeps in (1, SUBSTEPS):
            for _, done in driven(
                case,
                f"{name}, N={substeps}",
                motion,
                options,
                ours=ours,
                peer=theirs(MujocoLoop(person, motion.fps, substeps), motion),
                substeps=substeps,
                stiffness=(0.0, 1.0),
            ):
                mine, its = (metrics.mpjpe(m, motion, person) for m in (done.ours, done.peer))
                yield replace(done.record, checks={"MPJPE [mm]": (mine, its)})

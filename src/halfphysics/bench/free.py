"""Nothing in the way: how fast a motion is followed, and how exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from halfphysics import metrics
from halfphysics.bench.clips import SUBSTEPS, body, clips, drives
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.record import Options, Record
from halfphysics.bench.timing import in_turns
from halfphysics.motion import Motion
from halfphysics.simulation import follow
from halfphysics.simulator import Simulator

Array = NDArray[np.float64]

#: One side of a comparison: plays a clip and returns the motion that came of it.
Side = Callable[[], Motion]


def free(options: Options) -> Iterator[Record]:
    """Motion in, motion out."""

    def sides(simulator: Simulator, peer: MujocoLoop, motion: Motion) -> tuple[Side, Side]:
        return lambda: follow(simulator, [motion]).motion, lambda: peer.run(motion)

    yield from _compared("free", sides, options)


def live(options: Options) -> Iterator[Record]:
    """Pose in, pose out, frame by frame."""

    def sides(simulator: Simulator, peer: MujocoLoop, motion: Motion) -> tuple[Side, Side]:
        poses = [motion[t] for t in range(len(motion))]

        def ours() -> Motion:
            came = [simulator.reset(poses[0]).pose]
            came += [simulator.step(pose).pose for pose in poses[1:]]
            return motion.with_frames(
                np.array([p.translation for p in came]), np.array([p.rotations for p in came])
            )

        def theirs() -> Motion:
            peer.reset(poses[0])
            came = [(poses[0].translation, poses[0].rotations)]
            came += [peer.step(pose) for pose in poses[1:]]
            return motion.with_frames(
                np.array([translation for translation, _ in came]),
                np.array([rotations for _, rotations in came]),
            )

        return ours, theirs

    yield from _compared("live", sides, options)


def stepper(options: Options) -> Iterator[Record]:
    """The native core alone against the peer's loop alone; coordinates in, coordinates out."""
    who = body()
    for name, motion in clips(options):
        frames = len(motion) - 1
        for substeps in (1, SUBSTEPS):
            peer = MujocoLoop(who, motion.fps, substeps)
            targets = peer.coordinates(motion.translation, motion.rotations, motion.axes)
            for label, settings in drives(substeps, 0.0, 1.0):
                simulator = Simulator(body=who, settings=settings, fps=motion.fps)
                play = core_loop(simulator, motion)
                timing = in_turns(play, lambda p=peer, t=targets: p.play(t), options)  # type: ignore[misc]
                yield Record(
                    case="stepper",
                    setting=f"{name}, N={substeps}, {label}",
                    frames=frames,
                    ours=timing.rates(frames),
                    peer=timing.peer_rates(frames),
                )


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
    sides: Callable[[Simulator, MujocoLoop, Motion], tuple[Side, Side]],
    options: Options,
) -> Iterator[Record]:
    who = body()
    for name, motion in clips(options):
        frames = len(motion) - 1
        for substeps in (1, SUBSTEPS):
            peer = MujocoLoop(who, motion.fps, substeps)
            for label, settings in drives(substeps, 0.0, 1.0):
                simulator = Simulator(body=who, settings=settings, fps=motion.fps)
                timing = in_turns(*sides(simulator, peer, motion), options)
                yield Record(
                    case=case,
                    setting=f"{name}, N={substeps}, {label}",
                    frames=frames,
                    ours=timing.rates(frames),
                    peer=timing.peer_rates(frames),
                    checks={
                        "MPJPE [mm]": (
                            metrics.mpjpe(timing.result, motion, who),
                            metrics.mpjpe(timing.peer_result, motion, who),
                        )
                    },
                )

"""Something in the way: a T-pose walked into a thin wall."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from halfphysics import rotations as rot
from halfphysics.bench.clips import SUBSTEPS, body, drives, straight
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.pressing import contacts, solving
from halfphysics.bench.record import Options, Record
from halfphysics.bench.timing import in_turns
from halfphysics.scene import Scene
from halfphysics.shapes import Box
from halfphysics.simulation import follow
from halfphysics.simulator import Simulator

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.motion import Motion

#: Where the wall stands and its full size [m], the speed of walking [m/s] and for how long [s].
_AT, _SIZE = np.array([0.5, 0.0, 0.0]), np.array([0.01, 6.0, 6.0])
_SPEED, _START, _SECONDS = 1.5, -0.4, 2.0


def wall(options: Options) -> Iterator[Record]:
    """Both drives, limp to stiff."""
    who = body()
    motion = straight(_SPEED, _SECONDS, _START)
    if options.quick:
        motion = motion[:30]  # the wall is met in frame 15
    frames = len(motion) - 1
    scene = Scene()
    scene.add_static("wall", Box(tuple(_SIZE)), position=_AT)
    peer = MujocoLoop(who, motion.fps, SUBSTEPS, scene)
    for label, settings in drives(SUBSTEPS, 0.0, 1.0, 10.0):
        simulator = Simulator(scene, body=who, settings=settings, fps=motion.fps)
        timing = in_turns(
            lambda s=simulator: follow(s, [motion]),  # type: ignore[misc]
            lambda: peer.run(motion),
            options,
        )
        result = timing.result
        yield Record(
            case="wall",
            setting=f"N={SUBSTEPS}, {label}",
            frames=frames,
            ours=timing.rates(frames),
            peer=timing.peer_rates(frames),
            checks={
                "past the wall's face [mm]": (
                    past_face(who, result.motion),
                    past_face(who, timing.peer_result),
                ),
                "contacts per substep": (contacts(simulator, motion), None),
                "time lost [ms]": (1000.0 * float(result.lost_time.sum()), None),
                **solving(simulator, motion),
            },
        )


def past_face(body: Body, motion: Motion) -> float:
    """How far the rigid parts get beyond the face of the wall they walk at [mm], 0 if they do not.

    Over all frames and the vertices of the 55 parts, placed by the body's own kinematics: what a
    part that went through the wall adds counts too.
    """
    face = _AT[0] - 0.5 * _SIZE[0]
    positions, quaternions = body.joint_frames(motion)
    x_axis = rot.to_matrix(quaternions)[..., 0, :]
    deepest = 0.0
    for part in body.variant.parts:
        if len(part.vertices):
            x = x_axis[:, part.index] @ part.vertices.T + positions[:, part.index, :1]
            deepest = max(deepest, float(x.max()) - face)
    return 1000.0 * deepest

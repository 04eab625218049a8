"""Contact with an obstacle: a T-pose moved into a thin wall."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.bench.clips import SUBSTEPS, body, straight
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.pressing import Play, contacts, solving
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import driven, followed
from halfphysics.geometry.shapes import Box
from halfphysics.scene.scene import Scene

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

#: Position and full size of the wall [m]; speed [m/s], start [m] and duration [s] of the walk.
_AT, _SIZE = np.array([0.5, 0.0, 0.0]), np.array([0.01, 6.0, 6.0])
_SPEED, _START, _SECONDS = 1.5, -0.4, 2.0


def wall(options: Options) -> Iterator[Record]:
    """Records of both drives from low to high stiffness."""
    person, play = body(), walking()
    motion, scene = play.motion, play.scene
    if options.quick:
        motion = motion[:30]  # the wall is met in frame 15
    peer = MujocoLoop(person, motion.fps, SUBSTEPS, scene)
    for skin, done in driven(
        "wall",
        f"N={SUBSTEPS}",
        motion,
        options,
        ours=followed,
        peer=lambda: peer.run(motion),
        scene=scene,
        stiffness=(0.0, 1.0, 10.0),
    ):
        result = done.ours
        yield replace(
            done.record,
            checks={
                "past the face [mm]": (
                    past_face(person, result.motion),
                    past_face(person, done.peer),
                ),
                "contacts": (contacts(skin, motion), None),
                "time lost [ms]": (1000.0 * float(result.lost_time.sum()), None),
                **solving(skin, motion),
            },
        )


def walking() -> Play:
    """The motion, and the wall that it leads into."""
    scene = Scene()
    scene.add_static("wall", Box(tuple(_SIZE)), position=_AT)
    return Play(motion=straight(_SPEED, _SECONDS, _START), scene=scene)


def past_face(body: Body, motion: Motion) -> float:
    """Largest distance of the skin beyond the near face of the wall [mm], at least 0.

    It covers all frames and vertices, also vertices that went through the wall.
    """
    face = _AT[0] - 0.5 * _SIZE[0]
    result: float = 1000.0 * max(0.0, float(body.vertices(motion)[..., 0].max()) - face)
    return result

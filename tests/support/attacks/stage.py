"""An attack: people, their motions, a scene and settings; and what the families build them from.

A person of an attack faces +x. At the first frame the skin's box ends at x = 0 and z = 0 (a margin
before and below it holds the hulls and the clearance) and is centred about y = 0: what lies beyond
`MARGIN` starts clear of everything.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from support.people import FACING_X

#: The faces of one triangle.
ALONE = np.array([[0, 1, 2]])
#: Distance from the skin's box at which scenery may begin [m].
MARGIN = 0.03


@dataclass
class Attack:
    """What is simulated: motions (one a person), a scene, changes of `Settings`, frame rate."""

    motions: list[Motion]
    scene: Scene
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def fps(self) -> float:
        return float(self.motions[0].fps)


@cache
def body() -> Body:
    """The default body, with its parts built."""
    person = Body.default()
    person.variant  # noqa: B018  made once, outside the clock
    return person


def person(
    rng, way=(1.0, 0.0, 0.0), speed=1.5, seconds=1.0, *, flail=0.0, lower=0.0, fps=30.0, far=None
):
    """A motion along `way` at `speed` [m/s].

    flail: Amplitude by which all joints swing [rad]. lower: Turn of the arms down from the T-pose
    [rad]. far: Distance after which the root stands still [m]; None: never.
    """
    frames = round(seconds * fps) + 1
    t = np.arange(frames) / fps
    phase = rng.uniform(0.0, 2 * np.pi, (55, 1)) + 2 * np.pi * np.outer(
        rng.uniform(0.5, 2.5, 55), t
    )
    size = flail * rng.normal(size=(55, 3)) * np.where(np.arange(55) < 22, 1.0, 0.4)[:, None]
    rotations = size[None] * np.sin(phase).T[:, :, None]
    rotations[:, JOINT_INDEX["left_shoulder"], 2] -= lower
    rotations[:, JOINT_INDEX["right_shoulder"], 2] += lower
    rotations[:, 0] = FACING_X
    gone = speed * t if far is None else np.minimum(speed * t, far)
    return placed(Motion(np.outer(gone, way), rotations, fps))


def placed(motion, at=(0.0, 0.0, 0.0)):
    """The motion moved so that its first skin ends at x = `at[0]` and z = `at[2]`."""
    skin = body().vertices(motion, frames=[0])[0]
    low, high = skin.min(axis=0), skin.max(axis=0)
    shift = np.array(at) - (high[0], 0.5 * (low[1] + high[1]), low[2])
    return motion.with_frames(motion.translation + shift, motion.rotations)


def turned(motion, angle, at):
    """The motion turned about the vertical, and placed at x, y, z of its middle and soles."""
    turn = rot.exp([0.0, 0.0, angle])
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(rotations[:, 0])))
    moved = motion.with_frames(rot.rotate(turn, motion.translation), rotations)
    skin = body().vertices(moved, frames=[0])[0]
    low, high = skin.min(axis=0), skin.max(axis=0)
    middle = 0.5 * (low + high)
    shift = np.array(at) - (middle[0], middle[1], low[2])
    return moved.with_frames(moved.translation + shift, rotations)


def joint_at(motion, name):
    """Where a joint is at the first frame (3,) [m]."""
    return body().joints(motion)[0, JOINT_INDEX[name]]


def clear_of_start(motion, triangles, margin=0.003):
    """Those of the triangles (n, 3, 3) that are farther than `margin` from all pieces of the first
    pose, by coal."""
    import coal

    from halfphysics.simulation.simulator import Simulator
    from support.judges.person_hulls import pieces_of
    from support.judges.skin_judge import _tree as tree

    simulator = Simulator(body=body())
    start = simulator.world.start([motion[0]])[:1]
    low, high = triangles.min(axis=1) - margin, triangles.max(axis=1) + margin
    kept = np.ones(len(triangles), dtype=bool)
    for posed in (pieces.at(start) for pieces in pieces_of(simulator, "both")):
        for i in range(len(posed.pieces.names)):
            near = (low <= posed.high[0, i]) & (high >= posed.low[0, i])
            solid, here = posed.solid(i, 0), coal.Transform3s()
            for k in np.flatnonzero(near.all(axis=1) & kept):
                asked, found = coal.DistanceRequest(), coal.DistanceResult()
                kept[k] = (
                    coal.distance(*solid, tree(triangles[k], ALONE), here, asked, found) > margin
                )
    return triangles[kept]

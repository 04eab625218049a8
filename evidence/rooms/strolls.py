"""Motions like those of a generative model: people walk through rooms and use the furniture.

Straight walks of `scenarios.acting.gait` are bent along a path, acts are made as in
`scenarios.acting`, and both are blended. As in generated motions, feet slide in turns and places
are wrong by centimetres. World: z up, floor z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import Motion
from halfphysics.scenarios.acting.acting import SIDES, Act
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Radius of rounded corners of paths, about [m]; headings are smoothed over this time [s].
_ROUND, _CALM = 0.30, 0.20
#: Paths continue straight beyond their ends by this [m].
_BEYOND = 1.0
#: Time of the last turn of a walk, and of the blend from one motion to the next [s].
_TURN, _JOIN = 1.1, 0.5
_FINE = 0.01  # [m]


class Way:
    """A path on the floor through points (n, 2), with rounded corners."""

    def __init__(self, points: Array) -> None:
        from scipy.ndimage import gaussian_filter1d

        points = np.asarray(points, dtype=np.float64)
        first, last = points[0] - points[1], points[-1] - points[-2]
        ends = (
            points[0] + _BEYOND * first / np.linalg.norm(first),
            points[-1] + _BEYOND * last / np.linalg.norm(last),
        )
        corners = np.concatenate([ends[0][None], points, ends[1][None]])
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        count = int(along[-1] / _FINE) + 1
        fine = np.linspace(0.0, along[-1], count)
        line = np.stack([np.interp(fine, along, column) for column in corners.T], axis=1)
        wide = min(_ROUND, 0.25 * float(np.diff(along).min()))
        line = gaussian_filter1d(line, wide / _FINE, axis=0, mode="nearest")
        here = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        # Rounded corners are shorter; both ends are on straight pieces.
        starts = int(np.argmin(np.linalg.norm(line - points[0], axis=1)))
        stops = int(np.argmin(np.linalg.norm(line - points[-1], axis=1)))
        self._at, self._line = here - here[starts], line
        #: Length from the first to the last point [m].
        self.length = float(self._at[stops])

    def at(self, along: Array) -> Array:
        """Places (n, 2) at distances (n,) [m] along it."""
        return np.stack([np.interp(along, self._at, column) for column in self._line.T], axis=1)

    def heading(self, along: Array) -> Array:
        """Its direction (n,) [rad], without jumps of a whole turn."""
        step = self.at(along + 0.05) - self.at(along - 0.05)
        return np.unwrap(np.arctan2(step[:, 1], step[:, 0]))


def stroll(
    body: Body, way: Way, *, speed: float, facing: float | None = None, fps: float = 30.0
) -> Motion:
    """A walk along a path, from standing to standing; at its end the body turns to `facing`.

    Args:
        body: The body that walks.
        way: Path of the pelvis.
        speed: Speed of the pelvis [m/s].
        facing: Heading at the end [rad]; None: that of the path.
        fps: Frames per second.
    """
    from scipy.ndimage import gaussian_filter1d

    after = 0.3 if facing is None else 0.5
    straight = walk(body, Walk(distance=way.length, speed=speed, before=0.2, after=after), fps)
    first = np.asarray(body.rest_joints)[0]
    pelvis = straight.translation + first
    start = pelvis[0, 0]
    along, aside = pelvis[:, 0] - start, pelvis[:, 1]
    heading = gaussian_filter1d(way.heading(along), _CALM * fps, mode="nearest")
    if facing is not None:
        time = np.arange(len(along)) / fps
        part = ease((time - (time[-1] - _TURN - 0.05)) / _TURN)
        rest = (facing - heading[-1] + np.pi) % (2.0 * np.pi) - np.pi
        heading = heading + part * (heading[-1] + rest - heading)
    place = way.at(along)
    left = np.stack([-np.sin(heading), np.cos(heading)], axis=1)
    place = place + aside[:, None] * left
    turn = rot.exp(heading[:, None] * np.array([0.0, 0.0, 1.0]))
    rotations = straight.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(rotations[:, 0])))
    moved = np.column_stack([place, pelvis[:, 2]])
    return straight.with_frames(moved - first, rotations)


def then(motion: Motion, act: Motion, heading: float, body: Body) -> Motion:
    """A motion followed by one acted at the origin facing +x, moved to the place and turned."""
    first = np.asarray(body.rest_joints)[0]
    turn = rot.exp([0.0, 0.0, heading])
    pelvis = rot.rotate(np.broadcast_to(turn, (len(act), 4)), act.translation + first)
    last = motion.translation[-1] + first
    pelvis[:, :2] += last[:2] - pelvis[0, :2]
    rotations = act.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(rotations[:, 0])))
    count = min(len(act) - 1, round(_JOIN * motion.fps))
    part = ease(np.arange(1, count + 1) / count)
    pelvis[:count] = last + part[:, None] * (pelvis[:count] - last)
    rotations[:count] = rot.log(
        rot.slerp(
            rot.exp(np.broadcast_to(motion.rotations[-1], rotations[:count].shape)),
            rot.exp(rotations[:count]),
            part[:, None],
        )
    )
    return motion.with_frames(
        np.concatenate([motion.translation, pelvis - first]),
        np.concatenate([motion.rotations, rotations]),
    )


def sit(body: Body, top: float, sink: float, fps: float) -> Motion:
    """Sits down on a seat of height `top` with its edge 16 cm behind, and leans back."""
    act = Act(body)
    act.begin(turn=(0.0, 2.0, 0.0))
    sat = top + 0.115
    act.move(0.2, 1.1, turn=(0.0, 38.0, 0.0), bend=(18.0, 0.0, 0.0), nod=-18.0)
    act.move(0.2, 1.4, pelvis=(-0.40, 0.0, sat))
    act.move(0.2, 0.9, **act.both(arm=(0.36, 0.10, -0.28)))
    act.move(1.2, 1.1, turn=(0.0, -8.0, 0.0), bend=(4.0, 0.0, 0.0), nod=4.0)
    act.move(1.3, 1.1, pelvis=(-0.46, 0.0, sat - sink))
    act.move(2.0, 1.2, turn=(0.0, -20.0, 0.0), bend=(2.0, 0.0, 0.0), nod=16.0)
    act.move(1.9, 1.2, **act.both(arm=(0.26, 0.16, -0.36)))
    act.move(3.2, 1.0, bend=(10.0, 6.0, 0.0), nod=4.0)
    return act.motion(5.2, fps)


def lie(body: Body, top: float, sink: float, fps: float) -> Motion:
    """Sits down on the edge of a bed, slides in and lies back, the feet on the mattress."""
    act = Act(body)
    sat = top + 0.11 - sink
    act.move(0.2, 1.0, turn=(0.0, 34.0, 0.0), bend=(16.0, 0.0, 0.0), nod=-16.0)
    act.move(0.2, 1.3, pelvis=(-0.38, 0.0, sat + sink))
    act.move(1.1, 0.9, turn=(0.0, -6.0, 0.0), bend=(6.0, 0.0, 0.0), nod=4.0)
    act.move(1.2, 0.6, pelvis=(-0.42, 0.0, sat))
    act.move(2.0, 1.2, pelvis=(-0.80, 0.0, sat), turn=(0.0, -30.0, 0.0), knees=(0.4, 0.0, 1.0))
    for side, start in (("left", 2.0), ("right", 2.2)):
        y = SIDES[side]
        act.step(side, start, 1.3, (-0.10, 0.13 * y, top + 0.06), 0.10)
        act.move(start, 1.2, **{f"{side}_toes": (8.0 * y, 50.0, 0.0)})
    act.move(2.9, 1.2, turn=(0.0, -86.0, 0.0), bend=(0.0, 0.0, 0.0), nod=6.0)
    act.move(2.9, 1.2, pelvis=(-0.80, 0.0, top + 0.12 - sink))
    act.move(2.9, 1.2, **act.both(arm=(0.04, 0.30, -0.40)))
    act.move(4.2, 1.1, bend=(0.0, 8.0, 0.0), **act.both(arm=(0.10, 0.38, -0.20)))
    return act.motion(5.6, fps)


def reach(body: Body, top: float, sink: float, fps: float) -> Motion:
    """Reaches forward, one hand after the other, beyond the free space."""
    act = Act(body)
    high = float(np.clip(0.75 * top, 0.7, 1.35))
    act.begin(**act.both(hand=(0.35, 0.2, high), palm=(0.0, 0.0, 1.0)))
    act.move(0.2, 0.9, right_hold=1.0, right_hand=(0.52 + sink, -0.18, high), bend=(8.0, 0.0, 0.0))
    act.move(1.1, 0.9, left_hold=1.0, left_hand=(0.52 + sink, 0.25, 0.8 * high), nod=12.0)
    act.move(1.8, 0.8, right_hand=(0.50 + sink, 0.16, high - 0.1), bend=(14.0, 0.0, 6.0))
    act.move(2.6, 0.9, **act.both(hold=0.0), bend=(0.0, 0.0, 0.0), nod=0.0)
    return act.motion(3.7, fps)


def lean(body: Body, top: float, sink: float, fps: float) -> Motion:
    """Bends forward over the furniture and puts both hands on it."""
    act = Act(body)
    act.begin(**act.both(hand=(0.35, 0.2, top + 0.12), palm=(0.0, 0.0, 1.0)))
    act.move(0.2, 1.2, pelvis=(0.0, 0.0, act.standing - 0.04), turn=(0.0, 22.0, 0.0))
    act.move(0.2, 1.2, bend=(20.0, 0.0, 0.0), nod=10.0, **act.both(hold=1.0))
    act.move(0.9, 0.9, **act.both(hand=(0.48, 0.28, top + 0.05 - sink)))
    act.move(2.2, 0.9, right_hand=(0.62, 0.05, top + 0.05 - sink))
    return act.motion(3.6, fps)


def back(body: Body, top: float, sink: float, fps: float) -> Motion:
    """Leans back against the furniture and rests on it with the seat."""
    act = Act(body)
    act.move(0.3, 1.2, turn=(0.0, 22.0, 0.0), bend=(10.0, 0.0, 0.0))
    act.move(0.3, 1.4, pelvis=(-0.20 - sink, 0.0, min(top + 0.10, act.standing - 0.08)))
    act.move(1.8, 1.2, turn=(0.0, -14.0, 0.0), bend=(0.0, 0.0, 0.0), nod=8.0)
    act.move(1.5, 1.2, **act.both(arm=(-0.10, 0.22, -0.40)))
    return act.motion(3.6, fps)


#: Use of a kind of furniture: the act, whether the back faces it, and the distance of the body from
#: its edge [m].
USES: Mapping[str, tuple[Callable[[Body, float, float, float], Motion], bool, float]] = (
    MappingProxyType(
        {
            "sofa": (sit, True, 0.16),
            "armchair": (sit, True, 0.16),
            "chair": (sit, True, 0.16),
            "bed": (lie, True, 0.17),
            "table": (lean, False, 0.22),
            "desk": (lean, False, 0.22),
            "shelf": (reach, False, 0.34),
            "cabinet": (back, True, 0.15),
        }
    )
)

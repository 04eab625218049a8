"""Visits to furnished rooms: a path, and an act at its end.

Nothing here measures how deep a motion penetrates. Paths are like those of generated motions: they
go around the middle of furniture, but for a body that is thinner than people are; places to sit are
wrong by some centimetres, and the depth to which a body sinks in is drawn at random.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from evidence.rooms.layout import Footprint, Item, Room
from evidence.rooms.strolls import USES, Way, stroll, then
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Clearance at the start of a path [m].
_CLEAR = 0.55
#: Largest depth of the pelvis in furniture, and its smallest distance from walls [m].
_INTO, _OFF_WALLS = 0.15, 0.15
#: A path passes furniture if its middle comes as near as this [m].
_CLIPS = 0.25
_LENGTHS = (1.6, 4.2)
_TRIES = 200
#: Errors of the place where an act starts, to the front and to the side [m]; depths to which bodies
#: sink in and lean through [m].
_WRONG, _SINK = (0.06, 0.10), (0.14, 0.30)
_SPEED = (0.8, 1.3)


@dataclass(frozen=True, kw_only=True, eq=False)
class Visit:
    """A motion in a room, and the name of the item that it uses."""

    motion: Motion
    uses: str


def visit(room: Room, body: Body, number: int, seed: int = 0, fps: float = 30.0) -> Visit:
    """The reference motion of the test scene with a number: a walk, and an act at its end."""
    rng = np.random.default_rng([seed, number, 1])
    items = [item for item in room.items if item.kind in USES]
    seats = [item for item in items if item.kind in ("sofa", "bed", "armchair")]
    # In three of four scenes people sit or lie down.
    chosen = seats if seats and number % 4 != 3 else items
    item = chosen[int(rng.integers(len(chosen)))]
    act, backward, distance = USES[item.kind]
    wrong = rng.normal(0.0, _WRONG)
    spread = 0.25 * item.at.half[1]
    ahead = item.at.half[0] + distance + wrong[0]
    goal = item.at.world(np.array([[ahead, rng.uniform(-spread, spread) + wrong[1]]]))[0]
    facing = item.at.yaw + (0.0 if backward else np.pi)
    way = _way(rng, room, item, goal)
    speed = float(rng.uniform(*_SPEED))
    walked = stroll(body, way, speed=speed, facing=facing, fps=fps)
    acted = act(body, item.top, float(rng.uniform(*_SINK)), fps)
    return Visit(motion=then(walked, acted, facing, body), uses=item.name)


def _way(rng: np.random.Generator, room: Room, used: Item, goal: Array) -> Way:
    """A path to a place from a clear start; if possible, one that passes through furniture."""
    solid = [item.at for item in room.items if item.height > 0.3 and item.kind != "coffee_table"]
    spare = 0.5 * np.array(room.size) - _CLEAR
    outside = room.door + 0.7 * room.outward
    best: tuple[float, Array] | None = None
    for k in range(_TRIES):
        start = outside if k % 4 == 0 else rng.uniform(-spare, spare)
        if k % 4 and min(f.distance(start[None])[0] for f in _all(room)) < _CLEAR:
            continue
        points = [start]
        if k % 4 == 0:
            # Through the doorway, close to one of its jambs.
            aside = np.array([-room.outward[1], room.outward[0]]) * rng.uniform(-0.16, 0.16)
            points.append(room.door - 0.1 * room.outward + aside)
        if rng.random() < 0.5:
            points.append(rng.uniform(-spare, spare))
        points.append(goal)
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if steps.min() < 0.5 or not _LENGTHS[0] <= steps.sum() <= _LENGTHS[1]:
            continue
        way = Way(np.array(points))
        line = way.at(np.arange(0.0, way.length - 0.45, 0.05))
        near = [f.distance(line).min() for f in solid if f is not used.at]
        walls = min(f.distance(line).min() for f in room.walls)
        if min(near, default=np.inf) < -_INTO or walls < _OFF_WALLS:
            continue
        least = min(min(near, default=np.inf), walls)
        if least < _CLIPS:
            return way
        if best is None or least < best[0]:
            best = least, np.array(points)
    if best is None:  # no clear start but the goal
        inward = -goal / max(float(np.linalg.norm(goal)), 1e-9)
        best = 0.0, np.array([goal + 1.6 * inward, goal])
    return Way(best[1])


def _all(room: Room) -> list[Footprint]:
    return [*room.walls, *(item.at for item in room.items)]

"""People who walk where they are told, N at once: actors, each with eyes of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.actors.path import Point
from halfphysics.actors.person import Person
from halfphysics.actors.seen import Seen
from halfphysics.motion.pose import Pose

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.envs.worlds import Worlds

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Slower than this a walker is told to stand [m/s].
STANDS = 0.2
#: Fastest walk that can be told [m/s].
FASTEST = 1.5
#: How far ahead the place is that a walker is told to walk to [m].
_AHEAD = 4.0
#: A walker is told again where the way or the speed differs by more [m], [m/s].
_DIFFERS = 0.08


class Walkers:
    """N persons, each in the world of its number.

    Attributes:
        place: Of the pelvis, simulated (N, 2) [m].
        velocity: Its (N, 2) [m/s].

    Args:
        body: Of all of them.
        worlds: Where they walk; "person/pelvis" is watched there.
    """

    def __init__(self, body: Body, worlds: Worlds) -> None:
        self._worlds, count = worlds, worlds.count
        self._body = body
        self._actors: list[Person | None] = [None] * count
        self._targets = np.zeros((count, len(worlds.coordinates([_upright()]))))
        self._told = np.full((count, 3), np.nan)
        self.place, self.velocity = np.zeros((count, 2)), np.zeros((count, 2))
        self._time, self._pushed = np.zeros(count), np.zeros(count, dtype=bool)
        self._reaches = np.zeros(count, dtype=bool)

    def start(self, i: int, place: Array, heading: float, seed: int) -> Pose:
        """Person `i` stands at a place (2,) [m], facing `heading` [rad]."""
        person = Person(self._body, place=place, heading=heading)
        pose = person.reset(seed)
        self._actors[i], self._told[i] = person, np.nan
        self._targets[i] = self._worlds.coordinates([pose])
        self.place[i], self.velocity[i] = place, 0.0
        self._time[i], self._pushed[i], self._reaches[i] = 0.0, False, False
        return pose

    def settle(self, i: int) -> None:
        """Take in where person `i` stands, once its world has started."""
        self.place[i] = self._worlds.place("person/pelvis")[i, :2]

    def hands(self, points: Array, active: Flags) -> None:
        """Tell the right hands of active people where to reach (N, 3) [m]; NaN: nowhere."""
        for i in np.flatnonzero(active):
            person, (x, y, z) = self._actors[i], points[i]
            if person is None:
                continue
            if np.isfinite(x):
                person.reach("right", (float(x), float(y), float(z)))
                self._reaches[i] = True
            elif self._reaches[i]:
                person.withdraw("right")
                self._reaches[i] = False

    def tell(self, speed: Array, heading: Array, active: Flags) -> Array:
        """The targets (N, K) of the next frame.

        Args:
            speed: Wanted (N,) [m/s]; slower than 0.2: to stand.
            heading: In which direction (N,) [rad], 0 along +x.
            active: Who acts (N,); the others' targets stay as they are.
        """
        for i in np.flatnonzero(active):
            person = self._actors[i]
            if person is None:
                continue
            self._tell(int(i), person, float(speed[i]), float(heading[i]))
            pose = person.next(self._worlds.dt, self._sight(int(i)))
            self._targets[i] = self._worlds.coordinates([pose])
            self._time[i] += self._worlds.dt
        return self._targets

    def look(self, active: Flags) -> None:
        """Take in where the people are after a frame."""
        now = self._worlds.place("person/pelvis")[:, :2]
        go = active[:, None]
        self.velocity = np.where(go, (now - self.place) / self._worlds.dt, self.velocity)
        self.place = np.where(go, now, self.place)
        self._pushed = np.where(active, self._worlds.touched("person"), self._pushed)

    def _tell(self, i: int, person: Person, speed: float, heading: float) -> None:
        if speed < STANDS:
            if np.isfinite(self._told[i, 0]):
                person.stop()
                self._told[i] = np.nan
            return
        x, y = person.place
        way = np.array([_AHEAD * np.cos(heading), _AHEAD * np.sin(heading), speed])
        told = self._told[i] - [x, y, 0.0]
        short = not np.hypot(*told[:2]) > 0.5 * _AHEAD
        turned = np.abs(told[:2] / max(np.hypot(*told[:2]), 1e-9) - way[:2] / _AHEAD).max()
        same = turned < _DIFFERS and abs(told[2] - speed) < _DIFFERS
        if short or not same or person.stuck:
            person.walk(Point(x + way[0], y + way[1]), None, min(speed, FASTEST))
            self._told[i] = way[0] + x, way[1] + y, speed

    def _sight(self, i: int) -> Seen:
        """What person `i` sees and feels."""
        return Seen(
            time=float(self._time[i]),
            pose=self._worlds.person_pose(i),
            contacts=self._worlds.contacts(i) if self._pushed[i] else None,
            names=self._worlds.names,
        )


def _upright() -> Pose:
    return Pose(np.zeros(3), np.eye(55, 1) * np.array([[0.5 * np.pi, 0.0, 0.0]]))

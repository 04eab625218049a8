"""A person who acts by goals: walks, turns, looks, reaches, sits, and reacts to what it meets."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.actors.figure import (
    Figure,
    Gaze,
    swinging_arm,
    walking_gaze,
    walking_trunk,
)
from halfphysics.actors.foot import Foothold
from halfphysics.actors.path import Path, Point
from halfphysics.actors.seen import Seen
from halfphysics.actors.steps import Aim, next_step, stopping
from halfphysics.actors.turns import wrapped
from halfphysics.actors.walker import SIDES, SIGN, Stand, Walker
from halfphysics.base.validation import is_whole, number, shown, vector
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.actors.goals import Goal, Task
    from halfphysics.body.body import Body
    from halfphysics.motion.pose import Pose

Array = NDArray[np.float64]


class Person:
    """An actor by goals.

    Args:
        body: Its body; None: `Body.default()`.
        place: Where it stands at the begin, (x, y) [m].
        heading: Where it faces then, about z [rad], 0 along +x.
        goals: What it does first, one after the other.

    Raises:
        InputError: An impossible value.
    """

    def __init__(
        self,
        body: Body | None = None,
        *,
        place: ArrayLike = (0.0, 0.0),
        heading: float = 0.0,
        goals: Iterable[Goal] = (),
    ) -> None:
        if body is None:
            from halfphysics.body.body import Body

            body = Body.default()
        x, y = vector(place, "Person: place", 2, unit="m")
        heading = number(heading, "Person: heading", unit="rad")
        self.body = body
        self._start = Foothold(float(x), float(y), heading)
        self._first_goals = tuple(goals)
        self.walker = Walker(body)
        self.figure = Figure(body, self.walker)
        self.reset()

    # -- An actor

    def reset(self, seed: int = 0) -> Pose:
        """Stand at the start, with the first goals to do."""
        if not is_whole(seed, least=0, plain=False):
            raise InputError(f"Person.reset: expected a seed of at least 0, found {shown(seed)}")
        self.walker.stand_at(self._start)
        self.seen = Seen()
        self._goals = deque(self._first_goals)
        self._task: Task | None = None
        self._aim: Aim | None = None
        return self._posed(self.walker.now())

    def next(self, dt: float, seen: Seen) -> Pose:
        """The reference `dt` [s] later."""
        self.seen = seen
        self._do_goals()
        self._step(dt)
        return self._posed(self.walker.now())

    # -- Goals

    def do(self, *goals: Goal) -> None:
        """Do these goals now, one after the other, in place of all others."""
        self._end_task()
        self._goals = deque(goals)

    def then(self, *goals: Goal) -> None:
        """Do these goals after all others."""
        self._goals.extend(goals)

    @property
    def goals(self) -> tuple[Goal, ...]:
        """What is not done yet, the one under way first."""
        return tuple(self._goals)

    @property
    def done(self) -> bool:
        """Whether all goals are done."""
        return not self._goals

    def _do_goals(self) -> None:
        while self._goals:
            if self._task is None:
                self._task = self._goals[0].task()
            if not self._task.go_on(self):
                return
            self._end_task()
            self._goals.popleft()

    def _end_task(self) -> None:
        if self._task is not None:
            self._task.end(self)
        self._task = None

    # -- What goals ask for

    @property
    def place(self) -> Point:
        """Where it stands, or where its pelvis was at the last footfall."""
        return Point(*self.walker.centre[:2])

    @property
    def arrived(self) -> bool:
        """Whether it stands where it was to walk to."""
        return self._aim is None and not self.walker.stepping and not self.walker.moving

    def turned_from(self, heading: float) -> float:
        """How far it would have to turn to the left to face a direction [rad]."""
        return wrapped(heading - self.walker.centre.yaw)

    def position_of(self, who: int | str) -> Array:
        """Where a person or an object that it sees is (3,) [m].

        Raises:
            InputError: It sees none of that name.
        """
        seen = self.seen
        if who in seen.others:
            return seen.others[who].pelvis
        if isinstance(who, str) and who in seen.objects:
            return seen.objects[who][0]
        names = ", ".join(map(repr, (*seen.others, *seen.objects))) or "nobody and nothing"
        raise InputError(f"Person: it does not see {who!r}; it sees {names}")

    def walk(self, to: Point, heading: float | None, speed: float) -> None:
        """Walk to a place from the next step on."""
        self._aim = Aim(Path([self.place, to]), heading, speed)

    def stop(self) -> None:
        """Stand still after the next step."""
        self._aim = None

    def look(self, at: int | str | None) -> None:
        """Look at a person or an object; None: ahead."""

    # -- Inside

    def _step(self, dt: float) -> None:
        walker = self.walker
        if walker.advance(dt):
            walker.land()
        if walker.stepping:
            return
        step = stopping(walker) if self._aim is None else next_step(walker, self._aim)
        if step is None:
            self._aim = None
        else:
            walker.step(*step)

    def _posed(self, stand: Stand) -> Pose:
        chest = self.figure.chest(stand, walking_trunk(stand.stride))
        left, right = (swinging_arm(SIGN[side], stand.stride) for side in SIDES)
        gaze: Gaze = walking_gaze(stand.stride)
        return self.figure.pose(stand, chest, gaze, (left, right))

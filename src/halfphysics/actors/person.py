"""A person who acts by goals: walks, turns, looks, reaches, sits, and reacts to what it meets."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.actors.figure import Figure
from halfphysics.actors.floor_plan import FloorPlan
from halfphysics.actors.foot import Foothold
from halfphysics.actors.footprints import feet_of
from halfphysics.actors.goals import GivenUp, checked_goals
from halfphysics.actors.limbs import vec
from halfphysics.actors.path import Point
from halfphysics.actors.poise import Poise
from halfphysics.actors.seen import Seen, pelvis_of
from halfphysics.actors.turns import Vec, wrapped
from halfphysics.actors.walker import Walker
from halfphysics.actors.way import Way
from halfphysics.base.validation import is_whole, number, shown, vector
from halfphysics.errors import InputError
from halfphysics.results.argument_checks import checked_body, checked_scene

if TYPE_CHECKING:
    from halfphysics.actors.goals import Goal, Task
    from halfphysics.body.body import Body
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: What can be looked at, reached for and gone to: a point (3,) [m], the name of an object, or the
#: index of a person.
Target: TypeAlias = "tuple[float, float, float] | str | int"

# A head is this far above the pelvis [m], by the length of a leg.
_HEAD = 0.72
# A palm this near to its point is there [m].
_REACHED = 0.01
# It does not walk farther than this [m].
_FARTHEST = 10_000.0
# An arm with less than this of its way to a point is near the body.
_NEAR = 0.25


class Person:
    """An actor by goals.

    Args:
        body: Its body; None: `Body.default()`.
        place: Where it stands at the begin: the middle between the ankles (x, y) [m].
        heading: Where it faces then, about z [rad], 0 along +x.
        goals: What it does first, one after the other.
        scene: What it walks around; None: only around people.

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
        scene: Scene | None = None,
    ) -> None:
        body, scene = checked_body(body), checked_scene(scene)
        x, y = vector(place, "Person: place", 2, unit="m")
        heading = number(heading, "Person: heading", unit="rad")
        self.body = body
        self._start = Foothold(float(x), float(y), heading)
        self._first_goals = checked_goals(goals)
        self._walker = Walker(body)
        self._way = Way(self._walker, FloorPlan(scene))
        self._poise = Poise(body, Figure(body, self._walker))
        self.reset()
        self._is_new = True

    # -- An actor

    def reset(self, seed: int = 0) -> Pose:
        """Stand at the start, with the first goals to do: those that it was made with, or that it
        was told before the first frame and the first `reset`."""
        if not is_whole(seed, least=0, plain=False):
            raise InputError(f"Person.reset: expected a seed of at least 0, found {shown(seed)}")
        self._is_new = False
        self._walker.stand_at(self._start)
        self._way.begin()
        self._pose = self._poise.begin(int(seed), self._walker.now())
        self.seen, self.time, self.dt = Seen(), 0.0, 0.0
        self._goals = deque(self._first_goals)
        self._task: Task | None = None
        self._reason = ""
        self._given_up: tuple[GivenUp, ...] = ()
        self._looks_at: Target | None = None
        return self._pose

    def restart(self, pose: Pose) -> Pose:
        """Stand on the feet of a pose with arms that hang, with the goals that there are."""
        left, right = feet_of(pose, self.body)
        self._walker.stand_on(left, right)
        self._way.begin()
        self._end_task()
        self._pose = self._poise.restart(self._walker.now())
        return self._pose

    def next(self, dt: float, seen: Seen) -> Pose:
        """The reference `dt` [s] later.

        Raises:
            InputError: An impossible `dt`; a goal of what it does not see.
        """
        number(dt, "Person.next: dt", above=0.0, unit="s")
        if not isinstance(seen, Seen):
            raise InputError(f"Person.next: expected what it sees (Seen), found {shown(seen)}")
        self.seen, self.dt = seen, dt
        self.time += dt
        self._do_goals()
        body, offset = self._body_and_offset()
        self._way.advance(dt, seen, body, offset, self._poise.seat.free)
        if self._way.wants_to_step:
            self._poise.seat.rise()
        stand = self._walker.now()
        at = None if self._looks_at is None else self.point_of(self._looks_at)
        self._poise.advance(dt, stand, at, self._way.ahead)
        self._pose = self._poise.pose(stand)
        return self._pose

    def _body_and_offset(self) -> tuple[Array, Array]:
        """Where the simulated pelvis is (2,), and how far from the reference's (2,) [m]."""
        own = pelvis_of(self._pose, self.body)[:2]
        if self.seen.pose is None:
            return own, np.zeros(2)
        body = pelvis_of(self.seen.pose, self.body)[:2]
        return body, body - own

    # -- Goals

    def do(self, *goals: Goal) -> None:
        """Do these goals now, one after the other, in place of all others.

        What was given up before is forgotten.
        """
        checked = checked_goals(goals)
        self._end_task()
        self._goals, self._given_up = deque(checked), ()
        self._note_first()

    def then(self, *goals: Goal) -> None:
        """Do these goals after all others."""
        self._goals.extend(checked_goals(goals))
        self._note_first()

    def _note_first(self) -> None:
        """What a new person is told is as if it had been made with that."""
        if self._is_new and self.time == 0.0:
            self._first_goals = tuple(self._goals)

    @property
    def goals(self) -> tuple[Goal, ...]:
        """What is neither done nor given up yet, the one under way first."""
        return tuple(self._goals)

    @property
    def done(self) -> bool:
        """Whether all goals are done, none of them given up."""
        return not self._goals and not self._given_up

    @property
    def given_up(self) -> tuple[GivenUp, ...]:
        """Goals that could not be reached, each with the reason; the next goals were gone on to."""
        return self._given_up

    def _do_goals(self) -> None:
        while self._goals:
            if self._task is None:
                self._task = self._goals[0].task()
            task, self._reason = self._task, ""
            done = task.go_on(self) or bool(self._reason)
            # A task that told other goals has been ended by that: they begin in the next frame.
            if not done or self._task is not task:
                return
            if self._reason:
                self._given_up += (GivenUp(self._goals[0], self._reason),)
            self._end_task()
            self._goals.popleft()

    def _end_task(self) -> None:
        if self._task is not None:
            self._task.end(self)
        self._task = None

    # -- What it knows

    @property
    def place(self) -> Point:
        """Where it stands, or where it was at the last footfall [m]."""
        return Point(*self._walker.centre[:2])

    @property
    def heading(self) -> float:
        """Where it faces there, about z [rad]."""
        return self._walker.centre.yaw

    @property
    def arrived(self) -> bool:
        """Whether it stands where it was to walk to."""
        return self._way.arrived

    @property
    def blocked(self) -> int:
        """How often something stopped it on the way to where it walks."""
        return self._way.blocked

    @property
    def stuck(self) -> str:
        """Why it does not go on to where it was to walk to; "": it goes on, or has arrived."""
        return self._way.stuck

    @property
    def sits(self) -> bool:
        """Whether it sits at rest."""
        return self._poise.seat.rests

    @property
    def stands(self) -> bool:
        """Whether it stands or walks: it does not sit, nor is it about to stand up."""
        return self._poise.seat.free

    @property
    def away(self) -> float:
        """How far its simulated pelvis is beside or above where its reference was to be [m].

        What it has sunk into something soft does not count."""
        if self.seen.pose is None:
            return 0.0
        body, asked = (pelvis_of(pose, self.body) for pose in (self.seen.pose, self._pose))
        x, y, z = (float(its) for its in body - asked)
        return math.hypot(x, y, max(z, 0.0))

    @property
    def leg(self) -> float:
        """Length of its legs [m]."""
        return self._walker.legs["left"].length

    def palm(self, side: str) -> Vec:
        """Where the palm of its "left" or "right" hand is in the last pose [m]."""
        return self._poise.palm(side)

    def reached(self, side: str) -> bool:
        """Whether a palm is at the point that its hand was brought to."""
        reach = self._poise.reaches[side]
        point = reach.point
        return reach.there and point is not None and math.dist(point, self.palm(side)) < _REACHED

    def withdrawn(self, side: str) -> bool:
        """Whether an arm is near its body again."""
        return self._poise.reaches[side].share.value < _NEAR

    def lacks(self, side: str, point: Vec) -> float:
        """What a stretched arm lacks to a point without leaning any farther [m]."""
        return self._poise.lacks(side, point)

    def turned_from(self, heading: float) -> float:
        """How far it would have to turn to the left to face a direction [rad]."""
        return wrapped(heading - self.heading)

    def point_of(self, target: Target) -> Vec:
        """Where a target is [m]; of a person, its head.

        Raises:
            InputError: It sees none of that name.
        """
        if isinstance(target, tuple):
            return target
        seen = self.seen
        if target in seen.others:
            x, y, z = vec(seen.others[target].pelvis)
            return (x, y, z + _HEAD * self.leg)
        if isinstance(target, str) and target in seen.objects:
            return vec(seen.objects[target][0])
        names = ", ".join(map(repr, (*seen.others, *seen.objects))) or "nobody and nothing"
        raise InputError(f"Person: it does not see {target!r}; it sees {names}")

    # -- What goals ask for

    def walk(self, to: Point, heading: float | None, speed: float) -> None:
        """Walk to a place from the next step on, after standing up.

        Raises:
            InputError: It is farther away than anybody walks.
        """
        if not math.dist(to, self.place) < _FARTHEST:
            raise InputError(
                f"Person: found a place {math.dist(to, self.place):g} m away to walk to, expected "
                f"one within {_FARTHEST:g} m"
            )
        self._way.go(to, heading, speed)

    def stop(self) -> None:
        """Stand still after the next step."""
        if not self.arrived:
            self._way.stop()

    def give_up(self, reason: str) -> bool:
        """End the goal under way as not reached, for `Task.go_on`; returns False: not done."""
        self._reason = reason
        return False

    def look(self, at: Target | None) -> None:
        """Look at something from now on; None: ahead."""
        self._looks_at = at

    def reach(self, side: str, point: Vec, palm: str = "in") -> None:
        """Bring a hand to a point [m], which may be told anew in every frame."""
        self._poise.reaches[side].to(point, palm, math.dist(point, self.palm(side)))

    def withdraw(self, side: str) -> None:
        """Let an arm hang again."""
        self._poise.reaches[side].back()

    def close_hand(self, side: str, closed: bool = True) -> None:
        """Close or open the fingers of a hand that reaches."""
        self._poise.reaches[side].close(closed)

    def sit(self, pelvis: Vec) -> None:
        """Sit down: the pelvis joint comes to a place in the world [m]."""
        self._poise.seat.sit(pelvis)

    def rise(self) -> None:
        """Stand up."""
        self._poise.seat.rise()

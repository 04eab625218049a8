"""Where a person's feet take it: along a route, around what blocks it, and after a push.

What it notices is how far its body is from its reference:
- behind on its way for a while: it is blocked. It stops where its body is, waits, and looks for a
  way round what it touched;
- away while it stands: it was pushed. It steps to where its body is, and comes back when nothing
  pushes any more;
- away from its goal when the reference is there: it is blocked as well.

Who waits and tries for long without coming nearer gives up, and stands where it is.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.actors.foot import Foothold
from halfphysics.actors.passersby import Passersby
from halfphysics.actors.path import Path, Point
from halfphysics.actors.route import route
from halfphysics.actors.steps import Aim, Next, next_step, stopping

if TYPE_CHECKING:
    from halfphysics.actors.floor_plan import FloorPlan
    from halfphysics.actors.seen import Seen
    from halfphysics.actors.walker import Walker

Array = NDArray[np.float64]

#: A person this far behind its reference [m] that comes on at less than this share of its speed
#: for this long [s] is blocked.
BEHIND, SLOW, PATIENCE = 0.05, 0.35, 0.5
#: From `BEHIND` to this far behind [m] the reference slows down until it waits for its body.
WAITS = 0.2
#: A standing person this far from its reference [m] takes a step.
PUSHED = 0.10
#: A body this near to its reference at the end of the way has arrived [m].
REACHED = 0.15
#: Time in which it waits, steps back or is slowed down without coming nearer by so much [m], after
#: which it gives up [s].
GIVES_UP, NEARER = 10.0, 0.5
# How long it waits before it goes round [s], before it tries again, and before it comes back.
_WAIT, _AGAIN, _SETTLE = 0.9, 2.0, 0.7
# Who is blocked steps back from where its body is [m].
_BACK = 0.35
# It comes back from this far [m].
_HOME = 0.02
# This much before the end of what was looked for of its way, or half of that, it looks again [m].
_LOOKS = 10.0
# A goal this near to the old one, as a share of the way left to that, lies on about the same way.
_ALIKE = 0.5
# What it touched is thought to be this far around the contact [m], farther each time, and is
# remembered so long [s].
_AROUND, _REMEMBERED = 0.2, 12.0

#: Where to go, how to face there [rad] (None: as it comes), and how fast, as a share of the usual.
Destination = tuple[Point, float | None, float]


class Way:
    """The way of one person.

    Args:
        walker: Its feet.
        plan: What stands on the floor.
    """

    def __init__(self, walker: Walker, plan: FloorPlan) -> None:
        self._walker, self._plan = walker, plan
        self.begin()

    def begin(self) -> None:
        """Forget everything; the person stands."""
        self._goal: Destination | None = None
        self._aim: Aim | None = None
        self._told_anew = False
        self._catching = False
        self._home: Foothold | None = self._walker.centre
        self._held, self._wait, self._calm = 0.0, 0.0, 0.0
        self._met: list[tuple[Array, float]] = []
        self._last: Array | None = None
        self._slowed = 1.0
        self._others = Passersby()
        self._retreat: Array | None = None
        #: How often it was blocked on the way to its goal.
        self.blocked = 0
        #: Why it has given up its last goal; "": it has not.
        self.stuck = ""
        self._tried, self._nearest = 0.0, math.inf

    # -- What is asked of it

    @property
    def arrived(self) -> bool:
        """Whether it stands where it was to go."""
        return self._goal is None and self._stands

    @property
    def wants_to_step(self) -> bool:
        """Whether it is to go somewhere."""
        return self._goal is not None and self._wait <= 0.0

    @property
    def ahead(self) -> float:
        """Where the way goes, to the left of where the person faces [rad]."""
        aim = self._aim
        if aim is None or self._catching:
            return 0.0
        centre = self._walker.centre
        at = aim.path.nearest(centre.x, centre.y)
        if aim.path.length - at < 0.7:
            return 0.0
        to = aim.path.at(at + 0.9)
        turn = math.atan2(to.y - centre.y, to.x - centre.x) - centre.yaw
        return math.remainder(turn, 2.0 * math.pi)

    @property
    def _stands(self) -> bool:
        return not self._walker.stepping and not self._walker.moving

    def go(self, to: Point, heading: float | None, speed: float) -> None:
        """Go to a place, from the next step on.

        Who is already on the way to about there keeps what it knows of that way: that it is
        blocked, waits or steps back.
        """
        same_way = self._goal is not None and self._is_near(to, self._goal[0])
        self._goal, self._told_anew = (to, heading, speed), True
        self.stuck, self._tried, self._nearest = "", 0.0, math.inf
        if not same_way:
            self._aim, self._catching = None, False
            self._wait, self.blocked, self._retreat = 0.0, 0, None

    def _is_near(self, to: Point, old: Point) -> bool:
        """Whether the way to a place begins like that to another one."""
        return math.dist(to, old) < max(NEARER, _ALIKE * math.dist(old, self._walker.centre[:2]))

    def stop(self) -> None:
        """Stand as soon as feet allow; who was on its way stays where it stands then."""
        if self._goal is not None:
            self._home = None
        self._goal, self._aim, self._catching = None, None, False

    # -- In every frame

    def advance(self, dt: float, seen: Seen, body: Array, offset: Array, free: bool) -> None:
        """Go on by `dt` [s].

        Args:
            dt: Length of the frame [s].
            seen: By the person.
            body: Where its simulated pelvis is (2,) [m].
            offset: Of that from its reference (2,) [m].
            free: Whether it may begin a step.
        """
        self._notice(dt, seen, body, offset)
        self._be_patient(dt, body)
        walker = self._walker
        ended = walker.advance(dt * self._slowed)
        if ended is not None:
            walker.land(ended)
        if walker.stepping or not free:
            return
        step = self._next(seen, body, offset)
        if step is not None:
            walker.step(*step)

    def _next(self, seen: Seen, body: Array, offset: Array) -> Next | None:
        tries = self._aim is not None or self._tried <= GIVES_UP
        if self._goal is not None and not self._catching and self._wait <= 0.0 and tries:
            self._look_ahead(seen, self._goal)
        if self._aim is None:
            step = stopping(self._walker)
            if step is None:
                self._stand(body, offset)
        if self._aim is not None:
            step = next_step(self._walker, self._aim)
            if step is None:
                self._there(seen, body, offset)
        return step

    def _there(self, seen: Seen, body: Array, offset: Array) -> None:
        self._aim = None
        short = math.hypot(*offset)
        if not self._catching and short > REACHED:
            self._is_blocked(seen, body, -offset / short)
        elif not self._catching:
            self._goal = None
            self._home = self._walker.centre
        self._catching = False

    def _stand(self, body: Array, offset: Array) -> None:
        """What a person does who stands and is to go nowhere now."""
        centre = self._walker.centre
        home = self._home = centre if self._home is None else self._home
        if self._retreat is not None:
            (x, y), self._retreat = self._retreat, None
            self._to(Point(float(x), float(y)), centre.yaw)
        elif self._tried > GIVES_UP and (
            math.hypot(*offset) <= PUSHED or self._tried > 2.0 * GIVES_UP
        ):
            self._give_up(body)
        elif math.hypot(*offset) > PUSHED:
            self._calm = 0.0
            self._to(Point(centre.x + float(offset[0]), centre.y + float(offset[1])), centre.yaw)
        elif self._goal is None and self._calm > _SETTLE:
            turned = abs(math.remainder(centre.yaw - home.yaw, 2.0 * math.pi))
            if math.hypot(centre.x - home.x, centre.y - home.y) > _HOME or turned > 0.02:
                self._to(Point(home.x, home.y), home.yaw)

    def _to(self, place: Point, yaw: float) -> None:
        centre = self._walker.centre
        self._aim = Aim(Path([Point(centre.x, centre.y), place]), yaw, 1.0, catching=True)
        self._catching = True

    # -- Noticing

    def _notice(self, dt: float, seen: Seen, body: Array, offset: Array) -> None:
        self._wait = max(0.0, self._wait - dt)
        self._calm += dt
        self._others.notice(dt, seen)
        self._met = [(at, left - dt) for at, left in self._met if left > dt]
        last, self._last = self._last, body
        self._slowed = 1.0
        if self._aim is None or self._catching or last is None or not self._walker.stepping:
            self._held = 0.0
            return
        speed = self._walker.velocity
        wanted = math.hypot(*speed)
        if wanted < 0.1:
            return
        way = np.array(speed) / wanted
        behind = -float(offset @ way)
        came = float((body - last) @ way) / dt
        if behind > BEHIND and came < SLOW * wanted:
            self._held += dt
        else:
            self._held = max(0.0, self._held - 2.0 * dt)
        self._slowed = min(max((WAITS - behind) / (WAITS - BEHIND), 0.0), 1.0)
        if self._held > PATIENCE:
            self._is_blocked(seen, body, way)

    def _be_patient(self, dt: float, body: Array) -> None:
        if self._goal is None:
            return
        left = math.dist(self._goal[0], body)
        if left < self._nearest - NEARER:
            self._nearest, self._tried = left, 0.0
        elif self._aim is None or self._catching or self._slowed < 1.0:
            self._tried += dt

    def _give_up(self, body: Array) -> None:
        """Stand here in place of going on to the goal."""
        if self._goal is None:
            return
        (x, y), _, _ = self._goal
        short = math.dist((x, y), body)
        why = f"it was blocked, {self.blocked} times" if self.blocked else "no way leads there"
        self.stuck = f"({x:g}, {y:g}) was not reached: {why}; it is {short:.2f} m away"
        self._goal, self._tried = None, 0.0
        self._home = self._walker.centre

    def _is_blocked(self, seen: Seen, body: Array, way: Array) -> None:
        self._held, self._aim, self._slowed = 0.0, None, 1.0
        self._retreat = body - _BACK * way
        self.blocked += 1
        self._wait = _WAIT if self.blocked < 3 else _AGAIN
        touched = seen.touched_at
        places = touched[:, :2] if len(touched) else (body + 0.35 * way)[None]
        around = _AROUND * self.blocked
        side = np.array([-way[1], way[0]])
        for at in places[:4]:
            for across in (-around, 0.0, around):
                self._met.append((at + _AROUND * way + across * side, _REMEMBERED))

    def _look_ahead(self, seen: Seen, goal: Destination) -> None:
        """Find the way to a goal, or another one where people are in it."""
        to, heading, speed = goal
        centre = self._walker.centre
        here = Point(centre.x, centre.y)
        if self._aim is not None and not self._told_anew and self._is_open(self._aim.path, here):
            return
        self._told_anew = False
        met = (at for at, _ in self._met)
        moving = self._plan.moving(seen, [*self._others.places(here), *met])
        path = route(self._plan, here, to, moving)
        if path is None:
            self._aim, self._wait = None, _AGAIN
            return
        self._aim = Aim(path, heading, speed)

    def _is_open(self, path: Path, here: Point) -> bool:
        """Whether a way can be gone on along: nobody is in it, and it is known far enough."""
        if path.foreseen < path.length:
            left = path.foreseen - path.nearest(*here)
            if left < min(_LOOKS, 0.5 * path.foreseen):
                return False
        return not self._others.in_the_way(path, here)

    @property
    def home(self) -> Foothold | None:
        """Where it comes back to; None: where it will stand."""
        return self._home

"""From the poses that arrive to the pose that the physics is asked for.

While poses arrive as expected, the target is the newest pose, unchanged. Where it would jump (the
first pose, a tracker that was lost, a glitch), the target is

    target(t) = pose(t) * offset^(1 - ease(t / T)),

with the offset that makes it continuous and a T in which a person can come that far: motion that
goes on meanwhile passes through. Senders of another rate than the physics are interpolated: the
target goes at even speed to a pose, and is as late as it must be for that. A slower sender's is

    reached = arrived + (ceil(interval / dt) - 1) dt,

the latest step before the next pose; a faster one's, whose newest pose is up to an interval old,

    reached = arrived + interval.

Without it a person of 60 Hz would stand and leap in steps of 90 Hz, one of 120 Hz would go one pose
in most steps and two in others, and what they push would fly off too fast.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.live.clock import MOST
from halfphysics.live.incoming import IncomingPose, Tracking
from halfphysics.live.stance import RELAXING
from halfphysics.motion.easing import ease
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.live.mailbox import Arrival

Array = NDArray[np.float64]

#: Faster than this, a pose has jumped: nobody runs at 10 m/s; joints of a thrower reach 130 rad/s
#: for a few milliseconds, all others stay below 40.
JUMP_ROOT, JUMP_JOINT = 10.0, 60.0
#: Largest speeds at which a jump is made up for: a quick walk [m/s], a quick reach [rad/s].
ROOT_SPEED, JOINT_SPEED = 2.5, 8.0
#: Largest slope of `ease`: top speed over mean speed.
_SLOPE = 1.875
#: Silence after which a person is held, and after which it relaxes [s].
HOLD_AFTER, RELAX_AFTER = 0.25, 3.0


class Follower:
    """The target of one person.

    Args:
        start: The pose at the start, with axes of its own.
        rest: The pose whose arms, trunk and head are taken when nobody sends any.
        pelvis: Rest position of the pelvis in the body's axes (3,) [m].
        dt: Length of a step [s].

    Attributes:
        tracking: What is known of the person.
        pose: The present target.
    """

    def __init__(self, start: Pose, rest: Pose, pelvis: Array, dt: float) -> None:
        self._rest, self._pelvis, self._dt = rest, pelvis, dt
        self._axes = start.axes
        self.tracking: Tracking = "waiting"
        self.pose = start
        self._goal = (start.translation, start.rotations)
        self._from = self._goal
        self._k = self._n = 1.0  # steps gone of the way from `_from` to `_goal`, and all of them
        self._source = ""  # the sender of the goal
        self._time: float | None = None  # the sender's, of the goal
        self._absent = np.zeros(N_JOINTS)  # how long joints are not tracked [s]
        self._absent[:] = np.inf
        self._offset: tuple[Array, Array] | None = None
        self._passed = self._duration = 0.0

    def advance(self, arrival: Arrival | None, silence: float, interval: float) -> Pose:
        """The target of the next step.

        Args:
            arrival: A pose that arrived since the last step; None: none did.
            silence: Time since the last pose arrived [s].
            interval: Usual time between two poses of the sender [s].
        """
        if arrival is not None:
            self._take(arrival.pose, arrival.gap, interval, silence)
        elif self.tracking != "waiting":
            self._miss(silence)
        self.pose = self._target()
        return self.pose

    def put(self, pose: Pose) -> None:
        """The person is at this pose, with the axes of the start: nothing is made up for."""
        self._goal = self._from = (pose.translation, pose.rotations)
        self._k = self._n = 1.0
        self._offset = None
        self.pose = pose

    # -- inside --------------------------------------------------------------------------

    def _take(self, arrived: IncomingPose, gap: float, interval: float, age: float) -> None:
        before = self.pose
        goal = self._completed(arrived, gap)
        passed = max(min(gap, HOLD_AFTER), self._dt)
        same = arrived.source == self._source  # clocks of two senders have nothing in common
        if same and arrived.time is not None and self._time is not None:
            # Poses that were held up on their way come together. Who was away longer than they
            # can be is lost; a clock that counts milliseconds, or lies, lets nobody jump farther.
            passed = max(passed, min(arrived.time - self._time, HOLD_AFTER))
        again = self.tracking != "live"
        jumped = again or _fast(self._goal, goal, passed)
        steps = 1.0 if jumped else self._steps(interval, age)
        self._from = self._between() if steps > 1.0 else goal
        self._goal, self._k, self._n = goal, 0.0, steps
        self._source, self._time = arrived.source, arrived.time
        self.tracking = "live"
        if jumped:
            self._blend_from(before)

    def _steps(self, interval: float, age: float) -> float:
        """Steps in which a pose that arrived `age` [s] ago is reached.

        Where the interval is a whole number of steps, or near enough for the clock to follow, the
        steps lie on the poses already, and an age is the network's alone: it would make even poses
        uneven.
        """
        periods = min(interval, HOLD_AFTER) / self._dt
        if periods == 0.0 or abs(periods - round(periods)) <= MOST:
            return max(1.0, float(round(periods)))
        late = math.ceil(periods) - 1.0 if periods > 1.0 else periods
        return max(1.0, 1.0 + late - age / self._dt)

    def _completed(self, arrived: IncomingPose, gap: float) -> tuple[Array, Array]:
        """Translation and rotations, in our axes, with the joints that the sender does not give.

        `gap`: the time since the pose before it [s].
        """
        pose, rotations = arrived.pose, arrived.pose.rotations
        translation = pose.translation
        if pose.axes is not self._axes:
            translation = translation + (pose.axes - self._axes) @ self._pelvis
        if arrived.tracked is None:
            self._absent[:] = 0.0
            return translation, rotations
        lost = ~arrived.tracked
        self._absent[~lost] = 0.0
        rotations = np.where(lost[:, None], self._goal[1], rotations)
        relaxing = lost & RELAXING & (self._absent >= RELAX_AFTER)
        self._absent[lost] += min(gap, RELAX_AFTER)
        rotations[relaxing] = self._rest.rotations[relaxing]
        if lost[0]:
            translation = self._goal[0]
        return translation, rotations

    def _miss(self, silence: float) -> None:
        if self.tracking == "live" and silence > HOLD_AFTER:
            self.tracking = "held"
        if self.tracking == "held" and silence > RELAX_AFTER:
            self.tracking = "relaxed"
            rotations = self._goal[1].copy()
            rotations[RELAXING] = self._rest.rotations[RELAXING]
            before = self.pose
            self._goal = (self._goal[0], rotations)
            self._from, self._k, self._n = self._goal, 1.0, 1.0
            self._blend_from(before)

    def _blend_from(self, before: Pose) -> None:
        """From now on the target leaves `before` for the goal, as fast as a person."""
        translation, rotations = self._goal
        turn = rot.multiply(rot.conjugate(rot.exp(rotations)), rot.exp(before.rotations))
        offset = before.translation - translation, rot.log(turn)
        far = float(np.linalg.norm(offset[0])) / ROOT_SPEED
        turned = float(np.linalg.norm(offset[1], axis=1).max()) / JOINT_SPEED
        self._duration = _SLOPE * max(far, turned)
        self._offset = offset if self._duration > self._dt else None
        self._passed = 0.0

    def _between(self) -> tuple[Array, Array]:
        """Where the way from the last pose to the goal is now."""
        if self._k >= self._n:
            return self._goal
        part = self._k / self._n
        start, end = self._from, self._goal
        quat = rot.slerp(rot.exp(start[1]), rot.exp(end[1]), np.full(N_JOINTS, part))
        return start[0] + part * (end[0] - start[0]), rot.log(quat)

    def _target(self) -> Pose:
        self._k = min(self._k + 1.0, self._n)
        translation, rotations = self._between()
        if self._offset is not None:
            self._passed += self._dt
            left = 1.0 - float(ease(self._passed / self._duration))
            if left <= 0.0:
                self._offset = None
            else:
                off, turn = self._offset
                translation = translation + left * off
                rotations = rot.log(rot.multiply(rot.exp(rotations), rot.exp(left * turn)))
        return Pose.trusted(translation, rotations, self._axes)


def _fast(before: tuple[Array, Array], after: tuple[Array, Array], passed: float) -> bool:
    """Whether nobody moves that fast: from one goal to the next within `passed` [s]."""
    if math.dist(after[0], before[0]) > JUMP_ROOT * passed:
        return True
    change, bound = after[1] - before[1], JUMP_JOINT * passed
    # No rotation vector has changed by more than the bound: then no angle has, and that is quick
    # to see. One near half a turn may flip: only then are the angles themselves worked out.
    if np.abs(change).max() <= bound / math.sqrt(3.0):
        return False
    return bool(rot.angles(before[1], after[1]).max() > min(bound, np.pi))

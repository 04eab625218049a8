"""Walking by footholds: where feet stand next decides all else.

At phase k, in the middle of both feet being down, the pelvis is between the two footholds; in
between it follows the quintic through these points, at rest where the person stands. So the plan is
needed two steps ahead: the one that begins, and the one after it or standing. The pelvis is as high
as the legs allow.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from halfphysics.actors.foot import Foot, Foothold, FootPose, ease, swung
from halfphysics.actors.limbs import LegBones
from halfphysics.actors.stride import (
    SIGN,
    USUAL_STEP,
    Knot,
    Stand,
    Step,
    Stride,
    arch,
    between,
    middle,
    near,
    share,
    stride_of,
)
from halfphysics.actors.turns import (
    WORLD_FROM_REST,
    about_x,
    about_y,
    about_z,
    multiply,
    plus,
    rotate,
)
from halfphysics.scenarios.acting import posture
from halfphysics.scenarios.acting.gait import DOUBLE, WIDTH
from halfphysics.scenarios.acting.legs import leg_of

if TYPE_CHECKING:
    from halfphysics.body.body import Body

SIDES = ("left", "right")
OTHER = {"left": "right", "right": "left"}
#: Height of soles above the ground [m]: more than twice the simulator's clearance.
GROUND = 0.004

_PELVIS_YAW, _PELVIS_LIST = float(posture.PELVIS_YAW), float(posture.PELVIS_LIST)
_LEAN, _SWAY = float(posture.LEAN), posture.SWAY
# What the pelvis is below the height at which a leg is straight [m].
_BENT = 0.004
# What it is lower at the end of a step, so that it can rise before [m].
_SLACK = 0.004
# Largest rise of the pelvis in the middle of a step, and largest dip [m].
_RISE, _DIP = 0.035, -0.05
# Time constant with which the pace changes [s].
_PACE_TIME = 0.12
# Where in a step heights are looked at, the first part of the next step included.
_MIDDLE = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.76)
_END = (0.81, 0.84, 0.87, 0.9, 1.0, 1.06, 1.12)


class Walker:
    """Feet and pelvis of a person who stands or walks.

    Args:
        body: The person's body.
    """

    def __init__(self, body: Body) -> None:
        self.legs = {side: LegBones.of(body, side) for side in SIDES}
        self.width = 0.5 * WIDTH * (self.legs["left"].hip[0] - self.legs["right"].hip[0])
        self._forward = posture.forward(leg_of(body, "left"))
        self.stand_at(Foothold(0.0, 0.0, 0.0))

    # -- Where it is

    @property
    def stepping(self) -> bool:
        """Whether a step is under way."""
        return self._step is not None

    @property
    def moving(self) -> bool:
        """Whether the pelvis moved when both feet were last down: a step must follow."""
        return self._knot.rate != (0.0, 0.0, 0.0)

    @property
    def centre(self) -> Foothold:
        """Middle of both feet at the last moment at which both were down."""
        x, y, yaw = self._knot.at
        return Foothold(x, y, yaw)

    @property
    def velocity(self) -> tuple[float, float]:
        """Of the pelvis over the floor, in the mean of the step under way [m/s]."""
        step = self._step
        if step is None:
            return (0.0, 0.0)
        (ax, ay, _), (bx, by, _) = step.first.at, step.last.at
        return ((bx - ax) * self._pace, (by - ay) * self._pace)

    @property
    def last_side(self) -> str:
        """The foot that stepped last."""
        return self._last_side

    def hold(self, side: str) -> Foothold:
        """Where a foot stands, or last stood."""
        return self._feet[side].hold

    def placed(self, at: Foothold, side: str) -> Foothold:
        """Where a foot is when the person stands at a place."""
        w = SIGN[side] * self.width
        return Foothold(at.x - w * math.sin(at.yaw), at.y + w * math.cos(at.yaw), at.yaw)

    def stand_at(self, at: Foothold) -> None:
        """Stand at a place, at once."""
        self._feet = {side: Foot(self.placed(at, side)) for side in SIDES}
        self._step: Step | None = None
        self._phase, self._pace, self._wanted = 0.0, 0.0, 0.0
        self._last_side = "left"
        self._knot = Knot((at.x, at.y, at.yaw))
        self._knot.height = self._limit(0.0) - _BENT

    def stand_on(self, left: Foothold, right: Foothold) -> None:
        """Stand on two footholds, at once."""
        self.stand_at(Foothold(*middle(left, right)))
        self._feet = {"left": Foot(left), "right": Foot(right)}
        self._knot.height = self._limit(0.0) - _BENT

    # -- Steps

    def step(self, side: str, to: Foothold, then: Foothold | None, seconds: float) -> None:
        """Begin a step; only where none is under way.

        Args:
            side: The foot that swings.
            to: Where it lands.
            then: Where the other foot lands after it; None: the person stands then.
            seconds: How long the step takes.
        """
        start, other = round(self._phase), OTHER[side]
        first = self._knot
        last = Knot(near(middle(self._feet[other].hold, to), first.at))
        if then is not None:
            after = near(middle(to, then), last.at)
            last.rate = tuple(0.5 * (b - a) for a, b in zip(first.at, after, strict=True))  # type: ignore[assignment]
            c, s = math.cos(last.at[2]), math.sin(last.at[2])
            forward = max(0.0, c * last.rate[0] + s * last.rate[1])
            last.going = min((forward / USUAL_STEP) ** 2, 1.5)
        lifts = self._rolled_off(side, start, first)
        self._feet[other] = self._roll_after(other, start, last, then)
        lands = Foot(to, start + 1.0 - 0.5 * DOUBLE, share(self._ahead(to, last)))
        self._step = Step(side, start, lifts, lands, first, last)
        self._rise(self._step)
        self._wanted = 1.0 / seconds
        if not self.moving:
            self._pace = self._wanted
        self._last_side = side

    def _ahead(self, hold: Foothold, knot: Knot, phases: float = -0.5 * DOUBLE) -> float:
        """How far a foothold is ahead of the pelvis some phases after a knot [m]."""
        x = knot.at[0] + phases * knot.rate[0]
        y = knot.at[1] + phases * knot.rate[1]
        return math.cos(hold.yaw) * (hold.x - x) + math.sin(hold.yaw) * (hold.y - y)

    def _rolled_off(self, side: str, start: int, knot: Knot) -> Foot:
        """The foot that lifts now; from standing its heel rises first."""
        foot = self._feet[side]
        if foot.behind:
            return foot
        return Foot(foot.hold, foot.strike, foot.ahead, start, 0.6, 0.15)

    def _roll_after(self, side: str, start: int, knot: Knot, then: Foothold | None) -> Foot:
        """The standing foot of a step: it rolls off if it is the next to lift."""
        foot = self._feet[side]
        if then is None:
            return Foot(foot.hold, foot.strike, foot.ahead)
        behind = max(share(-self._ahead(foot.hold, knot, 0.5 * DOUBLE)), 0.15)
        return Foot(foot.hold, foot.strike, foot.ahead, start + 0.34, 0.95, behind)

    def _rise(self, step: Step) -> None:
        """Heights of the pelvis at the end of a step and in its middle, by what legs can reach."""
        step.last.height = min(self._limit(u) for u in _END) - _BENT - _SLACK
        way, bump = step.last.height - step.first.height, _RISE
        for u in (*_MIDDLE, *_END[:4]):
            free = self._limit(u) - _BENT - step.first.height - ease(u) * way
            bump = min(bump, free / arch(u))
        step.bump = max(bump, _DIP)

    def advance(self, dt: float) -> Step | None:
        """Go on by `dt` [s]. Returns the step if it has ended: it is to `land`."""
        step = self._step
        if step is None:
            return None
        self._pace += (self._wanted - self._pace) * (1.0 - math.exp(-dt / _PACE_TIME))
        self._phase += dt * self._pace
        return step if self._phase >= step.start + 1.0 else None

    def land(self, step: Step) -> None:
        """End a step: the next is to begin, or the person stands."""
        self._feet[step.side] = step.after
        self._knot, self._step = step.last, None
        if step.last.rate == (0.0, 0.0, 0.0):
            self._phase = float(step.start + 1)

    # -- Poses

    def now(self) -> Stand:
        """Pelvis and feet at this moment."""
        step = self._step
        if step is None:
            return self._at(0.0, self._knot.height)
        u = self._phase - step.start
        first, last = step.first.height, step.last.height
        return self._at(u, first + ease(u) * (last - first) + step.bump * arch(u))

    def _limit(self, u: float) -> float:
        """The height of the pelvis at which a leg is straight, at u of the step [m]."""
        stand = self._at(u, 0.0)
        limit = math.inf
        for side, foot in zip(SIDES, stand.feet, strict=True):
            leg = self.legs[side]
            hip = rotate(stand.root, leg.hip)
            dx = foot.ankle[0] - stand.pelvis[0] - hip[0]
            dy = foot.ankle[1] - stand.pelvis[1] - hip[1]
            reach = math.sqrt(max(leg.length**2 - dx * dx - dy * dy, 1e-4))
            limit = min(limit, foot.ankle[2] + reach - hip[2])
        return limit

    def _at(self, u: float, height: float) -> Stand:
        step = self._step
        if step is None:
            (x, y, yaw), stride, shift = self._knot.at, Stride(self._knot.going, 0.0, 0.0), 0.0
        else:
            x, y, yaw = between(step.first, step.last, u)
            stride, shift = stride_of(step, u)
        feet = tuple(self._foot(side, u) for side in SIDES)
        going, ahead, swings = stride
        turn = multiply(
            about_z(yaw - _PELVIS_YAW * going * ahead),
            multiply(about_x(-_PELVIS_LIST * going * swings), about_y(_LEAN * going)),
        )
        side = shift - _SWAY * min(going, 1.0) * swings
        c, s = math.cos(yaw), math.sin(yaw)
        pelvis = (x + c * self._forward - s * side, y + s * self._forward + c * side, height)
        return Stand(pelvis, multiply(turn, WORLD_FROM_REST), yaw, feet, stride)  # type: ignore[arg-type]

    def _foot(self, side: str, u: float) -> FootPose:
        step, leg, left = self._step, self.legs[side], SIGN[side]
        if step is None:
            pose = self._feet[side].pose(leg, left, self._phase)
        elif side == step.side:
            pose = swung(leg, left, step.before, step.after, step.start, u)
        else:
            pose = self._feet[side].pose(leg, left, step.start + u)
        return FootPose(plus(pose.ankle, (0.0, 0.0, GROUND)), pose.turn, pose.bend)

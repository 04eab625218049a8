"""Scenario: two people who shake hands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting import arms, clasp, reaching
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.legs import about
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: How far each walks [m], and how fast [m/s].
DISTANCE, SPEED = 1.5, 1.2
#: Share of the arm's length that is used: hands are shaken with a bent elbow.
_STRETCHED = 0.95
#: Height of the hands as a part of the mean stature.
_HEIGHT = 0.63
#: Each walks this far to the left of the line through both hands [m]: right hands face each other.
_ASIDE = 0.07
#: Between each palm and the middle before and after the clasp [m].
_OPEN = 0.06
#: Fingers point down by this, so that they close around the edge of the other's hand [rad].
_SLOPE = np.radians(34.0)
#: Where the hands meet, as a part of the way from wrist to knuckle: web against web.
_WEB = 0.97
#: Where the right elbow points, to a person who walks along x.
_ELBOW = np.array([-0.3, -1.0, -0.3])
# Seconds: the hand goes up before the last step ends; it is up, palms meet, fingers close; a
# shake; the hand is down.
_EARLY, _RAISE, _MEET, _GRIP, _SHAKE, _DOWN = 0.4, 0.8, 0.35, 0.3, 0.5, 0.8


@dataclass(frozen=True)
class Clasp:
    """Times of a handshake, (T,).

    Attributes:
        share: How much of the arm is with the hand, 0 hanging to 1.
        met: 0 palms apart to 1 palms pressed together.
        gripped: 0 fingers straight to 1 fingers around the other hand.
        lifted: Of the hands above where they met [m].
    """

    share: Array
    met: Array
    gripped: Array
    lifted: Array

    @classmethod
    def over(cls, times: Array, start: float, shakes: int, height: float) -> Clasp:
        """A handshake that begins at `start` [s]."""
        up = start + _RAISE
        shaking = up + _MEET + _GRIP
        over = shaking + shakes * _SHAKE
        open_, apart = over + _GRIP, over + _GRIP + _MEET
        share = ease((times - start) / _RAISE) * (1.0 - ease((times - apart) / _DOWN))
        met = ease((times - up) / _MEET) * (1.0 - ease((times - open_) / _MEET))
        gripped = ease((times - up - _MEET) / _GRIP) * (1.0 - ease((times - over) / _GRIP))
        cycles = np.clip((times - shaking) / _SHAKE, 0.0, shakes)
        # From rest to rest: the first and the last quarter swell and fade.
        swell = ease(4.0 * cycles) * ease(4.0 * (shakes - cycles))
        return cls(share, met, gripped, height * swell * np.sin(2.0 * np.pi * cycles))


def _start() -> float:
    """When the arms begin to rise [s]."""
    plan = Walk(distance=DISTANCE, speed=SPEED)
    return float(plan.clock()[0][-1]) - plan.after - _EARLY


def held(shakes: int) -> tuple[float, float]:
    """From when to when the fingers are around the other's hand [s]."""
    begin = _start() + _RAISE + _MEET + _GRIP
    return begin, begin + shakes * _SHAKE


def build(
    *,
    fps: float = 30.0,
    shakes: int = 3,
    height: float = 0.04,
    press: float = 0.003,
    stature: float = 1.60,
    body: Body | None = None,
    other: Body | None = None,
) -> Sequence:
    """Two people walk up to each other, clasp right hands, shake them and let go.

    Args:
        fps: Frames per second.
        shakes: How often the hands go up and down.
        height: Of a shake up, and down [m].
        press: How far each palm wants to go into the other's [m]: how hard they press.
        stature: Of the second person [m].
        body: The first person; None: the default body.
        other: The second person; None: the default body of that stature.
    """
    if not is_whole(shakes, least=0, plain=False) or shakes > 50:
        raise InputError(f"shakes: found {shown(shakes)}, expected 0 to 50, a whole number")
    height = number(height, "height", least=0.0, most=0.10, unit="m")
    press = number(press, "press", least=0.0, most=0.02, unit="m")
    people = (stage.actor(body), stage.partner(other, stature))
    level = _HEIGHT * float(np.mean([one.stature for one in people]))
    start, plan = _start(), Walk(distance=DISTANCE, speed=SPEED)
    after = held(shakes)[1] - start + _GRIP + _MEET + _DOWN - _EARLY + 0.3
    motions = []
    for person, heading in zip(people, (0.0, np.pi), strict=True):
        # The first person's hand is at the origin; the second one comes the other way.
        ahead = np.array([np.cos(heading), np.sin(heading)])
        left = np.array([-ahead[1], ahead[0]])
        x, y = _ASIDE * left - (_ahead(person, plan, level) + DISTANCE) * ahead
        way = Walk(
            distance=DISTANCE, speed=SPEED, start=(float(x), float(y)), heading=heading, after=after
        )
        base = walk(person, way, fps)
        clock = np.arange(len(base)) / base.fps
        times = Clasp.over(clock, start, shakes, height)
        motions.append(_shaking(person, base, heading, times, level, press))
    return Sequence(tuple(motions), stage.floor(), people)


def _ahead(body: Body, plan: Walk, level: float) -> float:
    """From where a walker stands to the middle of both hands, ahead [m].

    Raises:
        InputError: The hands are at a level that this body's arm does not reach.
    """
    base = walk(body, plan, 2.0)
    shoulder = body.joints(base[len(base) - 1])[JOINT_INDEX["right_shoulder"]]
    arm = arms.arm_of(body, "right")
    across = abs(shoulder[1]) - _ASIDE - reaching.palm_depth(body, "right")
    left = (_STRETCHED * arm.length) ** 2 - across**2 - (shoulder[2] - level) ** 2
    if left < 0.2**2:
        raise InputError(
            f"stature: found {body.stature:.2f} m, whose hand does not meet one at {level:.2f} m; "
            "expected people more alike"
        )
    palm = np.cos(_SLOPE) * _WEB * reaching.knuckle_ahead(body, "right")
    return float(shoulder[0] - DISTANCE + np.sqrt(left) + palm)


def _shaking(
    body: Body, base: Motion, heading: float, times: Clasp, level: float, press: float
) -> Motion:
    """A walk with the right hand in a handshake above the origin.

    Args:
        body: The person's body.
        base: The walk.
        heading: Of the walk about z [rad].
        times: When the hand does what.
        level: Height of the middle of the palms [m].
        press: How far the palm goes beyond the middle [m].
    """
    turn = about(2, heading)
    along = turn @ np.array([np.cos(_SLOPE), 0.0, -np.sin(_SLOPE)])
    inward = turn @ np.array([0.0, 1.0, 0.0])
    hand = np.broadcast_to(arms.palm_frame("right", along, inward), (len(base), 3, 3))
    apart = _OPEN + times.met * (-press - _OPEN)
    wrist = np.array([0.0, 0.0, level]) - _WEB * reaching.knuckle_ahead(body, "right") * along
    wrist = wrist - (reaching.palm_depth(body, "right") + apart)[:, None] * inward
    wrist[:, 2] += times.lifted
    fingers = clasp.fingers(body, times.gripped)
    elbow = turn @ _ELBOW
    return reaching.reach(
        body, base, "right", wrist, hand, times.share, pole=elbow, fingers=fingers
    )

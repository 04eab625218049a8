"""Scenario: fingers lift the lid of a laptop."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import number
from halfphysics.motion.easing import ease
from halfphysics.scenarios.acting import arms, hands, reaching
from halfphysics.scenarios.props import laptop, stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: Near edge of the desk ahead of the person [m].
_EDGE = 0.35
#: Point of the desk below the middle of the hinge [m]: the base begins at the desk's edge.
HINGE = (_EDGE + 0.012 + laptop.DEPTH, -0.18, laptop.DESK)
#: Where the right wrist waits, over the thigh [m].
_WAITS = (0.10, -0.20, 0.70)
#: Where the finger tips are under the lid [m] from the hinge.
ALONG = laptop.DEPTH - 0.022
#: Between them and the lid before they touch it, and when they leave it [m].
_UNDER, _AWAY = 0.003, 0.06
#: Fingers point up by this under the shut lid and at the open one; their flexion [degrees].
_PITCH, _CURLS = (7.0, 35.0), (3.0, 4.0, 4.0)
#: Where the right elbow points.
_ELBOW = np.array([-0.9, -0.2, -0.4])
# Seconds: the hand is before the desk, under the lid, has opened it, leaves it, rests again.
_START, _BESIDE, _LOW, _IN, _LIFT, _OPEN, _LEAVE, _END = 0.1, 0.9, 1.4, 1.9, 2.0, 4.0, 4.3, 5.3


def build(
    *,
    fps: float = 30.0,
    mass: float = 0.35,
    damping: float = 0.5,
    press: float = 0.006,
    body: Body | None = None,
) -> Sequence:
    """A person at a desk opens a laptop, finger tips under the front edge of its lid.

    Args:
        fps: Frames per second.
        mass: Of the lid [kg].
        damping: Of its hinge [N m s].
        press: How far beyond the lid's inner side the finger tips want to be [m].
        body: The person's body; None: the default body, which desk and chair are sized for.
    """
    press = number(press, "press", least=0.0, most=0.03, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    laptop.add_laptop(scene, HINGE, mass=mass, damping=damping, angle=0.0)
    lean = laptop.Lean(start=_LIFT, back=_LEAVE, seconds=1.0, degrees=18.0)
    base = laptop.seated(actor, scene, _END + 0.3, fps, edge=_EDGE, lean=lean, right=_WAITS)
    return Sequence(_opening(actor, base, press), scene, actor)


def lid_angle(times: Array) -> Array:
    """How far the lid is meant to be open (T,) [rad] at times [s]."""
    angle: Array = laptop.OPEN * ease((times - _LIFT) / (_OPEN - _LIFT))
    return angle


def _opening(body: Body, base: Motion, press: float) -> Motion:
    """The motion of the seated person with the right hand under the lid."""
    times = np.arange(len(base)) / base.fps

    def gone(start: float, end: float) -> Array:
        out: Array = ease((times - start) / (end - start))
        return out

    left, angle = gone(_LEAVE, _LEAVE + 0.5), lid_angle(times)
    curls = np.broadcast_to(_CURLS, (len(times), 3))
    pitch = np.radians(_PITCH[0] + angle / laptop.OPEN * (_PITCH[1] - _PITCH[0]))
    middle, radius = hands.tip(body, "right", curls)
    # Tips below the lid, against its inner side, and away from it.
    off = _UNDER - gone(_LIFT, _LIFT + 0.3) * (press + _UNDER) + left * (press + _AWAY)
    zero = np.zeros(len(times))
    outward = np.stack([np.sin(angle), zero, np.cos(angle)], axis=-1)
    along = np.stack([-np.cos(angle), zero, np.sin(angle)], axis=-1)
    tips = np.add(HINGE, (0.0, 0.0, laptop.hinge_height()))
    tips = tips + ALONG * along - (radius + off)[:, None] * outward
    fingers = np.stack([np.cos(pitch), zero, np.sin(pitch)], axis=-1)
    facing = np.stack([-np.sin(pitch), zero, np.cos(pitch)], axis=-1)
    wrist = tips - middle[:, :1] * fingers - middle[:, 1:] * facing
    # From above the lap down before the desk's edge, then ahead; back up, then to the lap.
    wrist[:, 0] -= 0.07 * (1.0 - gone(_LOW, _IN))
    wrist = wrist + (1.0 - gone(_BESIDE, _LOW))[:, None] * [-0.03, -0.06, 0.10]
    above = np.add(_WAITS, (0.02, 0.0, 0.20))
    wrist = wrist + gone(_LEAVE + 0.2, _LEAVE + 0.9)[:, None] * (above - wrist)
    hand = arms.palm_frame("right", fingers, facing)
    share = gone(_START, _BESIDE) * (1.0 - gone(_LEAVE + 0.6, _END))
    motion = reaching.reach(body, base, "right", wrist, hand, share, pole=_ELBOW, fingers={})
    return hands.shaped(body, motion, "right", share, curls=curls)

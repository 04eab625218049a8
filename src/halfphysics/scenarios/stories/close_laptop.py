"""Scenario: a hand closes the lid of a laptop."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import number
from halfphysics.motion.easing import ease
from halfphysics.scenarios.acting import arms, hands, reaching
from halfphysics.scenarios.acting.legs import about
from halfphysics.scenarios.props import laptop, stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: Point of the desk below the middle of the hinge [m].
HINGE = (0.49, -0.08, laptop.DESK)
#: Near edge of the desk ahead of the person [m].
_EDGE = 0.24
#: Where the finger pads are on the lid [m] from the hinge.
ALONG = 0.198
#: Before they touch: behind the lid, and above it [m].
_BEHIND, _ABOVE = 0.03, 0.12
#: At the open lid and at the shut one [degrees]: how far the fingers point down, their flexion.
_PITCH, _CURLS = (45.0, 0.0), ((32.0, 25.0, 15.0), (8.0, 4.0, 4.0))
#: Fingers point this much to the left of ahead [degrees]: the elbow is out at the right.
_YAW = 30.0
#: Where the right elbow points.
_ELBOW = np.array([-0.3, -1.0, -0.3])
# Seconds: the hand is up, above the lid, behind it, has closed it, leaves it, rests again.
_START, _UP, _OVER, _BEHIND_IT, _PULL, _SHUT, _LEAVE, _END = 0.2, 0.9, 1.2, 1.6, 1.6, 3.2, 3.6, 4.5


def build(
    *,
    fps: float = 30.0,
    mass: float = 0.35,
    damping: float = 0.5,
    press: float = 0.01,
    body: Body | None = None,
) -> Sequence:
    """A person at a desk closes the lid of a laptop with the fingers of one hand.

    Args:
        fps: Frames per second.
        mass: Of the lid [kg].
        damping: Of its hinge [N m s].
        press: How far beyond the lid's outer side the finger pads want to be [m].
        body: The person's body; None: the default body, which desk and chair are sized for.
    """
    press = number(press, "press", least=0.0, most=0.03, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    laptop.add_laptop(scene, HINGE, mass=mass, damping=damping, angle=laptop.OPEN)
    lean = laptop.Lean(start=_START, back=_LEAVE, seconds=1.0, degrees=22.0)
    base = laptop.seated(actor, scene, _END + 0.3, fps, edge=_EDGE, lean=lean)
    return Sequence(_closing(actor, base, press), scene, actor)


def lid_angle(times: Array) -> Array:
    """How far the lid is meant to be open (T,) [rad] at times [s]."""
    angle: Array = laptop.OPEN * (1.0 - ease((times - _PULL) / (_SHUT - _PULL)))
    return angle


def _closing(body: Body, base: Motion, press: float) -> Motion:
    """The motion of the seated person with the right hand on the lid."""
    times = np.arange(len(base)) / base.fps

    def gone(start: float, end: float) -> Array:
        out: Array = ease((times - start) / (end - start))
        return out

    pulled, left = gone(_PULL, _SHUT), gone(_LEAVE, _LEAVE + 0.5)
    angle = lid_angle(times)
    curls = _CURLS[0] + pulled[:, None] * np.subtract(_CURLS[1], _CURLS[0])
    pitch = np.radians(_PITCH[0] + pulled * (_PITCH[1] - _PITCH[0]))
    # Pads on the lid's outer side, as far beyond it as they press, once they are behind it.
    off = laptop.LID + _BEHIND + gone(_PULL, _PULL + 0.3) * (-press - _BEHIND)
    zero = np.zeros(len(times))
    outward = np.stack([np.sin(angle), zero, np.cos(angle)], axis=-1)
    along = np.stack([-np.cos(angle), zero, np.sin(angle)], axis=-1)
    pads = np.add(HINGE, (0.0, 0.0, laptop.hinge_height()))
    pads = pads + ALONG * along + off[:, None] * outward
    pads[:, 2] += _ABOVE * (1.0 - gone(_OVER, _BEHIND_IT))
    turned = about(2, np.radians(_YAW))
    fingers = np.stack([np.cos(pitch), zero, -np.sin(pitch)], axis=-1) @ turned.T
    facing = np.stack([-np.sin(pitch), zero, -np.cos(pitch)], axis=-1) @ turned.T
    way = hands.pad(body, "right", curls)
    wrist = pads - way[:, :1] * fingers - way[:, 1:] * facing
    # Up beside the laptop first, then over its lid; when it is shut, up a little and aside.
    beside = np.array([HINGE[0] - 0.20, HINGE[1] - 0.22, laptop.DESK + 0.40])
    wrist = beside + gone(_START + 0.4, _OVER)[:, None] * (wrist - beside)
    wrist = wrist + left[:, None] * [0.0, -0.30, 0.08]
    hand = arms.palm_frame("right", fingers, facing)
    share = gone(_START, _UP) * (1.0 - gone(_LEAVE + 0.3, _END))
    motion = reaching.reach(body, base, "right", wrist, hand, share, pole=_ELBOW, fingers={})
    return hands.shaped(body, motion, "right", share, curls=curls, thumb=False)

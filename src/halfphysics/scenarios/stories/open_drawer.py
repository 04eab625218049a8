"""Scenario: hooked fingers pull a drawer open by its bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import number
from halfphysics.motion.easing import ease
from halfphysics.scenarios.acting import arms, hands, reaching
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.props import chest, stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: Outer side of the shut fronts before the person [m].
FRONT = 0.70
#: Fingers point down by this, and their flexion [degrees]: their second bones hang straight down.
_PITCH, _CURLS = 20.0, (10.0, 60.0, 12.0)
#: Before it pulls the hand is behind the bar [m], and above it before that.
_BEHIND, _ABOVE = 0.012, 0.09
# Seconds: the hand is above the bar, behind it, pulls, has pulled, is up again, hangs again.
_START, _OVER, _HOOKED, _PULL, _OUT, _LEAVE, _UP, _END = 0.2, 1.1, 1.6, 1.7, 3.1, 3.4, 3.9, 4.8


def build(
    *,
    fps: float = 30.0,
    mass: float = 4.0,
    damping: float = 20.0,
    beyond: float = 0.015,
    body: Body | None = None,
) -> Sequence:
    """A person hooks the fingers behind a drawer's bar and pulls it open.

    Args:
        fps: Frames per second.
        mass: Of the drawer and what is in it [kg].
        damping: Of its rails [N s/m].
        beyond: How much farther than the drawer comes out the hand wants to pull it [m].
        body: The person's body; None: the default body, which the chest is sized for.
    """
    beyond = number(beyond, "beyond", least=-chest.TRAVEL, most=0.05, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    chest.add_chest(scene, FRONT, mass=mass, damping=damping, out={})
    act = Act(actor)
    lean = {"pelvis": (0.12, 0.0, act.standing - 0.02), "turn": (0.0, 10.0, 0.0)}
    act.move(_START, _HOOKED - _START, **lean, bend=(6.0, 0.0, 0.0), nod=6.0)
    upright = {"pelvis": (0.0, 0.0, act.standing), "turn": (0.0, 0.0, 0.0)}
    act.move(_PULL, _OUT - _PULL, **upright, bend=(0.0, 0.0, 0.0))
    act.move(_LEAVE, 1.0, nod=0.0)
    base = act.motion(_END + 0.3, fps)
    return Sequence(_pulling(actor, base, beyond), scene, actor)


def meant(times: Array, beyond: float) -> Array:
    """How far the drawer is meant to be out (T,) [m] at times [s]."""
    out: Array = (chest.TRAVEL + beyond) * ease((times - _PULL) / (_OUT - _PULL))
    return out


def _pulling(body: Body, base: Motion, beyond: float) -> Motion:
    """The motion of the standing person with the right hand at the bar of the top drawer."""
    times = np.arange(len(base)) / base.fps

    def gone(start: float, end: float) -> Array:
        out: Array = ease((times - start) / (end - start))
        return out

    pitch = np.radians(_PITCH)
    fingers = np.array([np.cos(pitch), 0.0, -np.sin(pitch)])
    facing = np.array([-np.sin(pitch), 0.0, -np.cos(pitch)])
    curls = np.broadcast_to(_CURLS, (len(times), 3))
    way = hands.hook(body, "right", curls)
    # The inner side of the fingers: above the gap, down into it, against the bar, out again.
    at = np.zeros((len(times), 3))
    at[:, 0] = FRONT - chest.BAR_OUT + chest.BAR_RADIUS - meant(times, beyond)
    at[:, 0] += _BEHIND * (1.0 - gone(_HOOKED, _PULL) + gone(_LEAVE, _LEAVE + 0.2))
    at[:, 2] = chest.DRAWERS["top"]
    at[:, 2] += _ABOVE * (1.0 - gone(_OVER, _HOOKED) + gone(_LEAVE + 0.15, _UP))
    wrist = at - way[:, :1] * fingers - way[:, 1:] * facing
    wrist = wrist + (1.0 - gone(_OVER - 0.4, _OVER + 0.1))[:, None] * [-0.12, 0.0, 0.02]
    wrist = wrist + gone(_UP - 0.2, _END)[:, None] * [-0.15, -0.15, 0.0]
    hand = np.broadcast_to(arms.palm_frame("right", fingers, facing), (len(times), 3, 3))
    share = gone(_START, _OVER) * (1.0 - gone(_UP, _END))
    motion = reaching.reach(
        body, base, "right", wrist, hand, share, pole=np.array([-0.64, 0.0, -0.77]), fingers={}
    )
    return hands.shaped(body, motion, "right", share, curls=curls, thumb=False)

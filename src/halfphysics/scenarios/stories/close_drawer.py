"""Scenario: a hand pushes an open drawer shut."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.validation import number
from halfphysics.motion.easing import ease
from halfphysics.scenarios.acting import hands
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.props import chest, stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

#: Outer side of the shut fronts before the person [m].
FRONT = 0.60
#: Where the finger pads are on the front [m]: from its middle to the left and up; beside the bar.
_PLACE = (-0.17, 0.01)
#: Between them and the front before the push [m].
_BEFORE = 0.04
#: Where the fingers point: up and ahead, for a wrist bends no farther; their flexion [degrees].
_FINGERS, _CURLS = np.array([0.76, 0.36, 0.54]), (10.0, 12.0, 8.0)
#: Where the elbows point (ahead, outward, up).
_ELBOWS = (-0.78, 0.45, -0.42)
# Seconds: the hand is up, begins to push, has pushed, begins to draw back, hangs again.
_UP, _PUSH, _SHUT, _BACK, _DOWN = 1.0, 1.1, 2.3, 2.6, 3.6


def build(
    *,
    fps: float = 30.0,
    mass: float = 4.0,
    damping: float = 20.0,
    travel: float = 0.28,
    press: float = 0.02,
    body: Body | None = None,
) -> Sequence:
    """A person pushes an open drawer shut with the fingers of one hand.

    Args:
        fps: Frames per second.
        mass: Of the drawer and what is in it [kg].
        damping: Of its rails [N s/m].
        travel: How far it is out at first, and so is pushed [m].
        press: How far beyond the shut front the finger pads want to go [m].
        body: The person's body; None: the default body, which the chest is sized for.
    """
    travel = number(travel, "travel", least=0.0, most=chest.TRAVEL, unit="m")
    press = number(press, "press", least=0.0, most=0.05, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    chest.add_chest(scene, FRONT, mass=mass, damping=damping, out={"top": travel})

    fingers = _FINGERS / np.linalg.norm(_FINGERS)
    ahead = np.array([1.0, 0.0, 0.0])
    facing = ahead - (ahead @ fingers) * fingers
    way = hands.pad(actor, "right", [_CURLS])[0]
    pads = np.array([FRONT, _PLACE[0], chest.DRAWERS["top"] + _PLACE[1]])
    there = pads - way[0] * fingers - way[1] * facing / np.linalg.norm(facing)
    before = there - (travel + _BEFORE) * ahead
    act = Act(actor)
    # Turned so beside the chest, before the hand goes up to the front.
    low = (0.06, -0.32, act["pelvis"][2] + 0.06)
    act.begin(right_palm=-ahead, right_fingers=fingers, right_hand=low)
    act.begin(elbows=_ELBOWS, curl=12.0)
    act.move(0.1, 0.7, right_hold=1.0)
    act.move(0.5, _UP - 0.5, right_hand=before)
    act.move(_PUSH, _SHUT - _PUSH, right_hand=there + press * ahead)
    lean = {"pelvis": (0.10, 0.0, act.standing - 0.02), "turn": (0.0, 10.0, 0.0)}
    act.move(_PUSH, _SHUT - _PUSH, **lean, bend=(8.0, 4.0, 0.0), nod=6.0)
    upright = {"pelvis": (0.0, 0.0, act.standing), "turn": (0.0, 0.0, 0.0)}
    act.move(_BACK, _DOWN - _BACK, **upright, bend=(0.0, 0.0, 0.0), nod=0.0)
    act.move(_BACK, 0.6, right_hand=before)
    act.move(_BACK + 0.3, _DOWN - _BACK - 0.3, right_hold=0.0, right_hand=low)
    motion = act.motion(_DOWN + 0.3, fps)
    times = np.arange(len(motion)) / motion.fps
    share = ease((times - 0.1) / (_UP - 0.1)) * ease((_DOWN - times) / (_DOWN - _BACK))
    motion = hands.shaped(actor, motion, "right", share, curls=_CURLS)
    return Sequence(motion, scene, actor)

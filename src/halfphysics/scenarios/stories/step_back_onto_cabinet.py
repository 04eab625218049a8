"""Scenario: stepping back and leaning on a TV cabinet before a wall."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.scenarios.acting.acting import SIDES, Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import block
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The cabinet [m]: front, height; the wall behind it.
_FRONT, _TOP, _WALL = -0.85, 0.58, -1.27


# The left hand on its top [m]: from the front edge, from the middle; where its fingers point.
_IN, _ACROSS, _FINGERS = 0.05, 0.36, (0.26, 0.97, 0.0)


# At rest after the deepest [m]: the pelvis this much higher than that sinks by 0, and ahead.
_RESTS, _AHEAD = 0.010, 0.02


def build(*, fps: float = 30.0, sink: float = 0.06, body: Body | None = None) -> Sequence:
    """A person steps back and leans on a TV cabinet, sinks into it and into the wall behind.

    Args:
        fps: Frames per second.
        sink: How far into the cabinet the motion goes [m], before it comes to rest: 0 to 0.15.
        body: The person's body; None: the default body, for which the cabinet is placed.
    """
    sink = number(sink, "sink", least=0.0, most=0.15, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    block(scene, "cabinet", (_WALL, -0.9, 0.0), (_FRONT, 0.9, _TOP))
    block(scene, "wall", (_WALL - 0.2, -2.0, 0.0), (_WALL, 2.0, 2.5))

    act = Act(actor)
    high = act.standing
    for side, start, x in (("right", 0.3, -0.34), ("left", 0.85, -0.60), ("right", 1.45, -0.60)):
        act.step(side, start, 0.6, (x, SIDES[side] * 0.15, act[f"{side}_foot"][2]))
    act.move(0.4, 1.7, pelvis=(-0.56, 0.0, high - 0.03))
    act.lift("pelvis", 0.3, 0.6, (0.0, 0.03, -0.01))
    act.lift("pelvis", 0.85, 0.6, (0.0, -0.03, -0.01))
    act.move(1.3, 1.0, turn=(0.0, 24.0, 0.0), bend=(10.0, 0.0, 0.0))
    act.move(1.7, 1.8, pelvis=(-0.95, 0.0, _TOP + 0.11 - sink))
    act.move(1.7, 1.2, **act.both(hold=1.0))
    act.begin(**act.both(palm=(0.0, 0.0, 1.0), fingers=_FINGERS))
    act.begin(**act.both(hand=(_FRONT - _IN, _ACROSS, _TOP + 0.03)))
    act.move(2.4, 1.2, turn=(0.0, -22.0, 0.0), bend=(-4.0, 0.0, 0.0), nod=8.0)
    act.move(3.5, 1.0, pelvis=(-0.95 + _AHEAD, 0.0, _TOP + 0.11 + _RESTS))
    return Sequence(act.motion(4.8, fps), scene, actor)

"""Scenario: sitting down on a bed's edge and sliding in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.scenarios.acting.acting import SIDES, Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import CLOTH, block, cushion
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The bed [m]: its edge, how deep and wide it is, top and thickness of its mattress.
_EDGE, _DEPTH, _WIDTH, _TOP, _THICK = -0.17, 1.4, 2.0, 0.48, 0.24


# Where the left fingers point beside the body, on the mattress: outwards and back.
_FINGERS = (-0.34, 0.94, 0.0)


def build(
    *,
    fps: float = 30.0,
    sink: float = 0.07,
    soft: str | None = None,
    body: Body | None = None,
) -> Sequence:
    """A person sits down on a bed's edge, slides in and lays the legs on its mattress, a mesh.

    Args:
        fps: Frames per second.
        sink: How far into the mattress the motion goes [m]: 0 to 0.1.
        soft: Material of the mattress, such as "mattress"; None: it is hard.
        body: The person's body; None: the default body, whose size the bed has.
    """
    sink = number(sink, "sink", least=0.0, most=0.10, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    block(
        scene,
        "frame",
        (_EDGE - _DEPTH, -0.5 * _WIDTH, 0.0),
        (_EDGE - 0.03, 0.5 * _WIDTH, _TOP - _THICK),
    )
    scene.add_static(
        "mattress",
        cushion((_DEPTH, _WIDTH, _THICK)),
        position=(_EDGE - 0.5 * _DEPTH, 0.0, _TOP - 0.5 * _THICK),
        friction=CLOTH,
        soft=soft,
    )

    act = Act(actor)
    sat = _TOP + 0.11 - sink
    act.begin(**act.both(palm=(0.0, 0.0, 1.0), fingers=_FINGERS))
    act.begin(**act.both(hand=(_EDGE - 0.42, 0.34, _TOP + 0.16)))
    act.move(0.2, 1.0, turn=(0.0, 34.0, 0.0), bend=(16.0, 0.0, 0.0), nod=-16.0)
    act.move(0.2, 1.6, pelvis=(-0.40, 0.0, sat + sink))
    act.move(1.2, 0.9, turn=(0.0, -6.0, 0.0), bend=(6.0, 0.0, 0.0), nod=4.0)
    act.move(1.3, 0.6, pelvis=(-0.42, 0.0, sat))
    act.move(0.2, 0.9, **act.both(hold=1.0))
    act.move(1.1, 0.7, **act.both(hand=(_EDGE - 0.42, 0.34, _TOP + 0.015)))
    # Slides in: pelvis back, legs up and out.
    act.move(2.3, 1.2, pelvis=(-0.80, 0.0, sat), turn=(0.0, -18.0, 0.0), bend=(14.0, 0.0, 0.0))
    for side, start in (("left", 2.1), ("right", 2.5)):
        act.move(start, 0.9, **{f"{side}_hand": (_EDGE - 0.85, 0.36 * SIDES[side], _TOP + 0.015)})
        act.lift(f"{side}_hand", start, 0.9, (0.0, 0.0, 0.09))
    act.move(2.2, 1.2, knees=(0.4, 0.0, 1.0))
    for side, start in (("left", 2.3), ("right", 2.55)):
        y = SIDES[side]
        act.step(side, start, 1.5, (-0.06, 0.13 * y, _TOP + 0.06), 0.10)
        act.move(start, 1.4, **{f"{side}_toes": (8.0 * y, 55.0, 0.0)})
    return Sequence(act.motion(4.5, fps), scene, actor)

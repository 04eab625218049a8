"""Scenario: climbing onto a bed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.scenarios.acting.acting import SIDES, Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import CLOTH, block
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The bed [m]: its edge, how deep it is, half its width, its top.
_EDGE, _DEPTH, _HALF, _TOP = 0.42, 2.0, 0.8, 0.45


# The hands, ahead, before and after their step [m]; feet of who kneels, toes down [degrees], and
# their ankles over the knees' way in [m].
_REACH, _TOES, _ANKLE = (0.78, 1.12), (0.0, -122.0, 0.0), 0.12


def build(*, fps: float = 30.0, sink: float = 0.05, body: Body | None = None) -> Sequence:
    """A person climbs onto a bed on hands and knees, which sink into its mattress.

    Args:
        fps: Frames per second.
        sink: How far into the mattress the knees go [m]: 0.04 to 0.12.
        body: The person's body; None: the default body, whose size the bed has.
    """
    sink = number(sink, "sink", least=0.04, most=0.12, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    block(scene, "mattress", (_EDGE, -_HALF, 0.12), (_EDGE + _DEPTH, _HALF, _TOP), CLOTH)

    act = Act(actor)
    hand = _TOP + 0.01
    act.begin(
        elbows=(-0.6, 0.6, -0.6),
        **act.both(hand=(_REACH[0], 0.22, hand), palm=(0.0, 0.0, 1.0), fingers=(1.0, 0.0, 0.0)),
    )
    # Hands on the bed.
    act.move(0.2, 1.1, pelvis=(0.0, 0.0, 0.82), turn=(0.0, 62.0, 0.0), bend=(14.0, 0, 0), nod=-30)
    act.move(0.3, 1.0, **act.both(hold=1.0), curl=6.0)
    # One knee after the other: up and over the edge, then down.
    for side, start in (("right", 1.2), ("left", 2.3)):
        y = SIDES[side]
        act.move(start, 0.6, **{f"{side}_foot": (-0.12, 0.15 * y, _TOP + 0.14)})
        # The heel rises first, or the ankle would have to bend too far as the knee goes ahead.
        act.move(start - 0.1, 1.0, **{f"{side}_toes": _TOES})
        act.lift(f"{side}_foot", start - 0.1, 0.5, (0.0, 0.0, 0.03))
        act.move(start + 0.5, 0.9, **{f"{side}_foot": (0.24, 0.12 * y, _TOP + _ANKLE - sink)})
    act.move(1.2, 0.9, pelvis=(0.24, 0.0, 0.88), turn=(0.0, 68.0, 0.0))
    act.move(
        1.9,
        1.2,
        pelvis=(0.60, 0.0, _TOP + 0.455 - sink),
        turn=(0.0, 80.0, 0.0),
        bend=(0.0, 0.0, 0.0),
        knees=(1.0, 0.0, -0.6),
    )
    for side, start in (("left", 1.6), ("right", 2.3)):
        y = SIDES[side]
        act.move(start, 0.7, **{f"{side}_hand": (_REACH[1], 0.22 * y, hand)})
        act.lift(f"{side}_hand", start, 0.7, (0.0, 0.0, 0.07))
    return Sequence(act.motion(4.2, fps), scene, actor)

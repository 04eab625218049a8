"""Scenario: stretching arms and legs on a bed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import CLOTH, block
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The bed [m]: top of its mattress, foot end, head board, half its width.
_TOP, _FOOT, _HEAD, _HALF = 0.45, 1.05, -1.05, 0.8


# At rest after the stretch, seat, back, head and heels alike on the mattress: how far the pelvis
# goes in [m], lean and bend back [degrees], the ankles over the top [m].
_RESTS, _LIES, _BENDS, _FEET = 0.02, -91.0, -3.0, 0.06


def build(
    *,
    fps: float = 30.0,
    sink: float = 0.05,
    soft: str | None = None,
    body: Body | None = None,
) -> Sequence:
    """A person lies on a bed and stretches arms and legs, the hands through its head board.

    Args:
        fps: Frames per second.
        sink: How far into the mattress the motion goes [m], before it comes to rest: 0 to 0.12.
        soft: Material of the mattress, such as "mattress"; None: it is hard.
        body: The person's body; None: the default body, whose size the bed has.
    """
    sink = number(sink, "sink", least=0.0, most=0.12, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    block(scene, "mattress", (_HEAD, -_HALF, 0.15), (_FOOT, _HALF, _TOP), CLOTH, soft)
    block(scene, "headboard", (_HEAD - 0.2, -_HALF, 0.0), (_HEAD, _HALF, _TOP + 0.45))

    act = Act(actor)
    lying = _TOP + 0.122
    act.begin(
        pelvis=(0.0, 0.0, lying), turn=(0.0, -90.0, 0.0), knees=(0.5, 0.0, 1.0), nod=6.0,
        elbows=(-0.8, 0.5, 0.0),
        **act.both(arm=(0.02, 0.17, -0.45), foot=(0.46, 0.12, _TOP + 0.093)),
    )  # fmt: skip
    act.move(0.2, 1.0, pelvis=(0.0, 0.0, lying - sink))
    act.move(0.4, 1.5, **act.both(foot=(0.80, 0.24, _TOP + 0.045), toes=(12.0, 80.0, 0.0)))
    act.move(0.5, 1.3, **act.both(arm=(0.06, 0.48, 0.02)))
    act.move(1.2, 1.3, **act.both(arm=(0.06, 0.16, 0.47)))
    act.move(1.9, 0.9, **act.both(toes=(10.0, 52.0, 0.0), foot=(0.825, 0.27, _TOP + 0.03)), nod=-4)
    act.move(1.7, 1.1, bend=(-8.0, 0.0, 0.0))
    act.move(3.2, 0.8, bend=(_BENDS, 0.0, 0.0), **act.both(toes=(12.0, 75.0, 0.0)))
    act.move(
        3.2,
        1.0,
        pelvis=(0.0, 0.0, lying - _RESTS),
        turn=(0.0, _LIES, 0.0),
        **act.both(foot=(0.825, 0.27, _TOP + _FEET)),
    )
    act.move(3.2, 1.1, **act.both(arm=(0.10, 0.44, 0.20)))
    return Sequence(act.motion(4.6, fps), scene, actor)

"""Scenario: sitting down on a sofa."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.scenarios.acting.acting import Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import CLOTH, block
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The sofa [m]: height and front edge of its seat, front of its back rest, half its width inside.
_SEAT, _FRONT, _REST, _HALF = 0.44, -0.16, -0.68, 0.75


# At rest after the deepest [m]: as far in as a seat gives, and the pelvis this much farther ahead.
_RESTS, _AHEAD = 0.02, 0.045


#: When a person who stands up again begins to, is over the feet, and stands [s].
_RISES, _OVER, _STANDS = 4.8, 5.6, 7.6


def build(
    *,
    fps: float = 30.0,
    sink: float = 0.08,
    soft: str | None = None,
    rise: bool = False,
    body: Body | None = None,
) -> Sequence:
    """A person sits down on a sofa, sinks into its seat and leans back into its rest.

    Args:
        fps: Frames per second.
        sink: How far into the seat the motion goes [m], before it comes to rest: 0 to 0.15.
        soft: Material of seat and rest, such as "sofa"; None: they are hard.
        rise: Whether the person stands up again.
        body: The person's body; None: the default body, whose size the sofa has.
    """
    sink = number(sink, "sink", least=0.0, most=0.15, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    out = _HALF + 0.16
    block(scene, "seat", (_REST, -_HALF, 0.08), (_FRONT, _HALF, _SEAT), CLOTH, soft)
    block(scene, "rest", (_REST - 0.2, -out, 0.08), (_REST, out, 0.86), CLOTH, soft)
    for side, low, high in (("left", _HALF, out), ("right", -out, -_HALF)):
        block(scene, f"{side}_arm", (_REST, low, 0.08), (_FRONT, high, 0.62), CLOTH)

    act = Act(actor)
    act.begin(turn=(0.0, 2.0, 0.0))
    sat = _SEAT + 0.115
    act.move(0.3, 1.1, turn=(0.0, 46.0, 0.0), bend=(26.0, 0.0, 0.0), nod=-18.0)
    act.move(0.3, 1.5, pelvis=(-0.42, 0.0, sat))
    act.move(0.2, 0.9, **act.both(arm=(0.36, 0.10, -0.28)))
    act.move(1.4, 1.2, turn=(0.0, -8.0, 0.0), bend=(4.0, 0.0, 0.0), nod=4.0)
    act.move(1.6, 1.5, pelvis=(-0.50, 0.0, sat - sink))
    act.move(2.1, 1.1, turn=(0.0, -22.0, 0.0), bend=(2.0, 0.0, 0.0), nod=18.0)
    act.move(3.1, 1.0, pelvis=(-0.50 + _AHEAD, 0.0, sat - _RESTS))
    act.move(2.2, 1.2, **act.both(arm=(0.26, 0.16, -0.36)))
    if not rise:
        return Sequence(act.motion(4.6, fps), scene, actor)
    # Ahead until the centre of mass is over the feet, then up.
    act.move(_RISES, 1.0, turn=(0.0, 44.0, 0.0), bend=(26.0, 0.0, 0.0), nod=-16.0)
    act.move(_RISES, 1.0, **act.both(arm=(0.36, 0.10, -0.28)), pelvis=(-0.40, 0.0, sat - _RESTS))
    act.move(_OVER, 1.3, pelvis=(0.0, 0.0, act.standing))
    act.move(_OVER + 0.3, 1.2, turn=(0.0, 2.0, 0.0), bend=(0.0, 0.0, 0.0), nod=0.0)
    act.move(_OVER + 0.3, 1.2, **act.both(arm=(0.10, 0.12, -0.47)))
    return Sequence(act.motion(_STANDS, fps), scene, actor)

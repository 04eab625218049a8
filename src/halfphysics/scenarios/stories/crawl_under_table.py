"""Scenario: crawling under a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import number
from halfphysics.scenarios.acting.acting import SIDES, Act
from halfphysics.scenarios.props import stage
from halfphysics.scenarios.props.furniture import table
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

# The table [m]: from where to where along the way, half its width, height and thickness of its top.
_NEAR, _FAR, _HALF, _TOP, _THICK = 0.92, 1.62, 0.75, 0.685, 0.08
# Of a crawl [m]: height of the pelvis, of the ankles and wrists, length of a step.
_LOW, _ANKLE, _WRIST, _STEP = 0.455, 0.13, 0.055, 0.35
# The hands ahead of the pelvis [m]; feet, toes on the floor, heels up [degrees].
_REACH, _TOES = 0.60, (0.0, -130.0, 0.0)
_PACE = 0.55  # seconds a step


def build(*, fps: float = 30.0, hunch: float = 0.07, body: Body | None = None) -> Sequence:
    """A person crawls under a table and raises the back into its top on the way.

    Args:
        fps: Frames per second.
        hunch: How far the pelvis is raised under the table [m]: 0 to 0.075.
        body: The person's body; None: the default body, whose size the table has.
    """
    hunch = number(hunch, "hunch", least=0.0, most=0.075, unit="m")
    actor = stage.actor(body)
    scene = stage.floor()
    table(scene, (_NEAR, -_HALF), (_FAR, _HALF), _TOP, _THICK)

    act = Act(actor)
    act.begin(
        pelvis=(0.0, 0.0, _LOW), turn=(0.0, 86.0, 0.0), knees=(0.5, 0.0, -1.0), nod=-12.0,
        elbows=(-0.2, 0.6, -0.8), curl=5.0,
        **act.both(hold=1.0, palm=(0.0, 0.0, 1.0), fingers=(1.0, 0.0, 0.0)),
        **act.both(toes=_TOES),
    )  # fmt: skip
    for side, ahead in (("left", 0.5), ("right", -0.5)):
        y, x = SIDES[side], 0.5 * ahead * _STEP
        act.begin(**{
            f"{side}_foot": (x - 0.42, 0.12 * y, _ANKLE),
            f"{side}_hand": (_REACH - x, 0.20 * y, _WRIST),
        })  # fmt: skip
    steps = 8
    side = "right"
    for k in range(steps):
        # A knee and the other hand go ahead together.
        other = "left" if side == "right" else "right"
        start = 0.2 + k * _PACE
        part = 0.5 if k in (0, steps - 1) else 1.0
        to = act[f"{side}_foot"] + (part * _STEP, 0.0, 0.0)
        act.step(side, start, 0.9 * _PACE, to, 0.02)
        act.move(
            start, 0.9 * _PACE, **{f"{other}_hand": act[f"{other}_hand"] + (part * _STEP, 0, 0)}
        )
        act.lift(f"{other}_hand", start, 0.9 * _PACE, (0.0, 0.0, 0.05))
        side = other
    travelled = 0.5 * (steps - 1) * _STEP
    act.move(0.0, 0.4 + steps * _PACE, pelvis=(travelled, 0.0, _LOW))
    act.lift("pelvis", 2.5, 2.0, (0.0, 0.0, hunch))
    act.lift("bend", 2.5, 2.0, (20.0, 0.0, 0.0))
    return Sequence(act.motion(0.6 + steps * _PACE, fps), scene, actor)

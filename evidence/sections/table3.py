"""Table 3: joint torques in place of joint velocities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evidence import published
from evidence.model import Content, Options, Section, Task
from evidence.runs import ablations
from evidence.runs.choices import LIMP, Choice

TORQUE = "joint torques"
RUNS: dict[str, Choice] = {ablations.HALF_PHYSICS: LIMP, TORQUE: {**LIMP, "mode": "torque"}}


def tasks(options: Options) -> list[Task]:
    """One task per motion."""
    return ablations.tasks(options, RUNS, TORQUE)


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """Rows of velocities and torques for every group of motions."""
    rows = []
    for group in ablations.groups(options):
        rows.append(ablations.unchanged(group, values))
        rows.append(
            ablations.row(
                group,
                TORQUE,
                RUNS[TORQUE],
                values,
                paper=published.TORQUE,
                costs=(True, True),
                note="PD torques at the joints, the root's velocity kept",
            )
        )
    caption = "A dance followed by joint torques; blue: the reference"
    return Content(
        rows=tuple(rows),
        plots=ablations.shown_curves(values, RUNS),
        pictures=ablations.shown_pictures(values, TORQUE, caption),
    )


SECTION = Section(
    key="table3",
    title="Table 3: joint torques instead of velocities",
    about=(
        "The paper drives the joints by PD torques instead of velocities, the root as before, and "
        "is more than 80 mm off on the AIST++ test set. Shown to be the paper's way where the "
        "torques cost at least 10 mm, in the world and relative to the pelvis; the sizes depend on "
        'the gains, which the paper does not state and docs/physics.md, "Baselines", does.'
    ),
    tasks=tasks,
    content=content,
)

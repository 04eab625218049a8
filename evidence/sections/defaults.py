"""What changes under the defaults: the paper's setting and ours on the same motions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from evidence.model import Content, Figure, Options, Outcome, Row, Section, Task, at_most
from evidence.runs import choices, playing
from halfphysics import metrics, scenarios
from halfphysics.metrics.surface_gaps import RISE
from halfphysics.results.result import Result
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

#: Row -> a scenario, or the height over the floor at which a walk is asked for [m].
CASES: dict[str, str | float] = {
    "a walk into a wall": "walk_into_wall",
    "sinking into a sofa": "sit_on_sofa",
    "leaning on a TV cabinet": "step_back_onto_cabinet",
    "stretching on a bed": "stretch_on_bed",
    "climbing onto a bed": "climb_onto_bed",
    "a kick": "kick_ball",
    "a walk 30 mm over the floor": 0.03,
    "a walk 30 mm in the floor": -0.03,
}
#: In a quick report.
QUICK = ("sinking into a sofa", "a walk 30 mm over the floor")
#: Settings of the two rows of a case, by the end of a task's key.
SETTINGS: dict[str, choices.Choice] = {"/paper": choices.LIMP, "/default": {}}
#: Most that our defaults may have: frames in which nothing carries the weight [%], angle of a joint
#: beyond its range and the reference [degrees].
UNSUPPORTED, RANGE = 5.0, 2.0
#: Measures of a row, their units, and what our defaults may have of it at most, if it is judged.
_FIGURES = {
    "weight carried by nothing": ("%", UNSUPPORTED),
    "floats": ("mm", None),
    "feet slide more than the reference": ("mm/frame", None),
    "beyond a joint's range": ("°", RANGE),
    "largest force": ("N", None),
    "mean force from aside": ("N", None),
    "pelvis at the end over the reference": ("mm", None),
    "pelvis at the end from the reference": ("mm", None),
}


def compare(what: str | float, choice: Mapping[str, Any]) -> Outcome:
    """Play a case and measure how its person stands and what acts on them."""
    sequence = scenarios.load(what) if isinstance(what, str) else _walk(float(what))
    result = playing.run(sequence, choice)
    path, force = metrics.path_offset(result), metrics.net_force(result)
    stance = metrics.stance_slide(result)
    found = (
        metrics.unsupported_weight(result).percent,
        _floats(result),
        stance.simulated.mean_mm - stance.asked.mean_mm,
        metrics.range_violations(result).max_deg,
        force.peak,
        _from_aside(result),
        path.end_height_mm,
        path.end_offset_mm,
    )
    return Outcome(values=dict(zip(_FIGURES, map(float, found), strict=True)))


def _floats(result: Result) -> float:
    """Mean height over what is under the person, of the frames of no jump [mm]."""
    person = result.people[0]
    report = metrics.floating(person.motion, person.body, result.scene, objects=result.objects)
    return report.mean_mm


def _walk(height: float) -> Sequence:
    """A walk over a floor, asked for at a height over it [m]."""
    actor = stage.actor(None)
    return Sequence(walk(actor, Walk(distance=2.0, lift=0.004 + height)), stage.floor(), actor)


def _from_aside(result: Result) -> float:
    """Mean over the frames that have it of the horizontal force of what does not carry [N]."""
    contacts = result.contacts
    rows = (contacts.strength > 0.0) & (contacts.normal[:, 2] < RISE)
    force = np.zeros((len(result), 2))
    np.add.at(force, contacts.frame[rows], contacts.impulse[rows, :2] * result.fps)
    size = np.linalg.norm(force, axis=1)
    return float(size[size > 0.0].mean()) if size.any() else 0.0


def tasks(options: Options) -> list[Task]:
    """Every case with both settings."""
    return [
        Task(
            key=_key(row) + end,
            function=".sections.defaults:compare",
            arguments={"what": what, "choice": choice},
            seconds=3.0,
        )
        for row, what in CASES.items()
        if row in QUICK or not options.quick
        for end, choice in SETTINGS.items()
    ]


def _key(row: str) -> str:
    return row.replace(" ", "-").lower()


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """Two rows per case: the paper's setting, our defaults."""
    rows = []
    for name, what in CASES.items():
        for end, choice in SETTINGS.items():
            found = values.get(_key(name) + end)
            if found is not None:
                data = what if isinstance(what, str) else f"Walk(distance=2.0), {what:+g} m"
                figures = tuple(_figure(measure, found[measure], end) for measure in _FIGURES)
                setting = choices.said(choice)
                rows.append(Row(name=name, data=data, setting=setting, figures=figures))
    return Content(rows=tuple(rows))


def _figure(measure: str, ours: float, end: str) -> Figure:
    unit, most = _FIGURES[measure]
    if most is None or end == "/paper":
        return Figure(name=measure, unit=unit, ours=ours)
    return at_most(most, ours, name=measure, unit=unit)


SECTION = Section(
    key="defaults",
    title="What changes under the defaults",
    about="With the paper's setting a person has no weight and no limits: they go where the motion "
    "and the obstacles put them. With the defaults they stand, sit and lie on what is under them, "
    "are no stronger than people, bend no joint beyond its range, and wait where they are blocked. "
    "Only the defaults are judged: the weight is carried, and joints are within their ranges.",
    tasks=tasks,
    content=content,
)

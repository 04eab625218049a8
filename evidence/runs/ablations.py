"""Shared by Tables 3 and 4: half-physics with one change, on the same dances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evidence import published
from evidence.model import Figure, Options, Picture, Plot, Row, Task, at_least
from evidence.motions import sources
from evidence.motions.sources import Group
from evidence.runs.choices import LIMP, Choice, said
from evidence.runs.following import curve, mean, outcomes, remarks, success, task

#: Smallest error that a change must cause to count as the finding of the paper [mm].
COST = 10.0
#: What is changed, in the rows; the other one is what it is changed in.
HALF_PHYSICS = "half-physics"
#: The frame rate at which the paper takes eight substeps [1/s]; that of AIST++ is twice as much.
RATE = 30.0
#: The clip whose pictures and curves are shown: the first dance of a quick report.
SHOWN = f"dance/{sources.QUICK_DANCES[0]:02d}"


def groups(options: Options) -> list[Group]:
    """The motions: dances and those of the user; dances also at the frame rate of the paper."""
    found = [sources.dances(options), *sources.brought(options)]
    return [
        each
        for group in found
        for each in ([group, sources.slower(group, RATE)] if group.judged else [group])
    ]


def tasks(options: Options, runs: Mapping[str, Choice], strip: str) -> list[Task]:
    """One task per motion, with all `runs`; the run `strip` has pictures of the clip shown."""
    out = []
    for group in groups(options):
        for source in group.sources:
            pictured = f"{group.key}/{source.name}" == SHOWN
            out.append(task(group, source, runs, 1.0 * len(runs), strip if pictured else ""))
    return out


def row(
    group: Group,
    name: str,
    chosen: Choice,
    values: Mapping[str, Any],
    *,
    paper: tuple[float | None, float | None] = (None, None),
    costs: tuple[bool, bool] = (False, False),
    note: str = "",
) -> Row:
    """One change on one group of motions.

    Args:
        group: The motions.
        name: Name of the change.
        chosen: The changed setting.
        values: Values of the tasks.
        paper: MPJPE-g and MPJPE of the paper [mm].
        costs: Which of the two must be at least `COST` on motions like those of the paper.
        note: A remark of the row.
    """
    found = outcomes(values, group, name)
    figures = [Figure(name="success", unit="%", ours=success(found, group))]
    measures = (("MPJPE-g", "mpjpe_global"), ("MPJPE", "mpjpe"))
    for (title, key), theirs, must in zip(measures, paper, costs, strict=True):
        ours = mean(found, key)
        if must and group.judged:
            figures.append(at_least(COST, ours, name=title, unit="mm", paper=theirs))
        else:
            figures.append(Figure(name=title, unit="mm", ours=ours, paper=theirs))
    return Row(
        name=name,
        data=group.data,
        setting=said(chosen),
        figures=tuple(figures),
        note="; ".join(part for part in (note, remarks(found, group)) if part),
    )


def unchanged(group: Group, values: Mapping[str, Any]) -> Row:
    """Half-physics without a change on the same motions."""
    return row(group, HALF_PHYSICS, LIMP, values, paper=published.HALF_PHYSICS[1:])


def shown_curves(values: Mapping[str, Any], runs: Mapping[str, Choice]) -> tuple[Plot, ...]:
    """Errors of the joints over one clip."""
    if SHOWN not in values:
        return ()
    found = values[SHOWN]["runs"]
    return (
        Plot(
            title="Mean error of the joints over one of the dances",
            x=("time", "s"),
            y=("distance in the world", "mm"),
            series=tuple(curve(found[name], name) for name in runs),
        ),
    )


def shown_pictures(values: Mapping[str, Any], name: str, caption: str) -> tuple[Picture, ...]:
    """The same clip in pictures."""
    if SHOWN not in values or not values[SHOWN]["runs"][name]["success"]:
        return ()
    return (Picture(caption=caption, task=SHOWN, name=name),)

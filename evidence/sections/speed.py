"""Speed: frames per second of one core, beside the paper's figure and a plain MuJoCo loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from evidence import published
from evidence.model import (
    Content,
    Figure,
    Options,
    Outcome,
    Row,
    Section,
    Task,
    at_least,
)

#: Cases of `halfphysics bench`, whether the speed of the paper applies (it was measured on motions
#: without obstacles), and the expected time [s].
CASES = {
    "free": (True, 60.0),
    "live": (True, 60.0),
    "wall": (False, 60.0),
    "grasp": (False, 90.0),
    "lift": (False, 90.0),
    "glass": (False, 90.0),
    "sofa": (False, 90.0),
}
#: The motions.
WHAT = {
    "free": "a walk, nothing near: motion in, motion out",
    "live": "the same walk, pose by pose",
    "wall": "a T-pose walked into a wall",
    "grasp": "two hands squeeze and lift a box of 3 kg",
    "lift": "two palms lift a suitcase of 5 kg",
    "glass": "one hand lifts, shakes and turns over a glass",
    "sofa": "sitting down on a sofa and rocking",
}
QUICK = ("free", "wall")
_REPEATS = 3


def measure(case: str, quick: bool) -> Outcome:
    """The records of one case, see `halfphysics.bench`."""
    from halfphysics import bench

    options = bench.Options(quick=quick, repeats=1 if quick else _REPEATS)
    return Outcome(values={"records": [r.to_dict() for r in bench.run(case, options)]})


def tasks(options: Options) -> list[Task]:
    """One task per case."""
    chosen: Sequence[str] = QUICK if options.quick else tuple(CASES)
    return [
        Task(
            key=case,
            function=".sections.speed:measure",
            arguments={"case": case, "quick": options.quick},
            seconds=5.0 if options.quick else CASES[case][1],
        )
        for case in chosen
    ]


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """A row per measured setting."""
    rows = []
    for case, (judged, _) in CASES.items():
        for record in values.get(case, {"records": ()})["records"]:
            rows.append(_row(case, record, judged))
    return Content(rows=tuple(rows))


def _row(case: str, record: Mapping[str, Any], judged: bool) -> Row:
    ours, paper = record["median"], published.SPEED
    name, unit = "ours", record["unit"]
    speed = (
        at_least(paper, ours, name=name, unit=unit, paper=paper)
        if judged
        else Figure(name=name, unit=unit, ours=ours, paper=paper)
    )
    others = (
        Figure(name="rigid parts", unit=unit, ours=record["parts_median"]),
        Figure(name="plain MuJoCo", unit=unit, ours=record["peer_median"]),
        Figure(name="ours over MuJoCo", ours=record["ratio"]),
    )
    return Row(
        name=f"{case}: {record['setting']}",
        data=WHAT[case],
        setting=f"{record['frames']} frames, one core",
        figures=(speed, *(f for f in others if f.ours is not None)),
    )


SECTION = Section(
    key="speed",
    title="Speed",
    about=(
        "The paper reports 953 frames/s for motions followed freely, on a Xeon E3-1280 v2 with a "
        "Quadro RTX 5000. Ours is of one core of the machine that made this report, by processor "
        "time; the baseline, a plain MuJoCo loop, was timed in turns with it in the same run."
    ),
    tasks=tasks,
    content=content,
    timing=True,
)

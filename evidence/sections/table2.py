"""Table 2: penetration in furnished scenes, of reference motions and of simulated ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from evidence import published
from evidence.model import (
    Content,
    Figure,
    Options,
    Picture,
    Plot,
    Row,
    Section,
    Series,
    Task,
    at_least,
    at_most,
)
from evidence.rooms import brought, verify
from evidence.runs import choices
from evidence.runs.visiting import CLAIMED, WAYS

#: Test scenes of a full report, and of a quick one.
SCENES, QUICK_SCENES = tuple(range(20)), (6, 9, 12)
#: Scenes with a strip; a quick report has the first one.
PICTURED = (6, 10, 8)
#: Smallest rate [%] and depths [mm] of the references: without them, zeros of ours mean little.
LEAST = {"rate": 1.0, "mean_mm": 10.0, "max_mm": 10.0}


def tasks(options: Options) -> list[Task]:
    """One task per scene of ours, and per scene or clip of the user."""
    numbers = QUICK_SCENES if options.quick else SCENES
    pictured = PICTURED[:1] if options.quick else PICTURED
    found = [
        Task(
            key=f"room-{number:02d}",
            function=".runs.visiting:made",
            arguments={
                "number": number,
                "seed": options.seed,
                "ways": list(CLAIMED if options.quick else WAYS),
                "strip": number in pictured,
                "quick": options.quick,
            },
            seconds=3.0 if options.quick else 14.0,
        )
        for number in numbers
    ]
    if "scenes" in options.data:
        found += brought.tasks(options)
    return found


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """A row for the references and for each method; for data of the user, one per file."""
    ours = {k: v for k, v in values.items() if k.startswith("room-")}
    theirs = {k: v for k, v in values.items() if k not in ours}
    rows, plots, pictures = [_quoted()], [], []
    made = len(QUICK_SCENES if options.quick else SCENES)
    rooms = _of(len(ours), made, "furnished rooms")
    listed = brought.tasks(options) if "scenes" in options.data else []
    for data, found, lost in (
        (f"{rooms}, embedded, and walks through them", ours, made - len(ours)),
        # A file of the user that cannot be read is no failure of the method.
        (_of(len(theirs), len(listed), "scenes brought"), theirs, 0),
    ):
        if found:
            rows.append(_asked(data, found, judged=found is ours))
            rows += [_played(way, data, found, lost) for way in WAYS if _all(found, way)]
            plots.append(_plot(data, found))
    rows += [_one(key, found) for key, found in theirs.items()]
    for key, found in ours.items():
        number = int(key.removeprefix("room-"))
        if number in (PICTURED[:1] if options.quick else PICTURED):
            what = ", ".join(found["room"]["items"])
            caption = f"A room with {what}: to the {found['room']['uses']}. Blue: reference."
            pictures.append(Picture(caption=caption, task=key, name="strip"))
    return Content(rows=tuple(rows), plots=tuple(plots), pictures=tuple(pictures))


_MEASURES = (
    ("rate", "penetration rate", "%"),
    ("mean_mm", "mean depth", "mm"),
    ("max_mm", "largest depth", "mm"),
)


def _of(count: int, whole: int, what: str) -> str:
    return f"{count} {what}" if count == whole else f"{count} of {whole} {what}"


def _all(found: Mapping[str, Any], way: str) -> list[dict[str, Any]]:
    return [v[way] for v in found.values() if way in v]


def _mean(some: Sequence[Mapping[str, Any]], key: str) -> float:
    return float(np.mean([v[key] for v in some]))


def _quoted() -> Row:
    return Row(
        name="generated motions, as they are",
        data="TRUMANS, 20 test scenes",
        figures=tuple(
            Figure(name=name, unit=unit, ours=None, paper=paper)
            for (_, name, unit), paper in zip(_MEASURES, published.GENERATED, strict=True)
        ),
        quoted=True,
    )


def _asked(data: str, found: Mapping[str, Any], *, judged: bool) -> Row:
    """The reference motions, which are also what kinematic playback shows."""
    some = _all(found, "asked")
    figures = []
    for (key, name, unit), paper in zip(_MEASURES, published.GENERATED, strict=True):
        ours = _mean(some, key)
        if judged:
            figures.append(at_least(LEAST[key], ours, name=name, unit=unit, paper=paper))
        else:
            figures.append(Figure(name=name, unit=unit, ours=ours))
    figures.append(Figure(name="mean of what is inside", unit="mm", ours=_mean(some, "inside_mm")))
    if judged:
        # A check that misses the intersections of the references could not find ours.
        asked = all("library" in v for v in some)
        out = 100.0 * float(np.mean([v["intersecting"] > 0 for v in some])) if asked else None
        figures.append(at_least(100.0, out, name="scenes that coal finds out", unit="%"))
    bad = sum(v.get("intersecting", 0) for v in some)
    note = _said(some, f"{bad} of {sum(v.get('checked', 0) for v in some)} frames intersect")
    if judged:
        note = (
            "made from a seed, not generated by a network: walks that cut corners and door frames, "
            f"and people who sink into what they sit and lie on; {note}"
        )
    return Row(
        name="reference",
        data=data,
        setting="baselines.Kinematic() plays the same",
        figures=tuple(figures),
        note=note,
    )


def _played(way: str, data: str, found: Mapping[str, Any], lost: int) -> Row:
    """One method; `lost`: number of scenes of ours in which it ended in an error."""
    some, (name, choice) = _all(found, way), WAYS[way]
    figures = []
    for (key, measure, unit), paper in zip(_MEASURES, published.PENETRATION, strict=True):
        if way in CLAIMED:
            figures.append(at_most(0.0, _mean(some, key), name=measure, unit=unit, paper=paper))
        else:
            figures.append(Figure(name=measure, unit=unit, ours=_mean(some, key)))
    note = "meshes as the convex bodies they are made of; of the person, rigid parts"
    if way in CLAIMED:
        judged = all("library" in v for v in some)
        bad = float(sum(v.get("intersecting", 0) for v in some)) if judged else None
        figures.append(at_most(0.0, bad, name="frames that intersect, by coal"))
        share = 100.0 * sum(v["success"] for v in some) / (len(some) + lost)
        figures.append(at_least(100.0, share, name="success", unit="%"))
        checked = sum(v.get("checked", 0) for v in some)
        note = _said(some, f"{bad or 0:g} of {checked} frames intersect")
        near = [v["distance_mm"] for v in some if v.get("distance_mm") is not None]
        note += f", nearest {min(near):.2f} mm" if near else ""
    figures.append(Figure(name="joints from the intent", unit="mm", ours=_mean(some, "global_mm")))
    figures.append(Figure(name="joints, by the pelvis", unit="mm", ours=_mean(some, "local_mm")))
    late = float(sum(v["lost_s"] for v in some))
    figures.append(Figure(name="lost time, all scenes", unit="s", ours=late))
    return Row(
        name=name, data=data, setting=choices.said(choice), figures=tuple(figures), note=note
    )


def _said(some: Sequence[Mapping[str, Any]], found: str) -> str:
    judges = sorted({v["library"] for v in some if "library" in v})
    return f"verified by {', '.join(judges)}: {found}" if judges else verify.MISSING


def _one(key: str, found: Mapping[str, Any]) -> Row:
    """One scene of the user."""
    asked, ours = found["asked"], found["ours"]
    figures = [
        Figure(name="penetration rate, reference", unit="%", ours=asked["rate"]),
        Figure(name="largest depth, reference", unit="mm", ours=asked["max_mm"]),
        at_most(0.0, ours["rate"], name="penetration rate", unit="%"),
        at_most(0.0, ours["max_mm"], name="largest depth", unit="mm"),
        Figure(name="joints from the intent", unit="mm", ours=ours["global_mm"]),
        Figure(name="lost time", unit="s", ours=ours["lost_s"]),
    ]
    return Row(
        name=key,
        data=found["scene"],
        setting=choices.said(WAYS["ours"][1]),
        figures=tuple(figures),
        note=f"{found['frames']} frames, {found['triangles']} triangles",
    )


def _plot(data: str, found: Mapping[str, Any]) -> Plot:
    labels = list(found)
    return Plot(
        title=f"How deep the skin goes at most: {data}",
        x=("scene", ""),
        y=("depth", "mm"),
        series=tuple(
            Series(name, labels, [found[k].get(way, {}).get("max_mm") for k in labels])
            for way, name in (("asked", "reference"), ("ours", "half-physics"))
        ),
        kind="bars",
    )


SECTION = Section(
    key="table2",
    title="Table 2: penetration in furnished scenes",
    about="Motions that a network generates for a scene go into its furniture; with half-physics "
    "(lambda = 1, N = 8) none of the skin does. Here people walk through furnished rooms made from "
    "a seed and sit, lie, lean and reach there as such motions do, through door frames, corners "
    "and cushions. The rate is the share of the skin's vertices inside, mean over frames; the mean "
    "depth that of each frame's deepest vertex; the largest depth the mean over scenes of the "
    "deepest. A library that is not ours looks for triangles that meet.",
    tasks=tasks,
    content=content,
)

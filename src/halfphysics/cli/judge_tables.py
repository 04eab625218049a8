"""The verdicts of `halfphysics judge` as a table of text, as CSV and as JSON."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean, median
from typing import Any

from halfphysics.cli.measures_json import plain
from halfphysics.cli.table import table
from halfphysics.judging.judge import Judged
from halfphysics.metrics.measures import MEASURES, WANTED, Measure

#: Up to this many clips have a column each.
COLUMNS = 4
# Longest name of a clip in a table [characters], and most lines of clips that failed.
_NAME, _FAILED = 28, 20
# Longest cause in a line; files have it whole.
_CAUSE = 200


def taken(people: Sequence[Judged]) -> list[Measure]:
    """The measures that at least one clip has."""
    some = [one.verdict.values for one in people if one.verdict is not None]
    return [measure for measure in MEASURES if any(measure.key in values for values in some)]


def values_of(people: Sequence[Judged], measure: Measure) -> list[tuple[str, float]]:
    """Names and values of the clips that have a value of a measure."""
    return [
        (one.name, one.verdict[measure.key])
        for one in people
        if one.verdict is not None
        and math.isfinite(one.verdict.values.get(measure.key, float("nan")))
    ]


def worst_of(found: Sequence[tuple[str, float]], measure: Measure) -> tuple[str, float]:
    """The clip with the worst value."""
    chosen = min if measure.better == "higher" else max
    return chosen(found, key=lambda pair: pair[1])


def text(people: Sequence[Judged]) -> str:
    """The table in the terminal, and below it what could not be read or measured."""
    measured = [one for one in people if one.verdict is not None]
    lines = []
    if measured:
        few = len(measured) <= COLUMNS
        lines = [table(_each(measured) if few else _summary(measured))]
    failed = [one for one in people if one.verdict is None]
    if failed:
        lines.append("")
        lines += [f"not judged: {brief(one.error)}" for one in failed[:_FAILED]]
        if len(failed) > _FAILED:
            lines.append(f"not judged: {len(failed) - _FAILED} more; --csv and --json list them")
    if measured:
        lines.append("")
        lines += _not_taken(measured)
    return "\n".join(lines).rstrip()


def _each(people: Sequence[Judged]) -> list[tuple[str, ...]]:
    names = shown_names(people)
    rows = [("", *(_short(names[one.name]) for one in people), "better")]
    for measure in taken(people):
        values = (one.verdict.values.get(measure.key) for one in people if one.verdict is not None)
        rows.append((measure.label, *map(digits, values), measure.better))
    return rows


def _summary(people: Sequence[Judged]) -> list[tuple[str, ...]]:
    names = shown_names(people)
    rows: list[tuple[str, ...]] = [
        (f"{len(people)} clips", "mean", "median", "worst", "better", "worst clip")
    ]
    for measure in taken(people):
        found = values_of(people, measure)
        if not found:
            rows.append((measure.label, "-", "-", "-", measure.better, ""))
            continue
        name, worst = worst_of(found, measure)
        numbers = [value for _, value in found]
        spread = fmean(numbers), median(numbers), worst
        rows.append((measure.label, *map(digits, spread), measure.better, _short(names[name])))
    return rows


def _not_taken(people: Sequence[Judged]) -> list[str]:
    """One line for each reason why measures are left out in all clips: that of most clips."""
    had = {measure.key for measure in taken(people)}
    left: dict[str, list[str]] = {}
    for measure in MEASURES:
        if measure.key in had:
            continue
        some = [one.verdict.missing for one in people if one.verdict is not None]
        whys = Counter(missing[measure.key] for missing in some if measure.key in missing)
        why = whys.most_common(1)[0][0] if whys else WANTED.get(measure.needs, "")
        left.setdefault(why or "too few frames", []).append(measure.name)
    return [f"not measured, {why}: {', '.join(names)}" for why, names in left.items()]


def digits(value: float | None) -> str:
    """A value with four digits; "-" where there is none."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{value:.4g}" if abs(value) < 10_000 else f"{value:.0f}"


def brief(cause: str) -> str:
    """A cause in one line of readable length."""
    line = " ".join(cause.split())
    return line if len(line) <= _CAUSE else f"{line[:_CAUSE]} ..."


def shown_names(people: Sequence[Judged]) -> dict[str, str]:
    """Name -> the same without the folders that all clips have in common."""
    folders = {str(Path(one.name).parent) for one in people}
    try:
        common = os.path.commonpath(folders) if folders else ""
    except ValueError:  # absolute and relative paths
        common = ""
    start = f"{common}{os.sep}" if common else ""
    return {one.name: one.name.removeprefix(start) for one in people}


def _short(name: str) -> str:
    return name if len(name) <= _NAME else f"...{name[3 - _NAME :]}"


def csv_text(people: Sequence[Judged]) -> str:
    """One row per clip: name, frames, fps, the measures by their keys, error."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    measures = taken(people)
    writer.writerow(["clip", "frames", "fps", *(m.key for m in measures), "error"])
    for one in people:
        verdict = one.verdict
        if verdict is None:
            writer.writerow([one.name, "", "", *("" for _ in measures), one.error])
            continue
        numbers = [verdict.values.get(m.key, float("nan")) for m in measures]
        cells = [repr(float(x)) if math.isfinite(x) else "" for x in numbers]
        writer.writerow([one.name, verdict.frames, repr(verdict.fps), *cells, ""])
    return out.getvalue()


def json_text(people: Sequence[Judged]) -> str:
    """Definitions of the measures, and of each clip its values, and why others are missing."""
    clips: list[dict[str, Any]] = []
    for one in people:
        clip: dict[str, Any] = {"clip": one.name}
        if one.verdict is None:
            clip["error"] = one.error
        else:
            clip |= plain(one.verdict)
        if one.warnings:
            clip["warnings"] = list(one.warnings)
        clips.append(clip)
    document = {"measures": [plain(measure) for measure in MEASURES], "clips": clips}
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"

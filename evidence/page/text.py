"""The report for a terminal: figures that are not reproduced first, then a table per section."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from evidence.page.wording import number, plain, published, quantity, visible
from evidence.verdicts import VERDICTS, Claim, claims, verdict

#: Columns that are numbers stand to the right.
_RIGHT = {2, 3}
_WIDEST = 34
#: Replacements of the same width, for terminals without these signs.
_PLAINER = str.maketrans("✓↗✗·–“…", "+>X.-q~")


def summary(document: Mapping[str, Any], *, encoding: str = "utf-8") -> str:
    """A report (the content of `paper.json` or `paper-speed.json`) as text.

    Args:
        document: The report.
        encoding: Encoding of the output. Letters replace marks like ✓ and ✗ that it lacks, and "?"
            any other character that it lacks.
    """
    text = _summary(document)
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return text.translate(_PLAINER).encode(encoding, "replace").decode(encoding)
    return text


def _summary(document: Mapping[str, Any]) -> str:
    counts = document["verdict"]
    said = ", ".join(f"{n} {VERDICTS[kind][1]}" for kind, n in counts.items())
    parts = [f"{plain(document['title'])}: {said}"]
    against = [
        _against(document["sections"][claim.section], claim)
        for kind in ("not_reproduced", "missing")
        for claim in claims(document["sections"])
        if claim.verdict == kind
    ]
    failed = [
        f"  {_cut(s['key'])}: {plain(f['task'])} ended in an error: {plain(f['cause'])}"
        for s in document["sections"]
        for f in s["failed"]
    ]
    if against or failed:
        parts.append("\n".join(["Not reproduced or missing:", *against, *failed]))
    parts.extend(_section(section) for section in document["sections"])
    return "\n\n".join(parts)


def _against(section: Mapping[str, Any], claim: Claim) -> str:
    figure = claim.figure
    expected = plain(figure["expected"])
    return (
        f"  {VERDICTS[claim.verdict][0]} {plain(section['key'])}, "
        f"{plain(section['rows'][claim.row]['name'])}, "
        f"{quantity(figure['name'], figure['unit'])}: "
        f"paper {published(figure['paper'])}, ours {_ours(figure)}"
        + (f"; expected {expected}" if expected else "")
    )


def _ours(figure: Mapping[str, Any]) -> str:
    return number(figure["ours"], beside=figure["paper"])


def _cut(text: object) -> str:
    words = plain(text)
    return words if len(words) <= _WIDEST else words[: _WIDEST - 1] + "…"


def _section(section: Mapping[str, Any]) -> str:
    lines = [["", "measure", "paper", "ours", "", "expected"]]
    for row in section["rows"]:
        lines.extend(_lines(row))
    title = plain(section["title"])
    if len(lines) == 1:
        return f"{title}\n  no rows"
    return f"{title}\n{_aligned(lines)}\n  {visible(section['command'])}".rstrip()


def _lines(row: Mapping[str, Any]) -> list[list[str]]:
    """The name and data of a row, wrapped to lines, and its figures beside them."""
    what = [*textwrap.wrap(plain(row["name"]), _WIDEST), *textwrap.wrap(_data(row), _WIDEST)]
    figures = [
        [
            _cut(quantity(figure["name"], figure["unit"])),
            published(figure["paper"]),
            _ours(figure),
            VERDICTS[verdict(row, figure)][0],
            plain(figure["expected"]),
        ]
        for figure in row["figures"]
    ]
    pairs = itertools.zip_longest(what, figures)
    return [[left or "", *(right or [""] * 5)] for left, right in pairs]


def _data(row: Mapping[str, Any]) -> str:
    said = plain(row["data"])
    return f"({said})" if said else ""


def _aligned(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "  "
        + "  ".join(
            cell.rjust(width) if k in _RIGHT else cell.ljust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    )

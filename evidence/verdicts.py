"""Verdicts on the claims: which figures are reproduced, confirmed in direction, missing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

#: Verdict -> (mark, word). Marks differ in shape, so that colour is not needed.
VERDICTS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "reproduced": ("✓", "reproduced"),
        "direction": ("↗", "direction confirmed"),
        "not_reproduced": ("✗", "not reproduced"),
        "shown": ("·", "shown"),
        "missing": ("–", "missing"),
        "quoted": ("“", "quoted"),
    }
)


@dataclass(frozen=True)
class Claim:
    """One figure, its place (numbers of section and row), and its verdict."""

    section: int
    row: int
    figure: Mapping[str, Any]
    verdict: str


def claims(sections: Sequence[Mapping[str, Any]]) -> Iterator[Claim]:
    """Every figure of a report's sections, in their order."""
    for s, section in enumerate(sections):
        for r, row in enumerate(section["rows"]):
            for figure in row["figures"]:
                yield Claim(s, r, figure, verdict(row, figure))


def verdict(row: Mapping[str, Any], figure: Mapping[str, Any]) -> str:
    """The verdict on a figure of a row; a figure with a condition and no number is missing."""
    if row["quoted"]:
        return "quoted"
    if figure["ours"] is None and figure["expected"]:
        return "missing"
    if figure["reproduced"] is None:
        return "shown"
    if not figure["reproduced"]:
        return "not_reproduced"
    return "direction" if figure["direction"] else "reproduced"


def tally(sections: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """Number of figures of each verdict; a task that ended in an error counts as missing."""
    count = dict.fromkeys(VERDICTS, 0)
    for claim in claims(sections):
        count[claim.verdict] += 1
    count["missing"] += sum(len(section["failed"]) for section in sections)
    return count

"""The card of a whole data set: its contents and outcome, from counts alone.

Batches count their samples, shards merge batches and the data set merges shards, exactly and in
any order, in memory that does not grow with the number of samples.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from halfphysics.errors import InputError
from halfphysics.sweep.make.card import CHECKS
from halfphysics.sweep.store.counting import COUNTED, Bins, Counts, Spread, Table

if TYPE_CHECKING:
    from halfphysics.sweep.plan.plan import Plan
    from halfphysics.sweep.plan.values import Value

#: Version of the layout of counts and of the data card.
VERSION = 1
#: A factor with more values than this is reported in bins, at most this many.
VALUES = 50
#: Numbers of a sample's card whose statistics are reported, and their unit.
SPREADS = {
    "seconds": "s",
    "clearance_min": "m",
    "joint_error_mean_mm": "mm",
    "joint_error_max_mm": "mm",
    "force_max": "N",
    "impulse": "N s",
    "held_seconds": "s",
    "slid": "m",
    "travel_max": "m",
    "unsupported_percent": "%",
    "carried_max": "weights",
    "pressure_max": "Pa",
    "pressure_mean": "Pa",
    "pressure_area": "m2",
}
#: Integers of a sample's card that are summed; samples with a nonzero value are counted too.
SUMMED = ("frames", "contacts", "holds", "lost_grasps", "slips", "drops", "started_inside")
_AXES = ("input", "body", "scene")
_CAUSE = 120


class _Factor:
    """The outcome of samples by value of a factor."""

    def __init__(self) -> None:
        self.values = Table(VALUES)
        self.bins = Bins(VALUES)

    def add(self, value: Any, counts: Counts) -> None:
        self.values.add(json.dumps(value, ensure_ascii=False), counts)
        if isinstance(value, int | float) and not isinstance(value, bool):
            self.bins.add(value, counts)

    def merge(self, other: Mapping[str, Any]) -> None:
        self.values.merge(other["values"])
        self.bins.merge(other["bins"])

    def document(self) -> dict[str, Any]:
        return {"values": self.values.document(), "bins": self.bins.document()}

    def rows(self) -> list[dict[str, Any]] | None:
        """Counts by value or by bin; None if there are too many values that are text."""
        if self.values.rows is not None:
            known = ((json.loads(text), counts) for text, counts in self.values.rows.items())
            ordered = sorted(known, key=lambda row: _order(row[0]))
            return [
                {"value": value, **dict(zip(COUNTED, counts, strict=True))}
                for value, counts in ordered
            ]
        if not self.bins.rows:
            return None
        return [
            {"from": low, "to": high, **dict(zip(COUNTED, counts, strict=True))}
            for low, high, counts in self.bins.edges()
        ]


class DataCard:
    """Counts of samples, failures and skipped variants, and the card computed from them.

    Args:
        plan: The plan of the sweep; None: the card does not contain it.
    """

    def __init__(self, plan: Plan | None = None) -> None:
        self._plan = plan
        self._numbers = dict.fromkeys(("samples", "skipped", "failed", "success"), 0)
        self._unsuccessful = dict.fromkeys(CHECKS, 0)
        self._sums = {name: [0, 0] for name in SUMMED}
        self._spreads = {name: Spread() for name in SPREADS}
        self._factors: dict[str, _Factor] = {}
        self._causes = Table(VALUES)
        self._versions = Table(VALUES)

    # -- counting ------------------------------------------------------------------------------

    def sample(self, card: Mapping[str, Any]) -> None:
        """Count a sample of the data set.

        Args:
            card: The card of the sample.
        """
        self._numbers["samples"] += 1
        self._numbers["success"] += bool(card["success"])
        for name in CHECKS:
            self._unsuccessful[name] += not card["checks"][name]
        for name, sums in self._sums.items():
            sums[0] += card[name]
            sums[1] += bool(card[name])
        for name, spread in self._spreads.items():
            # A card of an older version of the program has fewer entries.
            if card.get(name) is not None:
                spread.add(card[name])
        counts = [1, bool(card["success"]), bool(card["slips"]), bool(card["drops"]), False]
        self._tally(card, [int(count) for count in counts])
        self._versions.add(json.dumps(card["versions"], sort_keys=True), [1])

    def failure(self, failure: Mapping[str, Any]) -> None:
        """Count a variant that could not be simulated: its "input", "factors" and "cause"."""
        self._numbers["failed"] += 1
        self._causes.add(_kind(str(failure["cause"])), [1])
        self._tally(failure, [0, 0, 0, 0, 1])

    def skip(self, number: int) -> None:
        """Count variants that a filter of the plan left out."""
        self._numbers["skipped"] += number

    def _tally(self, row: Mapping[str, Any], counts: Counts) -> None:
        axes = {name: row[name] for name in _AXES if name in row}
        for name, value in {**axes, **row["factors"]}.items():
            self._factors.setdefault(name, _Factor()).add(value, counts)

    def sums(self) -> dict[str, Any]:
        """All counts as JSON values, the argument of `add`."""
        return {
            "version": VERSION,
            "numbers": dict(self._numbers),
            "unsuccessful": dict(self._unsuccessful),
            "sums": {name: list(sums) for name, sums in self._sums.items()},
            "spreads": {name: spread.document() for name, spread in self._spreads.items()},
            "factors": {name: its.document() for name, its in sorted(self._factors.items())},
            "causes": self._causes.document(),
            "versions": self._versions.document(),
        }

    def add(self, record: Mapping[str, Any]) -> None:
        """Add the counts of a batch or a shard.

        Args:
            record: The `sums` of another card, or a record with these under the key "sums".

        Raises:
            InputError: The counts have another layout.
        """
        other = record.get("sums") if "numbers" not in record else record
        if not isinstance(other, Mapping) or other.get("version") != VERSION:
            found = other.get("version") if isinstance(other, Mapping) else None
            raise InputError(
                f"data card: found counts of version {found}, expected {VERSION}. Have it made "
                "again (halfphysics sweep PLAN --remake), or use the version that made it"
            )
        for name, number in other["numbers"].items():
            self._numbers[name] += number
        for name, number in other["unsuccessful"].items():
            self._unsuccessful[name] += number
        for name, sums in other["sums"].items():
            self._sums[name][0] += sums[0]
            self._sums[name][1] += sums[1]
        for name, spread in other["spreads"].items():
            self._spreads[name].merge(spread)
        for name, factor in other["factors"].items():
            self._factors.setdefault(name, _Factor()).merge(factor)
        self._causes.merge(other["causes"])
        self._versions.merge(other["versions"])

    # -- the card ------------------------------------------------------------------------------

    def document(self) -> dict[str, Any]:
        """The card as JSON values; docs/sweeps.md describes each value."""
        versions, causes = self._versions.document(), self._causes.document()
        return {
            "data_card": VERSION,
            "plan": None if self._plan is None else self._plan.document(),
            "plan_identity": None if self._plan is None else self._plan.identity,
            "seed": None if self._plan is None else self._plan.seed,
            # More than one if the program changed and older shards were kept.
            "versions": None if versions is None else [json.loads(text) for text in versions],
            **self._numbers,
            "unsuccessful": dict(self._unsuccessful),
            "totals": {name: sums[0] for name, sums in self._sums.items()},
            "samples_with": {name: sums[1] for name, sums in self._sums.items()},
            "spreads": {
                name: {"unit": unit, **self._spreads[name].summary()}
                for name, unit in SPREADS.items()
            },
            "histograms": {
                name: [[low, high, counts[0]] for low, high, counts in spread.bins.edges()]
                for name, spread in self._spreads.items()
            },
            "failures": None if causes is None else {k: v[0] for k, v in causes.items()},
            "factors": {name: its.rows() for name, its in sorted(self._factors.items())},
        }

    def markdown(self) -> str:
        """The card as a Markdown page."""
        from halfphysics.sweep.store.card_page import page

        return page(self.document())


def counted(
    cards: Iterable[Mapping[str, Any]],
    failures: Iterable[Mapping[str, Any]] = (),
    skipped: int = 0,
) -> dict[str, Any]:
    """The entry "sums" of a batch's record.

    Args:
        cards: The cards of the batch's samples in the data set.
        failures: "input", "factors" and "cause" of each variant that could not be simulated.
        skipped: Number of variants that a filter left out.
    """
    card = DataCard()
    for one in cards:
        card.sample(one)
    for one in failures:
        card.failure(one)
    card.skip(skipped)
    return card.sums()


def _order(value: Value) -> tuple[int, Any]:
    """A key that sorts values of all types: null, false and true, numbers, texts."""
    if value is None:
        return 0, 0
    if isinstance(value, bool):
        return 1, value
    return (3, value) if isinstance(value, str) else (2, value)


def _kind(cause: str) -> str:
    """A cause without the parts that differ between variants: names and numbers."""
    line = cause.strip().partition("\n")[0]
    line = re.sub(r"'[^']*'|\"[^\"]*\"", "'...'", line)
    line = re.sub(r"\S*/\S+", "...", line)
    line = re.sub(r"\d+(\.\d+)?(e[+-]?\d+)?", "#", line)
    return line if len(line) <= _CAUSE else f"{line[: _CAUSE - 3]}..."

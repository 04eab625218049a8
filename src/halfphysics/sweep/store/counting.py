"""Counting without end in bounded memory, with the same outcome in whatever order.

Everything here is whole numbers, or smallest and largest ones: what batches counted is merged
exactly, in any order.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

#: The finest bins are 2 to this wide: 60 nanometres of a length.
FINEST = -24
#: Sums are kept in such parts of a unit, as whole numbers.
NANO = 1_000_000_000

Counts = list[int]
#: What is counted of each value of a factor, in this order.
COUNTED = ("samples", "success", "slipped", "dropped", "failed")


def add_to(counts: Counts, more: Counts) -> None:
    """Add numbers to others, place by place."""
    for place, number in enumerate(more):
        counts[place] += number


class Table:
    """Counts by value, of at most so many values: with one more none are known any more.

    So what a table ends as depends on which values there were only, not on their order.

    Args:
        most: Values.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self.rows: dict[str, Counts] | None = {}

    def add(self, value: str, counts: Counts) -> None:
        """Count a value."""
        if self.rows is None:
            return
        if value in self.rows:
            add_to(self.rows[value], counts)
        else:
            self.rows[value] = list(counts)
            if len(self.rows) > self.most:
                self.rows = None

    def merge(self, other: Mapping[str, Counts] | None) -> None:
        """Add what another one's `document` says."""
        if other is None:
            self.rows = None
        else:
            for value, counts in other.items():
                self.add(value, counts)

    def document(self) -> dict[str, Counts] | None:
        """Value -> counts, sorted; None: there are too many values."""
        return None if self.rows is None else dict(sorted(self.rows.items()))


class Bins:
    """Counts by bins of numbers, of one width, a power of two, from its whole multiples on.

    There are at most so many that are not empty. Their width is the smallest with which that is
    so, from 2 to the power `FINEST` on, and so does not depend on the order of the numbers.

    Args:
        most: Bins that are not empty.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self.width = FINEST  # 2 to this
        self.rows: dict[int, Counts] = {}

    def add(self, number: float, counts: Counts) -> None:
        """Count a number that is finite."""
        above, below = number.as_integer_ratio()  # exact, and so is what follows
        shift = -self.width
        place = (above << shift) // below if shift >= 0 else above // (below << -shift)
        self._put(place, counts)
        self._narrow()

    def merge(self, other: Mapping[str, Any]) -> None:
        """Add what another one's `document` says."""
        width = other["width"]
        while self.width < width:
            self._coarsen()
        for place, counts in other["rows"]:
            self._put(place >> (self.width - width), counts)
        self._narrow()

    def _put(self, place: int, counts: Counts) -> None:
        if place in self.rows:
            add_to(self.rows[place], counts)
        else:
            self.rows[place] = list(counts)

    def _narrow(self) -> None:
        while len(self.rows) > self.most:
            self._coarsen()

    def _coarsen(self) -> None:
        rows, self.rows = self.rows, {}
        self.width += 1
        for place, counts in rows.items():
            self._put(place >> 1, counts)

    def document(self) -> dict[str, Any]:
        """The width's exponent, and rows of place and counts, sorted."""
        return {"width": self.width, "rows": [[k, v] for k, v in sorted(self.rows.items())]}

    def edges(self) -> list[tuple[float, float, Counts]]:
        """From where to where each bin goes, and its counts, in order."""
        return [(self.edge(k), self.edge(k + 1), v) for k, v in sorted(self.rows.items())]

    def edge(self, place: int) -> float:
        """Where a bin begins."""
        most = sys.float_info.max
        exact = place * Fraction(2) ** self.width
        return float(min(max(exact, Fraction(-most)), Fraction(most)))


class Spread:
    """How numbers are spread: how many, their sum, the least and the most, and bins.

    Sums are of whole billionths.
    """

    #: Percentiles are known to the width of a bin.
    BINS = 100

    def __init__(self) -> None:
        self.number = 0
        self.nano = 0
        self.least: float | None = None
        self.most: float | None = None
        self.bins = Bins(self.BINS)

    def add(self, value: float) -> None:
        """Count a number that is finite."""
        value = float(value)
        above, below = value.as_integer_ratio()  # too large a product is no infinity
        self._extend(1, (2 * above * NANO + below) // (2 * below), value, value)
        self.bins.add(value, [1])

    def merge(self, other: Mapping[str, Any]) -> None:
        """Add what another one's `document` says."""
        if other["number"]:
            self._extend(other["number"], other["nano"], other["least"], other["most"])
            self.bins.merge(other["bins"])

    def _extend(self, number: int, nano: int, least: float, most: float) -> None:
        self.number += number
        self.nano += nano
        # min would take the first of 0.0 and -0.0; with + 0.0 they are one.
        self.least = least + 0.0 if self.least is None else min(self.least, least + 0.0)
        self.most = most + 0.0 if self.most is None else max(self.most, most + 0.0)

    def document(self) -> dict[str, Any]:
        """All that it takes to merge it."""
        return {
            "number": self.number,
            "nano": self.nano,
            "least": self.least,
            "most": self.most,
            "bins": self.bins.document(),
        }

    def summary(self) -> dict[str, Any]:
        """Number, least, most, mean and percentiles, None where there are no numbers."""
        mean = self.nano / (NANO * self.number) if self.number else None
        percentiles = {f"p{percent}": self.percentile(percent) for percent in (1, 5, 50, 95, 99)}
        return {
            "number": self.number,
            "least": self.least,
            "most": self.most,
            "mean": mean,
            **percentiles,
        }

    def percentile(self, percent: int) -> float | None:
        """A number that so many percent are at or below, to the width of a bin; None: no numbers.

        The lower edge of the bin in which the share is reached, but not below the least number.
        """
        if self.least is None:
            return None
        # Whole numbers: no rounding decides.
        wanted = -(-self.number * percent // 100)
        for place, (count,) in sorted(self.bins.rows.items()):
            wanted -= count
            if wanted <= 0:
                return max(self.bins.edge(place), self.least)
        return self.most

"""Counting any number of samples in bounded memory, with a result that does not depend on order.

All values are integers, minima or maxima, so counts of batches are merged exactly, in any order.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

#: Exponent of the width of the finest bins, a power of 2: 60 nanometres for lengths.
FINEST = -24
#: Sums are integers in units of 1 / NANO.
NANO = 1_000_000_000

Counts = list[int]
#: The counts of each value of a factor, in this order.
COUNTED = ("samples", "success", "slipped", "dropped", "failed")


def add_to(counts: Counts, more: Counts) -> None:
    """Add counts to `counts`, element by element."""
    for place, number in enumerate(more):
        counts[place] += number


class Table:
    """Counts by value, of at most `most` values: one value more discards all counts.

    So the final table depends on the set of values only, not on their order.

    Args:
        most: Largest number of values.
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
        """Add the `document` of another object of this class."""
        if other is None:
            self.rows = None
        else:
            for value, counts in other.items():
                self.add(value, counts)

    def document(self) -> dict[str, Counts] | None:
        """Value -> counts, sorted; None if there are too many values."""
        return None if self.rows is None else dict(sorted(self.rows.items()))


class Bins:
    """Counts by bins of numbers; all bins have one width, a power of two, and start at multiples.

    At most `most` bins are not empty. The width is the smallest that achieves this, at least
    2 to the power `FINEST`, and so does not depend on the order of the numbers.

    Args:
        most: Largest number of bins that are not empty.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self.width = FINEST  # exponent of 2
        self.rows: dict[int, Counts] = {}

    def add(self, number: float, counts: Counts) -> None:
        """Count a finite number."""
        above, below = number.as_integer_ratio()  # exact, as is the integer arithmetic below
        shift = -self.width
        place = (above << shift) // below if shift >= 0 else above // (below << -shift)
        self._put(place, counts)
        self._narrow()

    def merge(self, other: Mapping[str, Any]) -> None:
        """Add the `document` of another object of this class."""
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
        """Lower edge, upper edge and counts of each bin, in order."""
        return [(self.edge(k), self.edge(k + 1), v) for k, v in sorted(self.rows.items())]

    def edge(self, place: int) -> float:
        """The lower edge of a bin."""
        most = sys.float_info.max
        exact = place * Fraction(2) ** self.width
        return float(min(max(exact, Fraction(-most)), Fraction(most)))


class Spread:
    """Statistics of numbers: count, sum, minimum, maximum and bins.

    The sum is an integer number of billionths.
    """

    #: Number of bins; percentiles are accurate to the width of a bin.
    BINS = 100

    def __init__(self) -> None:
        self.number = 0
        self.nano = 0
        self.least: float | None = None
        self.most: float | None = None
        self.bins = Bins(self.BINS)

    def add(self, value: float) -> None:
        """Count a finite number."""
        value = float(value)
        above, below = value.as_integer_ratio()  # integers: a large product does not overflow
        self._extend(1, (2 * above * NANO + below) // (2 * below), value, value)
        self.bins.add(value, [1])

    def merge(self, other: Mapping[str, Any]) -> None:
        """Add the `document` of another object of this class."""
        if other["number"]:
            self._extend(other["number"], other["nano"], other["least"], other["most"])
            self.bins.merge(other["bins"])

    def _extend(self, number: int, nano: int, least: float, most: float) -> None:
        self.number += number
        self.nano += nano
        # min returns the first of 0.0 and -0.0; adding 0.0 turns -0.0 into 0.0.
        self.least = least + 0.0 if self.least is None else min(self.least, least + 0.0)
        self.most = most + 0.0 if self.most is None else max(self.most, most + 0.0)

    def document(self) -> dict[str, Any]:
        """The values that `merge` needs."""
        return {
            "number": self.number,
            "nano": self.nano,
            "least": self.least,
            "most": self.most,
            "bins": self.bins.document(),
        }

    def summary(self) -> dict[str, Any]:
        """Count, minimum, maximum, mean and percentiles; None for each of these without numbers."""
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
        """A percentile, accurate to the width of a bin; None if there are no numbers.

        It is the lower edge of the bin in which the percentile lies, at least the minimum.
        """
        if self.least is None:
            return None
        # Integers: the result does not depend on rounding.
        wanted = -(-self.number * percent // 100)
        for place, (count,) in sorted(self.bins.rows.items()):
            wanted -= count
            if wanted <= 0:
                return max(self.bins.edge(place), self.least)
        return self.most

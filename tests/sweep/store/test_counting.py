"""Counting: the same result in any order, in bounded memory, exact."""

from __future__ import annotations

import itertools
import json
import math
import sys
from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.sweep.store.counting import FINEST, Bins, Spread, Table

NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(10**9), 10**9)
LISTS = st.lists(NUMBERS, max_size=60)


def bytes_of(counter) -> str:
    return json.dumps(counter.document(), allow_nan=False)


def filled(kind, numbers, parts=1):
    """A counter of numbers, counted in parts that are merged by way of their text."""
    whole = kind()
    for part in range(parts):
        own = kind()
        for number in numbers[part::parts]:
            if isinstance(own, Spread):
                own.add(number)
            else:
                own.add(str(number) if isinstance(own, Table) else number, [1])
        whole.merge(json.loads(bytes_of(own)))
    return whole


@settings(max_examples=200, deadline=None)
@given(numbers=LISTS, parts=st.integers(1, 5), data=st.data())
def test_the_order_and_the_cut_do_not_matter(numbers, parts, data):
    shuffled = data.draw(st.permutations(numbers))
    for kind in (lambda: Bins(7), lambda: Table(7), Spread):
        assert bytes_of(filled(kind, numbers)) == bytes_of(filled(kind, shuffled, parts))


@settings(max_examples=200, deadline=None)
@given(numbers=LISTS)
def test_every_number_is_in_its_bin_and_bins_are_few(numbers):
    bins = Bins(7)
    for number in numbers:
        bins.add(number, [1, 2])
    assert len(bins.rows) <= 7
    assert sum(counts[0] for counts in bins.rows.values()) == len(numbers)
    assert sum(counts[1] for counts in bins.rows.values()) == 2 * len(numbers)
    for place, counts in bins.rows.items():
        low, high = (k * Fraction(2) ** bins.width for k in (place, place + 1))
        assert counts[0] == sum(low <= number < high for number in numbers)
    assert all(low <= high for low, high, _ in bins.edges())


def test_bins_are_as_narrow_as_can_be():
    bins = Bins(4)
    for number in (0.0, 1.0, 2.0, 3.0):
        bins.add(number, [1])
    assert bins.width == FINEST
    bins.add(4.0, [1])
    assert bins.width == 1  # five numbers one apart take bins of two
    assert bins.edges() == [(0.0, 2.0, [2]), (2.0, 4.0, [2]), (4.0, 6.0, [1])]


def test_a_table_forgets_its_values_once_there_are_too_many():
    for order in itertools.permutations("abc"):
        table = Table(2)
        for value in order:
            table.add(value, [1])
        assert table.document() is None
        table.add("a", [1])
        assert table.document() is None
    table = Table(2)
    for value in "aba":
        table.add(value, [1, 0])
    assert table.document() == {"a": [2, 0], "b": [1, 0]}


def test_a_spread_is_what_the_numbers_are():
    spread = Spread()
    for k in range(1000):
        spread.add((7 * k % 1000) / 1000.0)
    found = spread.summary()
    assert (found["number"], found["least"], found["most"]) == (1000, 0.0, 0.999)
    assert found["mean"] == 0.4995
    width = math.ldexp(1.0, spread.bins.width)
    assert width == 1.0 / 64.0  # 64 of at most 100
    for percent in (1, 5, 50, 95, 99):
        assert 0.0 <= percent / 100.0 - found[f"p{percent}"] <= width + 1e-3


def test_where_most_are_zero_so_is_the_median():
    spread = Spread()
    for number in (0.0, 0.0, 0.0, 7.25):
        spread.add(number)
    assert spread.summary()["p50"] == 0.0
    assert spread.summary()["p99"] == 7.25


def test_nothing_has_no_percentiles():
    assert Spread().summary()["p50"] is None
    assert Spread().summary()["mean"] is None


def test_a_million_numbers_take_no_more_memory_than_a_thousand():
    def size(count):
        bins = Bins(50)
        for k in range(count):
            bins.add((k * 0.6180339887498949) % 1.0, [1])
        return len(bins.rows), sys.getsizeof(bins.rows)

    assert size(100_000) == size(1000)

"""Names in the order in which people count."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from halfphysics.base.natural_order import natural


def test_numbers_count_as_numbers():
    names = ["frame10.jpg", "frame2.jpg", "frame1.jpg", "a", "", "frame2b.jpg", "7", "10"]
    found = sorted(names, key=natural)
    assert found == ["", "7", "10", "a", "frame1.jpg", "frame2.jpg", "frame2b.jpg", "frame10.jpg"]


@given(st.lists(st.text(), max_size=6))
def test_any_names_have_an_order(names):
    assert sorted(sorted(names, key=natural), key=natural) == sorted(names, key=natural)

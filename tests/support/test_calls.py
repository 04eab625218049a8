"""The calls of a piece of work are counted."""

from __future__ import annotations

from support.calls import calls


def test_a_loop_is_seen_by_its_calls():
    few, many = (calls(lambda n=n: [abs(k) for k in range(n)]) for n in (10, 1000))
    assert many - few == 990

"""A live session in another process: a sample of `campaigns.live`."""

from __future__ import annotations

import pytest

from campaigns.live import Run, run
from support.live.driver import Driven


@pytest.mark.slow
@pytest.mark.parametrize(("what", "count"), [("latency", 0), ("watchers", 8), ("faults", 100)])
def test_seconds_of_it(what, count):
    """All but speed, which is the machine's: poses come back, nothing grows, errors are said."""
    found = run(what, 1.5, count, starts=0.5)
    assert found.complaints(speed=False) == []
    assert len(found.driven.seconds) > 0.2 * found.driven.sent > 20
    assert found.driven.contacts > 0


def test_limits_are_found_to_be_crossed():
    slow = Driven(sent=10, seconds=[0.001] * 9 + [0.5])
    found = Run(slow, (2.0, 5.0, 20.0), grown=100.0, files=9, notes=[], unanswered=3)
    assert [text.split()[0] for text in found.complaints()] == ["memory", "9", "3", "p99", "worst"]
    assert len(found.complaints(speed=False)) == 3

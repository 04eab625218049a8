"""What was recorded, at the time of the clock."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from halfphysics.metrics.asked import asked_motion
from support.people import along_x

REFERENCE = along_x(1.5, 31, start=0.0)


def person(clock):
    return SimpleNamespace(recorded=REFERENCE, clock=clock)


def test_who_never_waited_gets_the_record_itself():
    assert asked_motion(person(None)) is REFERENCE
    assert asked_motion(person(np.arange(31) / 30.0)) is REFERENCE
    assert asked_motion(SimpleNamespace(recorded=REFERENCE)) is REFERENCE


def test_who_waits_gets_what_the_clock_shows():
    clock = np.minimum(np.arange(31) / 30.0, 0.35)
    asked = asked_motion(person(clock))
    assert len(asked) == 31
    assert asked.fps == REFERENCE.fps
    assert np.allclose(asked.translation[:, 0], 1.5 * clock, atol=1e-12)
    assert (asked.translation[:11] == REFERENCE.translation[:11]).all()


def test_a_clock_past_the_end_stays_there():
    asked = asked_motion(person(np.arange(31) / 30.0 + 0.5))
    assert (asked.translation[-1] == REFERENCE.translation[-1]).all()

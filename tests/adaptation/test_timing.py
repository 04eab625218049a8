"""When a hand comes, presses and goes: shares over time."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.adaptation import timing
from halfphysics.adaptation.timing import Timing

#: The polynomial's ends.
ROUNDING = 1e-12
FPS, FRAMES, FIRST, LAST = 60.0, 400, 150, 250


def hold(first=FIRST, last=LAST, kept=False, rests=None):
    rests = last if rests is None else rests
    return SimpleNamespace(first=first, last=last, kept=kept, rests=rests)


def test_a_hand_presses_in_full_while_the_thing_moves():
    t = Timing.of(hold(), FIRST - 30, FRAMES, FPS)
    for share in (t.share, t.fixed, t.closed, t.presses):
        assert np.all((share >= -ROUNDING) & (share <= 1.0 + ROUNDING))
        assert np.abs(share[FIRST : LAST + 1] - 1.0).max() < ROUNDING


def test_far_from_the_hold_nothing_is_adapted():
    arrives = FIRST - 60  # a second before it moves
    t = Timing.of(hold(), arrives, FRAMES, FPS)
    before = arrives - int(timing.COMES * FPS)
    after = LAST + int((timing.LETS_GO + timing.OPENS + timing.GOES) * FPS) + 1
    for share in (t.share, t.fixed, t.presses):
        assert not share[:before].any()
        assert not share[after:].any()


def test_it_lets_go_at_once():
    """Within 0.1 s of the end no force is asked for: released as recorded."""
    t = Timing.of(hold(), FIRST - 30, FRAMES, FPS)
    assert t.presses[LAST + int(0.1 * FPS) + 1] == 0.0
    assert t.fixed[LAST + int(0.05 * FPS)] == pytest.approx(1.0)


def test_what_rests_is_let_go_of_by_the_end():
    """What a thing was put down on takes over until the recorded hand leaves it."""
    t = Timing.of(hold(rests=LAST - 30), FIRST - 30, FRAMES, FPS)
    assert t.presses[LAST] == pytest.approx(0.0)
    assert t.presses[LAST - 30] == pytest.approx(1.0)
    assert t.presses[LAST - 15] == pytest.approx(0.5)


def test_what_is_held_at_the_end_is_not_let_go():
    t = Timing.of(hold(last=FRAMES - 1, kept=True), FIRST, FRAMES, FPS)
    assert np.abs(t.presses[FIRST:] - 1.0).max() < ROUNDING


def test_what_is_held_from_the_start_is_held_in_the_first_frame():
    t = Timing.of(hold(first=3), 0, FRAMES, FPS)
    assert t.share[0] == t.closed[0] == 1.0

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


def hold(first=FIRST, last=LAST, kept=False, rests=LAST - 24):
    return SimpleNamespace(first=first, last=last, kept=kept, rests=rests)


def test_a_hand_presses_in_full_while_the_thing_moves():
    t = Timing.of(hold(), FIRST - 30, FRAMES, FPS)
    for share in (t.share, t.fixed, t.closed, t.presses):
        assert np.all((share >= -ROUNDING) & (share <= 1.0 + ROUNDING))
        assert np.abs(share[FIRST : LAST - 24] - 1.0).max() < ROUNDING


def test_far_from_the_hold_nothing_is_adapted():
    arrives = FIRST - 60  # a second before it moves
    t = Timing.of(hold(), arrives, FRAMES, FPS)
    before = arrives - int(timing.COMES * FPS)
    after = LAST + int((timing.LEAVES + timing.GOES) * FPS) + 2
    for share in (t.share, t.fixed, t.presses):
        assert not share[:before].any()
        assert not share[after:].any()


def test_it_lets_go_as_recorded():
    """The force falls while the thing rests and is gone at the end, when the hand is opening."""
    t = Timing.of(hold(), FIRST - 30, FRAMES, FPS)
    assert t.presses[LAST - int(timing.FALLS * FPS)] == pytest.approx(1.0)
    assert t.presses[LAST] == pytest.approx(0.0, abs=ROUNDING)
    assert t.closed[LAST - int(timing.OPENS * FPS)] == pytest.approx(1.0)
    assert 0.5 < t.closed[LAST] < 0.9
    assert t.closed[LAST + int(timing.OPENING * FPS)] == pytest.approx(0.0, abs=ROUNDING)


def test_what_is_thrown_is_held_until_shortly_before():
    t = Timing.of(hold(rests=LAST), FIRST - 30, FRAMES, FPS)
    half = int(0.5 * timing.THROWS * FPS)
    assert t.presses[LAST - half] == pytest.approx(1.0)
    assert t.presses[LAST] == pytest.approx(0.5)
    assert t.presses[LAST + half] == pytest.approx(0.0, abs=ROUNDING)


def test_fingers_that_nobody_recorded_let_go_where_the_thing_rests():
    """A flat hand stays at a glass that it has put down: it held it half a second, not two."""
    rests = LAST - 120
    seen, unseen = (
        Timing.of(hold(rests=rests), FIRST, FRAMES, FPS, grasps=True, unseen=unseen)
        for unseen in (False, True)
    )
    gone = rests + int(timing.UNSEEN * FPS)
    assert seen.presses[gone] == pytest.approx(1.0)
    assert unseen.presses[gone] == pytest.approx(0.0, abs=ROUNDING)


def test_a_flat_hand_lets_go_before_it_leaves():
    """It leaves with open fingers; not before the thing rests."""
    for rests in (LAST - int(0.4 * FPS), LAST - int(0.15 * FPS)):
        t = Timing.of(hold(rests=rests), FIRST, FRAMES, FPS, grasps=True, unseen=True)
        gone = max(rests, LAST - int(timing.OPEN_BEFORE * FPS))
        assert t.presses[gone - int(timing.FALLS * FPS)] == pytest.approx(1.0)
        assert t.presses[gone] < 0.6
        assert t.presses[gone + int(timing.THROWS * FPS)] == pytest.approx(0.0, abs=ROUNDING)


def test_a_clip_that_starts_shortly_before_starts_as_recorded():
    for first in range(int(timing.TOUCHES * FPS) + 1, FIRST):
        t = Timing.of(hold(first=first), 1, FRAMES, FPS)
        assert t.share[0] == t.closed[0] == t.presses[0] == 0.0
        assert t.share[first - int(0.2 * FPS)] == pytest.approx(1.0)


def test_what_is_held_at_the_end_is_not_let_go():
    t = Timing.of(hold(last=FRAMES - 1, kept=True), FIRST, FRAMES, FPS)
    assert np.abs(t.presses[FIRST:] - 1.0).max() < ROUNDING


def test_what_is_held_from_the_start_is_held_in_the_first_frame():
    t = Timing.of(hold(first=3), 0, FRAMES, FPS)
    assert t.share[0] == t.closed[0] == 1.0


def test_a_hand_that_is_there_as_the_clip_starts_is_beside_the_thing_and_not_in_it():
    early = int((timing.FROM_START + timing.TOUCHES) * FPS) - 1
    t = Timing.of(hold(first=early), 0, FRAMES, FPS)
    assert (t.share[:early] == 1.0).all()
    assert t.closed[0] == t.fixed[0] == t.presses[0] == 0.0
    late = Timing.of(hold(first=early + 60), 0, FRAMES, FPS)
    assert late.share[0] == 0.0

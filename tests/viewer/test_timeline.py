"""The viewer's clock: no drift, one time for all, and its buttons."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfphysics.errors import InputError
from halfphysics.viewer.timeline import SPEEDS, Timeline


class Clock:
    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


def timeline(*recordings, **options):
    clock = Clock()
    return Timeline(*(recordings or [(91, 30.0)]), now=clock, **options), clock


def test_time_stands_until_played():
    line, clock = timeline()
    clock.now += 5.0
    assert (line.time, line.frame(), line.playing) == (0.0, 0, False)
    assert line.until_next() == math.inf
    line.play()
    clock.now += 1.0
    assert line.time == pytest.approx(1.0)
    assert line.frame() == 30
    line.pause()
    clock.now += 9.0
    assert line.time == pytest.approx(1.0)


def test_playing_does_not_drift():
    line, clock = timeline((1_000_001, 30.0), loop=False)
    line.play()
    for _ in range(20_000):  # read at odd moments, whose errors must not accumulate
        clock.now += 1.0 / 29.97
        line.frames(), line.until_next()
    assert line.time == pytest.approx(20_000 / 29.97, abs=1e-6)


def test_results_of_other_rates_and_lengths_share_seconds():
    line, clock = timeline((31, 30.0), (241, 120.0), (2, 1.0))
    assert line.duration == 2.0
    assert line.fps == 120.0
    line.play()
    clock.now += 0.5
    assert line.frames() == (15, 60, 0)
    clock.now += 1.0  # the first has ended and waits
    assert line.frames() == (30, 180, 1)


@pytest.mark.parametrize("speed", [0.1, 0.5, 1.0, 4.0])
def test_speed(speed):
    line, clock = timeline(speed=speed)
    line.play()
    clock.now += 0.6
    assert line.time == pytest.approx(0.6 * speed)
    line.speed = 1.0  # no jump
    assert line.time == pytest.approx(0.6 * speed)
    clock.now += 0.3
    assert line.time == pytest.approx(0.6 * speed + 0.3)


def test_a_loop_shows_its_last_frame_as_long_as_others():
    line, clock = timeline((4, 10.0))
    line.play()
    seen = []
    clock.now -= 0.005
    for _ in range(80):
        clock.now += 0.01
        seen.append(line.frame())
    for frame in range(4):
        assert seen.count(frame) == 20
    assert line.playing


def test_without_a_loop_it_stops_at_the_end_and_play_starts_again():
    line, clock = timeline((4, 10.0), loop=False)
    line.play()
    clock.now += 7.0
    assert (line.time, line.frame(), line.playing) == (pytest.approx(0.3), 3, False)
    line.play()
    assert (line.time, line.playing) == (0.0, True)
    clock.now += 0.1
    line.loop = True
    clock.now += 0.1
    assert line.time == pytest.approx(0.2)


def test_seeking_stays_within():
    line, clock = timeline()
    line.play()
    for wanted, got in ((1.5, 1.5), (-3.0, 0.0), (99.0, 3.0)):
        line.seek(wanted)
        assert line.time == pytest.approx(got)
    assert line.playing
    line.seek(1.0)
    clock.now += 0.5
    assert line.time == pytest.approx(1.5)


def test_steps_go_frame_by_frame_and_pause():
    line, clock = timeline((4, 24.0))
    line.play()
    clock.now += 1.4 / 24.0
    line.step()
    assert (line.frame(), line.playing) == (2, False)
    assert line.time == pytest.approx(2 / 24.0)
    assert [(line.step(1), line.frame())[1] for _ in range(3)] == [3, 0, 1]
    assert [(line.step(-1), line.frame())[1] for _ in range(3)] == [0, 3, 2]
    line.loop = False
    line.step(10)
    assert line.frame() == 3
    line.step(-10)
    assert line.frame() == 0


def test_toggle():
    line, _ = timeline()
    line.toggle()
    assert line.playing
    line.toggle()
    assert not line.playing


@given(
    fps=st.sampled_from([24.0, 25.0, 29.97, 30.0, 60.0, 120.0, 240.0]),
    frames=st.integers(1, 2000),
    at=st.integers(0, 1999),
)
def test_the_time_of_a_frame_is_that_frame(fps, frames, at):
    line, _ = timeline((frames, fps))
    line.seek(at / fps)
    assert line.frame() == min(at, frames - 1)


@given(
    start=st.floats(0.0, 3.0),
    speed=st.floats(*SPEEDS),
    loop=st.booleans(),
)
def test_until_next_is_when_a_frame_changes(start, speed, loop):
    line, clock = timeline((91, 30.0), (40, 25.0), speed=speed, loop=loop)
    line.seek(start)
    line.play()
    before, wait = line.frames(), line.until_next()
    if wait > 1e-3:
        clock.now += wait - 1e-4
        assert line.frames() == before
        clock.now += 2e-4
    else:
        clock.now += wait + 1e-4
    assert line.frames() != before or not line.playing or start >= line.duration - 1e-4


def test_a_single_frame_can_be_played():
    line, clock = timeline((1, 30.0))
    line.play()
    for _ in range(5):
        clock.now += 0.02
        assert line.frames() == (0,)
        assert line.until_next() >= 0.0
    line.step()
    assert line.frame() == 0


@pytest.mark.parametrize(
    ("recordings", "options", "said"),
    [
        ([], {}, "no recordings"),
        ([(0, 30.0)], {}, "found 0 frames"),
        ([(5, 0.0)], {}, "rate above 0"),
        ([(5, math.nan)], {}, "rate above 0"),
        ([(5, 30.0)], {"speed": 5.0}, "0.1 to 4"),
        ([(5, 30.0)], {"speed": math.nan}, "0.1 to 4"),
    ],
)
def test_mistakes(recordings, options, said):
    with pytest.raises(InputError, match=said):
        Timeline(*recordings, **options)

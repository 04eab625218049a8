"""Playback: when frames are due, what is left out, loops and speeds; by a clock of the test's."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.live.playback import play


class Time:
    """A clock that sleeping advances; `busy` seconds pass in each frame that is sent."""

    def __init__(self, busy=0.0):
        self.now, self.busy, self.frames = 100.0, busy, []

    def clock(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds

    def send(self, frame):
        self.frames.append((round(self.now - 100.0, 9), frame))
        self.now += self.busy

    def play(self, motion, **options):
        return play(motion, [self], clock=self.clock, sleep=self.sleep, **options)


def clip(frames=11, fps=50.0):
    translation = np.zeros((frames, 3))
    translation[:, 0] = np.arange(frames) / fps
    return hp.Motion(translation, np.zeros((frames, 55, 3)), fps)


def places(time, person="person0"):
    return [round(float(frame.poses[person].translation[0]), 9) for _, frame in time.frames]


def test_frames_are_sent_when_they_are_due():
    time = Time()
    played = time.play(clip())
    assert [now for now, _ in time.frames] == pytest.approx(np.arange(11) / 50)
    assert (played.frames, played.late) == (11, 0)
    assert places(time) == pytest.approx(np.arange(11) / 50)
    assert [frame.time for _, frame in time.frames] == pytest.approx(np.arange(11) / 50)


@pytest.mark.parametrize(("fps", "speed"), [(100.0, 1.0), (50.0, 0.5), (25.0, 2.0)])
def test_other_rates_and_speeds(fps, speed):
    time = Time()
    time.play(clip(), fps=fps, speed=speed)
    now = np.array([now for now, _ in time.frames])
    assert np.allclose(np.diff(now), 1.0 / fps)
    assert places(time) == pytest.approx(now * speed)


def test_late_frames_are_left_out():
    """Sending takes two and a half frames: the clip still lasts as long as it is."""
    time = Time(busy=0.05)
    played = time.play(clip(51))
    assert played.frames < 25
    assert played.frames + played.late == 51
    assert time.frames[-1][0] == pytest.approx(1.0, abs=0.06)
    assert places(time)[-1] == pytest.approx(1.0)  # it ends in the clip's last pose


def test_the_last_frame_is_sent_however_late():
    time = Time(busy=3.0)
    played = time.play(clip(51))
    assert places(time) == pytest.approx([0.0, 1.0])
    assert (played.frames, played.late) == (2, 49)


def test_loops_end_by_time():
    time = Time()
    played = time.play(clip(), loop=True, seconds=1.0)
    assert played.frames == 50
    assert places(time)[11] == 0.0
    assert [frame.frame for _, frame in time.frames] == list(range(50))


def test_the_person_has_a_name():
    time = Time()
    time.play(clip(), person="ada")
    assert places(time, "ada")[1] == 0.02


@pytest.mark.parametrize("options", [{"speed": 0.0}, {"fps": np.nan}, {"seconds": -1.0}])
def test_mistakes_are_said(options):
    with pytest.raises(InputError):
        Time().play(clip(), **options)

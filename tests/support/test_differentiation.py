"""Rates of sampled motion: exact where they should be, undelayed, and smooth."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.support.differentiation import low_pass, rates, turns


@pytest.mark.parametrize("cutoff", [None, 6.0])
@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0, 240.0])
@pytest.mark.parametrize("frames", [3, 4, 6, 12, 60])
def test_constant_acceleration_is_exact(frames, fps, cutoff):
    """Of however few frames: a running step's flight has a dozen."""
    t = np.arange(frames) / fps
    path = np.stack([2.0 * t - 3.0 * t**2, 0.0 * t, 1.0 + 0.0 * t], axis=1)
    velocity, acceleration = rates(np.diff(path, axis=0), fps, cutoff)
    assert velocity[:, 0] == pytest.approx(2.0 - 6.0 * t, abs=1e-9)
    assert acceleration[:, 0] == pytest.approx(-6.0, abs=1e-6)
    assert not acceleration[:, 1:].any()


def test_the_cutoff_is_where_three_decibels_are_lost():
    fps, t = 120.0, np.arange(1200) / 120.0
    for frequency, kept in ((1.0, 1.0), (6.0, np.sqrt(0.5)), (20.0, 0.0)):
        wave = np.sin(2.0 * np.pi * frequency * t)[:, None]
        passed = low_pass(wave, fps, 6.0)[300:-300]
        size = np.abs(passed).max()
        assert size == pytest.approx(kept, abs=0.03)
        # Not delayed.
        assert np.abs(passed - kept * wave[300:-300]).max() < 0.04


def test_slow_samples_pass_as_they_are():
    values = np.random.default_rng(0).normal(size=(40, 3))
    assert low_pass(values, 10.0, 6.0) is values
    assert low_pass(values, 60.0, None) is values


def test_few_samples():
    assert rates(np.zeros((0, 3)), 30.0, 6.0)[1].shape == (1, 3)
    velocity, acceleration = rates(np.ones((1, 3)), 30.0, 6.0)
    assert velocity == pytest.approx(30.0)
    assert not acceleration.any()


@pytest.mark.parametrize("fps", [30.0, 100.0])
def test_flights_are_filtered_by_themselves(fps):
    """A hop from rest to rest: rest and flight are both exact, whatever the filter."""
    frames, first, end = int(2.0 * fps), int(0.7 * fps), int(1.2 * fps)
    t = np.arange(frames) / fps
    off, on = t[first] - 0.5 / fps, t[end] - 0.5 / fps
    inside = np.clip(t, off, on)
    path = (0.5 * 9.81 * (inside - off) * (on - inside))[:, None]
    velocity, acceleration = rates(np.diff(path, axis=0), fps, 6.0, [(first, end)])
    assert acceleration[first:end] == pytest.approx(-9.81, abs=1e-3)
    assert velocity[first:end, 0] == pytest.approx(
        9.81 * (0.5 * (on + off) - t[first:end]), abs=1e-3
    )
    beside = np.concatenate([acceleration[: first // 2], acceleration[-first // 2 :]])
    assert np.abs(beside).max() < 0.5
    # Two frames are too few to be filtered by themselves.
    short = rates(np.diff(path, axis=0), fps, 6.0, [(first, first + 2)])
    assert short[1] == pytest.approx(rates(np.diff(path, axis=0), fps, 6.0)[1])


def test_turns_are_in_the_world():
    q = rot.multiply(rot.exp(np.outer(np.arange(4), [0.0, 0.0, 0.1])), rot.exp([1.0, 2.0, 0.5]))
    assert turns(q) == pytest.approx(np.tile([0.0, 0.0, 0.1], (3, 1)))

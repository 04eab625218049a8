"""Flights: jumps are airborne, people who float are not."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.support.flight import flights

GRAVITY = np.array([0.0, 0.0, -9.81])


def hop(fps, pause=0.5, air=0.4):
    """Heights of a centre of mass that waits, jumps and waits, and where the ground is near."""
    t = np.arange(int((2 * pause + air) * fps)) / fps
    inside = np.clip(t - pause, 0.0, air)
    height = 1.0 + 0.5 * 9.81 * inside * (air - inside)
    off = (t > pause) & (t < pause + air)
    return np.stack([0 * t, 0 * t, height], axis=1), ~off


@pytest.mark.parametrize("fps", [24.0, 60.0, 240.0])
def test_a_hop_is_airborne(fps):
    centre, carried = hop(fps)
    assert np.array_equal(flights(centre, fps, GRAVITY, carried), ~carried)


def test_floating_is_not():
    centre, carried = hop(60.0)
    still = np.tile(centre[:1], (len(centre), 1))
    assert not flights(still, 60.0, GRAVITY, carried).any()
    assert not flights(still, 60.0, GRAVITY, np.zeros(len(still), dtype=bool)).any()
    assert not flights(centre, 60.0, np.zeros(3), carried).any()


def test_a_fall_from_the_first_frame_to_the_last():
    t = np.arange(20) / 30.0
    centre = np.stack([t, 0 * t, 5.0 - 0.5 * 9.81 * t**2], axis=1)
    assert flights(centre, 30.0, GRAVITY, np.zeros(20, dtype=bool)).all()
    assert not flights(centre[:2], 30.0, GRAVITY, np.zeros(2, dtype=bool)).any()

"""Soles over time: which rest, in clips that float, sink, drift and tilt."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.repair.soles import Soles
from support.damage import DAMAGES
from support.real_clips import real_clip


@pytest.fixture(scope="module")
def scene():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    return scene


@pytest.mark.parametrize("damage", ["sunk", "floating", "drifting", "tilted", "sliding"])
def test_the_same_soles_rest_whatever_the_ground(scene, damage):
    body = hp.Body.default()
    walk = real_clip("asap_walk1.npz").grounded(body)
    asked = Soles.of(walk, body, scene)
    found = Soles.of(DAMAGES[damage](walk, body), body, scene)
    assert 0.3 < asked.rests.mean() < 0.8  # a walk: feet stand for 60 % of the time
    assert (asked.rests == found.rests).mean() > 0.93


def test_one_foot_at_least_rests_in_a_walk(scene):
    body = hp.Body.default()
    soles = Soles.of(real_clip("asap_walk1.npz").grounded(body), body, scene)
    assert soles.rests.any(axis=1).mean() > 0.95
    for patch, first, end in soles.phases():
        assert soles.rests[first:end, patch].all()
        assert end - first >= 3 or first == 0 or end == len(soles.rests)  # 0.1 s
    assert sum(end - first for _, first, end in soles.phases()) == soles.rests.sum()


def test_nobody_rests_in_the_air(scene):
    body = hp.Body.default()
    t = np.arange(31) / 30.0
    height = 1.0 + 3.0 * t - 0.5 * 9.81 * t**2
    motion = hp.Motion(np.outer(height, [0.0, 0.0, 1.0]), np.zeros((31, 55, 3)), 30.0)
    assert not Soles.of(motion, body, scene).rests[3:-3].any()


def test_gaps_are_heights_over_the_floor(scene):
    body = hp.Body.default()
    turn = np.zeros((5, 55, 3))
    turn[:, 0, 0] = np.pi / 2
    motion = hp.Motion(np.zeros((5, 3)), turn, 30.0).grounded(body, 0.25)
    soles = Soles.of(motion, body, scene)
    assert abs(soles.gap.min() - 0.25) < 1e-6
    assert np.abs(soles.lowest.min() - 0.25) < 0.01

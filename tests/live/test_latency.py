"""How long poses take."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from halfphysics.live.incoming import Stamp
from halfphysics.live.latency import Latency


def frame(**stamps):
    return SimpleNamespace(stamps=stamps)


def test_each_pose_counts_once():
    latency = Latency()
    assert latency.percentiles(50.0) is None
    for _ in range(5):  # a frame without a new pose
        latency.add(frame(ada=Stamp(None, 1.0, 1.5)))
    latency.add(frame(ada=Stamp(None, 2.0, 2.1), ben=Stamp(None, 2.0, 2.2)))
    assert latency.percentiles(0.0, 50.0, 100.0) == pytest.approx((0.1, 0.2, 0.5))

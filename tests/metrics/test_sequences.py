"""Sums over sequences, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.scene import Scene
from support.point_bodies import Cloud, Drift


def _clip(frames: int, fps: float = 30.0) -> Drift:
    return Drift(np.zeros((frames, 3)), fps)


def test_over_sequences_by_hand() -> None:
    """A sequence of 2 frames and 4 points, one of 4 frames and 2: the weight of each."""
    scene = Scene()
    scene.add_static("floor", Plane())
    first = metrics.penetration(
        Drift(np.array([[0, 0, 0.0], [0, 0, -0.53]])),
        Cloud(np.array([[0, 0, 0.5], [0, 0, 1.0], [0, 0, 0.52], [0, 0, 2.0]])),
        scene,
    )
    second = metrics.penetration(
        Drift(np.array([[0, 0, 0.0], [0, 0, -0.3], [0, 0, -0.4], [0, 0, 0.0]])),
        Cloud(np.array([[0, 0, 0.2], [0, 0, 1.0]])),
        scene,
    )
    both = metrics.over_sequences([first, second])
    assert (both.sequences, both.frames) == (2, 6)
    assert both.rate_percent == pytest.approx((0 + 50 + 0 + 50 + 50 + 0) / 6)
    assert both.depth_mean_mm == pytest.approx((0 + 30 + 0 + 100 + 200 + 0) / 6)
    assert both.depth_max_mm == pytest.approx((30 + 200) / 2)
    assert both.depth_penetrating_mm == pytest.approx((30 + 10 + 100 + 200) / 4)
    assert both.worst_mm == pytest.approx(200.0)
    alone = metrics.over_sequences([second])
    assert alone.depth_max_mm == second.depth_max_mm
    assert alone.depth_penetrating_mm == pytest.approx(second.depth_penetrating_mm)
    clear = metrics.over_sequences([metrics.penetration(_clip(3), Cloud(np.ones((3, 3))), scene)])
    assert (clear.rate_percent, clear.depth_max_mm, clear.depth_penetrating_mm) == (0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="reports: found none"):
        metrics.over_sequences([])
    with pytest.raises(InputError, match=r"reports: expected those of .*found None"):
        metrics.over_sequences(None)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="reports: expected those of"):
        metrics.over_sequences([first, 3])  # type: ignore[list-item]

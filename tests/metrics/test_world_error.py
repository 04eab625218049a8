"""Errors in the world, by alignments found another way: quaternions, and a search."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.metrics.world_error import pieces, sole_vertices

EXACT = 1e-9


def clip(seed: int, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """A true clip, and one that is turned, scaled, moved and noisy."""
    rng = np.random.default_rng(seed)
    truth = np.cumsum(rng.normal(scale=0.02, size=(frames, 1, 3)), axis=0)
    truth = truth + rng.normal(scale=0.5, size=(frames, 22, 3))
    turn = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    made = 1.3 * (truth + rng.normal(scale=0.05, size=truth.shape)) @ turn.T + rng.normal(size=3)
    return made, truth


def aligned(points: np.ndarray, onto: np.ndarray, scaled: bool, all_points: np.ndarray):
    """Horn 1987: the quaternion of the largest eigenvalue; the scale by its closed form."""
    middle, target = points.mean(axis=0), onto.mean(axis=0)
    a, b = points - middle, onto - target
    s = a.T @ b
    delta = np.array([s[1, 2] - s[2, 1], s[2, 0] - s[0, 2], s[0, 1] - s[1, 0]])
    n = np.zeros((4, 4))
    n[0, 0], n[0, 1:], n[1:, 0] = np.trace(s), delta, delta
    n[1:, 1:] = s + s.T - np.trace(s) * np.eye(3)
    w, x, y, z = np.linalg.eigh(n)[1][:, -1]
    turn = Rotation.from_quat([x, y, z, w]).as_matrix()
    scale = float((b * (a @ turn.T)).sum() / (a**2).sum()) if scaled else 1.0
    return scale * (all_points - middle) @ turn.T + target


@given(st.integers(0, 10**6), st.sampled_from([2, 60, 100, 101, 150, 230]))
@settings(max_examples=15, deadline=None)
def test_wa_and_w_mpjpe(seed: int, frames: int) -> None:
    made, truth = clip(seed, frames)
    for measure, first in ((metrics.wa_mpjpe, None), (metrics.w_mpjpe, 2)):
        errors = []
        for piece in pieces(frames):
            own, true = made[piece], truth[piece]
            moved = aligned(own[:first].reshape(-1, 3), true[:first].reshape(-1, 3), True, own)
            errors += [
                np.linalg.norm(m - t, axis=1).mean() for m, t in zip(moved, true, strict=True)
            ]
        assert measure(made, truth) == pytest.approx(1000.0 * np.mean(errors), abs=1e-8)


def test_pieces_are_cut_as_wham_does() -> None:
    """By its loop: the last piece takes what is left over, without the last frame."""
    assert pieces(40) == [slice(0, 40)]
    assert pieces(150) == [slice(0, 149)]
    assert pieces(200) == [slice(0, 100)]
    assert pieces(230) == [slice(0, 100), slice(100, 229)]
    assert pieces(301) == [slice(0, 100), slice(100, 200), slice(200, 300)]


def test_a_similarity_of_the_truth_has_no_error() -> None:
    _, truth = clip(3, 140)
    turn = Rotation.from_rotvec([0.2, -1.0, 0.4]).as_matrix()
    same = 0.7 * truth @ turn.T + np.array([3.0, -2.0, 1.0])
    assert metrics.wa_mpjpe(same, truth) == pytest.approx(0.0, abs=EXACT)
    assert metrics.w_mpjpe(same, truth) == pytest.approx(0.0, abs=EXACT)
    rigid = truth @ turn.T + np.array([3.0, -2.0, 1.0])
    assert metrics.rte(rigid[:, 0], truth[:, 0]) == pytest.approx(0.0, abs=EXACT)
    # A mirror image is not a rotation away.
    assert metrics.wa_mpjpe(truth * [1.0, 1.0, -1.0], truth) > 100.0


@given(st.integers(0, 10**6), st.integers(4, 60))
@settings(max_examples=20, deadline=None)
def test_rte(seed: int, frames: int) -> None:
    made, truth = clip(seed, frames)
    path, true = made[:, 0], truth[:, 0]
    moved = aligned(path, true, False, path)
    length = sum(np.linalg.norm(true[t + 1] - true[t]) for t in range(frames - 1))
    expected = (
        100.0 * np.mean([np.linalg.norm(m - t) for m, t in zip(moved, true, strict=True)]) / length
    )
    assert metrics.rte(path, true) == pytest.approx(expected, rel=1e-9)


def test_rte_of_a_root_that_stands_is_nothing() -> None:
    assert np.isnan(metrics.rte(np.zeros((5, 3)), np.ones((5, 3))))


def test_world_foot_sliding_by_hand() -> None:
    """The true toe rests in two of three steps; there the other moves 3 and 4 mm."""
    truth, made = np.zeros((4, 4, 3)), np.zeros((4, 4, 3))
    truth[:, 1:, 0] = made[:, 1:, 0] = np.arange(4)[:, None]  # the others walk
    truth[:, 0, 0] = [0.0, 0.009, 0.02, 0.02]
    made[:, 0, 1] = [0.0, 0.003, 0.5, 0.504]
    assert metrics.world_foot_sliding(made, truth) == pytest.approx(3.5, abs=EXACT)
    assert np.isnan(metrics.world_foot_sliding(made[:, 1:], truth[:, 1:]))


def test_soles_are_toes_and_heels() -> None:
    body = hp.Body.default()
    left_toe, left_heel, right_toe, right_heel = body.rest_vertices[sole_vertices(body)]
    ankle = body.rest_joints[hp.JOINT_NAMES.index("left_ankle")]
    assert left_toe[2] > ankle[2] + 0.1 > ankle[2] > left_heel[2]
    assert left_toe[0] > 0.0 > right_toe[0]
    np.testing.assert_allclose(left_heel * [-1, 1, 1], right_heel, atol=5e-3)
    assert max(left_toe[1], left_heel[1]) < ankle[1]


@pytest.mark.parametrize(
    "measure", [metrics.wa_mpjpe, metrics.w_mpjpe, metrics.rte, metrics.world_foot_sliding]
)
def test_the_truth_has_the_same_points(measure) -> None:
    """A longer truth was cut, and what is no number ended in an error of linear algebra."""
    points = np.random.default_rng(0).normal(size=(120, 4, 3))
    points = points[:, 0] if measure is metrics.rte else points
    longer = np.concatenate([points, points])
    for truth in (longer, longer[:121], points[:1], points + np.nan):
        with pytest.raises(InputError, match="truth: found"):
            measure(points, truth)
    with pytest.raises(InputError, match=r"found \d+ numbers that are not finite"):
        measure(points + np.nan, points)

"""IPMAN's stability, by loops over the points, and its hull by linear programming."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import halfphysics as hp
from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.metrics.segments import segments
from halfphysics.metrics.stability import POINTS, in_hull, skin_points, stability_of
from support.boxes import box_person

EXACT = 1e-9


def person():
    return box_person({"pelvis": (0.4, 0.3, 0.5), "left_knee": (0.12, 0.12, 0.5)})


def by_hand(body, vertices: np.ndarray, ground: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Stability error, CoM and points in contact of one skin."""
    points = skin_points(body)
    dense = points.matrix.toarray()
    whole = segments(body)
    volumes = whole.volumes(whole.rows(vertices[None]))[:, 0]
    com, mass, cop, pressure, touching = np.zeros(3), 0.0, np.zeros(3), 0.0, []
    for weights, segment in zip(dense, points.segment, strict=True):
        used = weights.nonzero()[0]
        place = sum(weights[v] * vertices[v] for v in used)
        com, mass = com + volumes[segment] * place, mass + volumes[segment]
        h = place[2] - ground
        p = 1.0 - 100.0 * h if h < 0.0 else math.exp(-10.0 * h)
        cop, pressure = cop + p * place, pressure + p
        if h < 0.1:
            touching.append(place[:2])
    com, cop = com / mass, cop / pressure
    return float(math.dist(com[:2], cop[:2])), com[:2], np.array(touching)


@pytest.mark.parametrize("ground", [0.0, 0.04])
def test_error_and_support_are_those_of_the_definition(ground: float) -> None:
    body = person()
    skins = np.stack(
        [
            body.placed({"pelvis": (0.1, 0.0, 0.75), "left_knee": (0.1, 0.05, 0.25)}),
            body.placed({"pelvis": (0.5, 0.2, 0.75), "left_knee": (0.0, 0.0, 0.23)}),
        ]
    )
    error, inside = stability_of(skins, skin_points(body), ground=ground)
    for k, vertices in enumerate(skins):
        expected, com, touching = by_hand(body, vertices, ground)
        assert error[k] == pytest.approx(expected, abs=EXACT)
        assert bool(inside[k]) == by_programme(touching, com)
    assert inside.tolist() == [1.0, 0.0]


def test_points_are_spread_by_area() -> None:
    """A box of 0.4 x 0.3 x 0.5 and one of 0.12 x 0.12 x 0.5 have 0.94 and 0.2688 m2."""
    points = skin_points(person())
    assert points.counts.sum() == POINTS == len(points.segment)
    share = np.bincount(points.segment).max() / POINTS
    assert share == pytest.approx(0.94 / (0.94 + 0.2688), abs=1e-3)
    matrix = points.matrix.toarray()
    np.testing.assert_allclose(matrix.sum(axis=1), 1.0, atol=1e-12)
    assert matrix.min() >= 0.0
    assert skin_points(hp.Body.default()) is skin_points(hp.Body.default())


def by_programme(points: np.ndarray, place: np.ndarray) -> bool:
    """Whether a place is a convex combination of points: a feasible linear programme."""
    equal = np.vstack([points.T, np.ones(len(points))])
    done = linprog(np.zeros(len(points)), A_eq=equal, b_eq=np.append(place, 1.0), method="highs")
    return bool(done.success)


@given(st.integers(0, 10**6), st.integers(1, 12))
@settings(max_examples=40, deadline=None)
def test_in_hull(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    points, place = rng.normal(size=(count, 2)), rng.normal(scale=0.7, size=2)
    assert in_hull(points, place) == by_programme(points, place)


def upright(*heights: float) -> hp.Motion:
    """A T-pose whose lowest vertex is at these heights [m]."""
    rotations = np.zeros((len(heights), 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    places = np.zeros((len(heights), 3))
    motion = hp.Motion(places, rotations, 30.0)
    lowest = hp.Body.default().vertices(motion, 0)[:, 2].min()
    return hp.Motion(places + np.outer(np.array(heights) - lowest, [0, 0, 1]), rotations, 30.0)


def test_a_report_leaves_out_frames_in_the_air() -> None:
    body = hp.Body.default()
    report = metrics.stability(upright(0.0, 0.0, 1.0), body)
    assert np.isnan(report.error[2])
    assert np.isnan(report.inside[2])
    assert set(report.inside[:2]) <= {0.0, 1.0}
    assert report.bose_percent == pytest.approx(100.0 * report.inside[:2].mean())
    assert report.error_mm == pytest.approx(1000.0 * report.error[:2].mean(), abs=EXACT)
    flying = metrics.stability(upright(9.0, 9.0), body)
    assert np.isnan(flying.error_mm)
    assert np.isnan(flying.bose_percent)


def test_what_is_no_motion_no_body_and_no_height() -> None:
    motion = hp.Motion(np.zeros((2, 3)), np.zeros((2, 55, 3)), 30.0)
    with pytest.raises(InputError, match=r"motion: expected a halfphysics\.Motion, found"):
        metrics.stability("a", person())
    with pytest.raises(InputError, match=r"body: expected a halfphysics\.Body"):
        metrics.stability(motion, "a")
    with pytest.raises(InputError, match="ground: expected a number"):
        metrics.stability(motion, hp.Body.default(), ground="low")

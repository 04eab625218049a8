"""Stability of a body on level ground by IPMAN: stability error, and centre of mass in the support.

Source: IPMAN (Tripathi et al. 2023), sha2nkt/ipman-r stability/stability_metrics.py. There the skin
is SMPL's with its own 20,000 points and parts; here any skin, with points spread evenly over the
area at rest and the 14 segments of `halfphysics.metrics.segments`. With points x_i at heights h_i::

    CoM = sum_i V_i x_i / sum_i V_i        V_i: volume of the segment that x_i is on, in the pose
    CoP = sum_i p_i x_i / sum_i p_i        p_i = 1 - 100 h_i for h_i < 0, exp(-10 h_i) otherwise
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import validation
from halfphysics.base.short_repr import short_repr
from halfphysics.metrics.argument_checks import Array, check_motion
from halfphysics.metrics.segments import Segments, segments
from halfphysics.metrics.skins import batches, skin

#: Number of points on the skin.
POINTS = 20_000
#: Height under which a point is in contact [m] (its hparams.contact_thresh).
CONTACT_HEIGHT = 0.1
#: Of that many points in contact or fewer there is no base of support.
FEWEST = 10
#: Fall of pressure with height and its rise with depth [1/m]; h is in metres.
FALL, RISE = 10.0, 100.0
_SEED = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class StabilityReport:
    """Stability of T frames.

    Attributes:
        error_mm: Mean over the frames in contact of the stability error [mm]; NaN without any.
        bose_percent: Share of the frames with a base of support in which the centre of mass is
            above it [%]; NaN without any.
        error: Horizontal distance of CoM and CoP (T,) [m]; NaN where no point is in contact.
        inside: Whether the CoM is in the base of support (T,), 1 or 0; NaN where there is none.
    """

    error_mm: float
    bose_percent: float
    error: Array
    inside: Array

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class SkinPoints:
    """Points fixed to the skin: x_i = sum_k weights[i, k] vertices[corners[i, k]].

    Attributes:
        matrix: The same as a sparse matrix (n, V).
        segment: Segment of each (n,).
        sums: Sum of the points of each segment as a sparse matrix (G, V).
        counts: Number of points of each segment (G,).
        segments: The segments.
    """

    matrix: Any
    segment: NDArray[np.intp]
    sums: Any
    counts: NDArray[np.intp]
    segments: Segments


def stability(motion: Any, body: Any, *, ground: float = 0.0) -> StabilityReport:
    """IPMAN's stability error and BoSE of a motion.

    The stability error of a frame is the horizontal distance of CoM and CoP, of no meaning (NaN)
    where no point is under 10 cm. The base of support is the convex hull of the points under 10 cm,
    seen from above; there is none for 10 points or fewer.

    Args:
        motion: T frames.
        body: The person's body; its skin counts.
        ground: Height of the ground [m].

    Raises:
        InputError: No motion, no body, or a height that is no number.
    """
    check_motion("motion", motion)
    validation.body(body, "vertices")
    ground = validation.number(ground, "ground", unit="m")
    points = skin_points(body)
    parts = [
        stability_of(skin(motion, body, part), points, ground=ground)
        for part in batches(len(motion), "stability")
    ]
    return report_of(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def report_of(error: Array, inside: Array) -> StabilityReport:
    """The report of the frames' errors (T,) [m] and of their support (T,)."""
    held, based = np.isfinite(error), np.isfinite(inside)
    return StabilityReport(
        error_mm=float(1000.0 * error[held].mean()) if held.any() else float("nan"),
        bose_percent=float(100.0 * inside[based].mean()) if based.any() else float("nan"),
        error=error,
        inside=inside,
    )


def stability_of(
    vertices: Array, points: SkinPoints, *, ground: float = 0.0
) -> tuple[Array, Array]:
    """Stability error (t,) [m] and whether the CoM is in the base of support (t,) of skins.

    Args:
        vertices: Skins (t, V, 3) [m].
        points: Points on them.
        ground: Height of the ground [m].
    """
    frames, count = vertices.shape[:2]
    rows = points.segments.rows(vertices)
    origin = rows[0].copy()
    rows -= origin  # what follows is relative to it
    flat = rows[:count].reshape(count, -1)
    places = (points.matrix @ flat).reshape(-1, 3, frames)
    sums = (points.sums @ flat).reshape(-1, 3, frames)
    volumes = points.segments.volumes(rows)
    com = np.einsum("gt,gxt->xt", volumes, sums) / np.einsum("gt,g->t", volumes, points.counts)
    height = places[:, 2] + (origin[2] - ground)
    pressure = np.maximum(height, 0.0)
    pressure *= -FALL
    np.exp(pressure, out=pressure)
    sunk = height < 0.0
    pressure[sunk] = 1.0 - RISE * height[sunk]
    across = places[:, :2]
    cop = np.einsum("nt,nxt->xt", pressure, across) / pressure.sum(axis=0)
    contact = height < CONTACT_HEIGHT
    error = np.where(contact.any(axis=0), np.linalg.norm(com[:2] - cop, axis=0), np.nan)
    inside = np.full(frames, np.nan)
    for t in range(frames):
        below = contact[:, t]
        if below.sum() > FEWEST:
            inside[t] = in_hull(across[below, :, t], com[:2, t])
    return error, inside


def in_hull(points: Array, place: Array) -> bool:
    """Whether a place (2,) is in the convex hull of points (n, 2), its rim included.

    It is unless the directions to all points fit into an open half plane: their angles then leave a
    gap of over half a turn.
    """
    way = points - place
    if not way.any(axis=1).all():
        return True  # at one of them
    angle = np.sort(np.arctan2(way[:, 1], way[:, 0]))
    gaps = np.diff(angle, append=angle[0] + 2.0 * np.pi)
    return bool(gaps.max() <= np.pi)


_known: WeakKeyDictionary[Any, SkinPoints] = WeakKeyDictionary()


def skin_points(body: Any) -> SkinPoints:
    """20,000 points spread evenly over a body's skin at rest, the same for each call."""
    found = _known.get(body)
    if found is None:
        found = _known[body] = _spread(body)
    return found


def _spread(body: Any) -> SkinPoints:
    from scipy.sparse import csr_array

    faces, rest = np.asarray(body.faces), np.asarray(body.rest_vertices)
    a, b, c = (rest[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    # Equal steps along the summed area: every face gets its share, rounded.
    rng = np.random.default_rng(_SEED)
    steps = (np.arange(POINTS) + rng.random(POINTS)) / POINTS * area.sum()
    face = np.minimum(np.searchsorted(np.cumsum(area), steps), len(faces) - 1)
    u, v = rng.random((2, POINTS))
    root = np.sqrt(u)
    weights = np.stack([1.0 - root, root * (1.0 - v), root * v], axis=1)
    whole = segments(body)
    segment = whole.of_face[face]
    rows = np.repeat(np.arange(POINTS), 3)
    shape = (POINTS, len(rest))
    matrix = csr_array((weights.reshape(-1), (rows, faces[face].reshape(-1))), shape=shape)
    groups = len(whole.faces)
    member = csr_array((np.ones(POINTS), (segment, np.arange(POINTS))), shape=(groups, POINTS))
    counts = np.bincount(segment, minlength=groups)
    return SkinPoints(matrix, segment, (member @ matrix).tocsr(), counts, whole)

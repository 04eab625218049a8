"""Judges a recorded run independently: are the people clear of all statics, and do they stay so?

Two questions about the convex pieces that must stay clear (`person_hulls`: hulls of the skin, or
the rigid parts). The core supplies only coordinates and body frames:

1. *Clear*: at every committed pose, does a piece meet a static? Distances by `coal`, hull against
   triangles or primitive; a plane that proves one farther than the smallest known distance
   is enough.
2. *Side*: between two committed poses, could the piece get from one to the other without meeting
   the static? A single sheet, a pole or a rod has no inside that a jump could end in, so poses
   alone do not tell. The judge requires a witness, a continuous motion of the piece:

   - the sum of the distances at both ends exceeds the longest way of a vertex; or
   - a plane that has both hulls on one side and the obstacle on the other; or
   - the hull of both sets of vertices is disjoint from the obstacle, or, the step split into
     pieces, their hulls are: the vertices move straight; or
   - the motion of the body (root straight, rotations by the shortest arc) is clear, by
     conservative advancement; or
   - two or four such motions are, over poses stepped back a little (`DETOURS`): a split
     step may bend around an edge.

   With a witness the piece is on its side of the static. Without any it has crossed.
   Only the last three can miss a way that exists, and only near obstacles.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Mesh, Plane
from support.judges.coal_shapes import coal_hull, coal_shape
from support.judges.person_hulls import pieces_of

#: Farther pairs are skipped [m].
NEAR = 0.005
#: Accuracy of coal's own distances [m].
ROUNDING = 1e-6
#: Poses processed together: bounds the memory.
CHUNK = 64
#: The planes that separated last are tried first.
RECENT = 3
#: A step without witness is halved at most this often.
STRAIGHT_DEPTH, ARC_DEPTH, BENT_DEPTH = 4, 12, 1
#: How far a piece may step back from an obstacle on its way from one pose to the next [m]: too
#: little to get around any obstacle of the throws.
DETOURS = (0.005, 0.02)


@dataclass
class Verdict:
    """Results: distances [m], and their places."""

    poses: int = 0
    start: float = np.inf
    gap: float = np.inf
    where: tuple[str, str, int] = ("", "", -1)
    crossed: list[tuple[str, str, int]] = field(default_factory=list)
    inside: set[int] = field(default_factory=set)

    @property
    def clear(self) -> bool:
        """No committed pose intersects a static and no step crosses one."""
        return self.gap >= -ROUNDING and not self.crossed


@dataclass
class _Static:
    name: str
    shape: object
    place: object
    low: np.ndarray
    high: np.ndarray
    plane: tuple[np.ndarray, float] | None = None
    triangles: np.ndarray | None = None  # (F, 3, 3), in the world
    lows: np.ndarray | None = None  # lower corners of the triangles' boxes (F, 3)
    highs: np.ndarray | None = None

    def within(self, low, high):
        """The same solid, with only the triangles that meet the box around these boxes (n, 3)."""
        if self.triangles is None:
            return self
        kept = (self.lows <= high.max(axis=0)) & (self.highs >= low.min(axis=0))
        kept = kept.all(axis=1)
        return replace(
            self, triangles=self.triangles[kept], lows=self.lows[kept], highs=self.highs[kept]
        )


def _static(s):
    turn, position = rot.to_matrix(s.quaternion), np.asarray(s.position, float)
    if isinstance(s.shape, Plane):
        normal = turn @ np.asarray(s.shape.normal, float)
        wide = np.full(3, np.inf)
        offset = s.shape.offset + normal @ position
        return _Static(s.name, None, None, -wide, wide, plane=(normal, offset))
    place = coal.Transform3s(turn, position)
    vertices, faces = s.shape.triangles()
    vertices = np.asarray(vertices) @ turn.T + position
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if isinstance(s.shape, Mesh):
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(faces), len(vertices))
        model.addVertices(vertices)
        model.addTriangles(np.asarray(faces, dtype=np.int64))
        model.endModel()
        t = vertices[np.asarray(faces)]
        return _Static(
            s.name, model, coal.Transform3s(), low, high, None, t, t.min(axis=1), t.max(axis=1)
        )
    shape = coal_shape(s.shape, solid=False)
    # Facets lie within the round shape: the true extent by its own box.
    shape.computeLocalAABB()
    half = np.abs(turn) @ np.maximum(np.abs(shape.aabb_local.min_), np.abs(shape.aabb_local.max_))
    return _Static(s.name, shape, place, position - half, position + half)


class Judge:
    """Judges the committed poses of one simulator.

    `contact`: the hulls of the "skin", the rigid "parts" or "both"; None: the pieces that the
    simulator keeps clear.
    """

    def __init__(self, simulator, contact=None):
        world = simulator.world
        self.world, self.pieces = world, pieces_of(simulator, contact)
        self.statics = [_static(s) for s in world.scene.statics.values()]
        self.ignored = [world.scene.ignores("person", s.name) for s in self.statics]
        self.request = coal.DistanceRequest()
        self.touching = coal.CollisionRequest()

    def judge(self, start, frames) -> Verdict:
        """`start`: coordinates (nq,) of the first pose; `frames`: with their substeps recorded."""
        return self.judge_poses(np.concatenate([start[None], *(f.substeps for f in frames)]))

    def judge_poses(self, poses) -> Verdict:
        """`poses`: consecutive coordinates (T, nq), the first at index 0."""
        verdict = Verdict(poses=len(poses) - 1)
        for first in range(0, max(1, len(poses) - 1), CHUNK):
            for pieces in self.pieces:
                self._chunk(pieces.at(poses[first : first + CHUNK + 1]), first, verdict)
        return verdict

    def gap_to(self, static, pose):
        """Distance of a `halfphysics.scene.scene.Static` from a pose (nq,); inf beyond `NEAR`."""
        s, best, recent = _static(static), np.inf, []
        for pieces in self.pieces:
            at = pieces.at(pose[None])
            low, high = at.low[0] - NEAR, at.high[0] + NEAR
            for i in np.flatnonzero(_near(s, low, high)):
                near = s.within(low[i][None], high[i][None])
                if not _behind(near, at.points(i, 0), recent, min(best, NEAR)):
                    d, away = self._distance(at.points(i, 0), at.solid(i, 0), s)
                    best = min(best, d)
                    _keep(recent, away)
        return best

    # -- one chunk -------------------------------------------------------------------------

    def _chunk(self, at, first, verdict):
        # Boxes around a piece's way from each pose to the next.
        low = np.minimum(at.low[:-1], at.low[1:]) - NEAR
        high = np.maximum(at.high[:-1], at.high[1:]) + NEAR
        for s, ignored in zip(self.statics, self.ignored, strict=True):
            if ignored:
                continue
            near = _near(s, low, high)
            for i in np.flatnonzero(near.any(axis=0)):
                steps = np.flatnonzero(near[:, i])
                self._steps(at, int(i), s.within(low[steps, i], high[steps, i]), steps, first,
                            verdict)  # fmt: skip

    def _steps(self, at, i, s, steps, first, verdict):
        """Piece i and the nearby triangles of a static in these steps of a chunk."""
        name, known, recent = at.pieces.names[i], {}, []

        def exact(k):
            if k not in known:
                known[k] = self._distance(at.points(i, k), at.solid(i, k), s)
                _keep(recent, known[k][1])
                self._note(known[k][0], name, s, first + k, verdict)
            return known[k]

        for k in map(int, steps):
            both = np.concatenate([at.points(i, k), at.points(i, k + 1)])
            # Beyond these planes no distance is below the known one, at either pose or between.
            if first + k > 0 and _behind(s, both, recent, max(min(verdict.gap, NEAR), 0.0)):
                continue
            before, after = exact(k), exact(k + 1)
            # One proven crossing is enough: later steps get fewer attempts.
            patient = not verdict.crossed
            if s.plane is None and not self._kept(_Way(at, i, k), s, before, after, patient):
                verdict.crossed.append((name, s.name, first + k + 1))

    def _note(self, gap, name, s, pose, verdict):
        if pose == 0:
            verdict.start = min(verdict.start, gap)
        if gap < -ROUNDING:
            verdict.inside.add(pose)
        if gap < verdict.gap:
            verdict.gap, verdict.where = float(gap), (name, s.name, pose)

    def _distance(self, points, solid, s):
        """Distance and a normal from the static to the piece (any normal if they meet)."""
        if s.plane is not None:
            return (points @ s.plane[0]).min() - s.plane[1], s.plane[0]
        result = coal.DistanceResult()
        d = coal.distance(*solid, s.shape, s.place, self.request, result)
        return d, np.array(result.getNearestPoint1()) - np.array(result.getNearestPoint2())

    # -- the way between two poses -----------------------------------------------------------

    def _kept(self, way, s, before, after, patient=True):
        if before[0] <= 0.0 or after[0] <= 0.0:
            return True  # inside at a committed pose: counted there
        w0, w1 = way.ends
        if before[0] + after[0] > np.sqrt(np.max(np.sum((w1 - w0) ** 2, axis=1))):
            return True
        normals = [n / np.linalg.norm(n) for _, n in (before, after) if np.linalg.norm(n) > 0.0]
        if _behind(s, np.concatenate([w0, w1]), normals):
            return True
        a, b = _Stop(0.0, np.zeros(3), *before), _Stop(1.0, np.zeros(3), *after)
        return (
            self._straight(w0, w1, s, STRAIGHT_DEPTH)
            or self._arc(way, s, a, b, ARC_DEPTH)
            or (patient and self._bent(way, s, a, b, BENT_DEPTH))
        )

    def _straight(self, w0, w1, s, depth):
        hull = coal_hull(np.concatenate([w0, w1]))
        result = coal.CollisionResult()
        here = coal.Transform3s()
        if not coal.collide(hull, here, s.shape, s.place, self.touching, result):
            return True
        if depth == 0:
            return False
        middle = 0.5 * (w0 + w1)
        return self._straight(w0, middle, s, depth - 1) and self._straight(middle, w1, s, depth - 1)

    def _stop(self, way, s, share, offset):
        points = way.points(share) + offset
        gap, away = self._distance(points, (coal_hull(points), coal.Transform3s()), s)
        return _Stop(share, offset, gap, away)

    def _bent(self, way, s, a, b, depth):
        """The body's motion in two halves, and in four, over poses stepped back from the middle."""
        ends = [stop.away / max(np.linalg.norm(stop.away), 1e-12) for stop in (a, b)]
        out = [*ends, ends[0] + ends[1]]
        for share, n, detour in product((0.5, 0.0, 1.0), out, DETOURS):
            offset = a.offset + share * (b.offset - a.offset) + detour * n
            there = self._stop(way, s, a.share + share * (b.share - a.share), offset)
            if there.gap <= 0.0:
                continue
            if all(
                self._arc(way, s, c, d, ARC_DEPTH)
                or (depth > 0 and self._bent(way, s, c, d, depth - 1))
                for c, d in ((a, there), (there, b))
            ):
                return True
        return False

    def _arc(self, way, s, a, b, depth):
        length = (b.share - a.share) * way.length + np.linalg.norm(b.offset - a.offset)
        if a.gap + b.gap > length:
            return True
        if depth == 0:
            return False
        middle = self._stop(way, s, 0.5 * (a.share + b.share), 0.5 * (a.offset + b.offset))
        if middle.gap <= 0.0:
            return False
        return self._arc(way, s, a, middle, depth - 1) and self._arc(way, s, middle, b, depth - 1)


class _Way:
    """The motion of a piece from one pose to the next, without other influence."""

    def __init__(self, at, i, k):
        self._at, self._i, self._k = at, i, k
        self.ends = at.points(i, k), at.points(i, k + 1)

    @property
    def length(self):
        return self._at.length(self._i, self._k)

    def points(self, share):
        return self._at.between(self._i, self._k, share)


@dataclass
class _Stop:
    """A point of a way, at a share of it and moved by an offset (3,): distance and direction."""

    share: float
    offset: np.ndarray
    gap: float
    away: np.ndarray


def _near(s, low, high):
    """Which boxes (..., 3) meet the box of a static."""
    if s.plane is not None:
        n, offset = s.plane
        return np.where(n > 0.0, low, high) @ n < offset
    return ((low < s.high) & (high > s.low)).all(axis=-1)


def _keep(recent, away):
    """Puts the latest direction first."""
    length = np.linalg.norm(away)
    if length > 0.0:
        recent.insert(0, away / length)
        del recent[RECENT:]


def _behind(s, points, normals, far=0.0):
    """Whether planes of these normals prove that no static is within `far` of the points (n, 3).

    Of a mesh every triangle has to be behind one of the planes, or away from the points' box.
    """
    if s.plane is not None:
        return (points @ s.plane[0]).min() - s.plane[1] > far
    left = None
    if s.triangles is not None:
        low, high = points.min(axis=0) - far, points.max(axis=0) + far
        left = s.triangles[((s.lows <= high) & (s.highs >= low)).all(axis=1)]
        if not len(left):
            return True
    for n in normals:
        bottom = (points @ n).min() - far
        if left is None:
            if _highest(s, n) < bottom:
                return True
            continue
        left = left[(left @ n).max(axis=1) >= bottom]
        if not len(left):
            return True
    return False


def _highest(s, n):
    """A convex primitive's largest extent along n (an upper bound by its hull)."""
    turn, x = s.place.getRotation(), s.place.getTranslation()
    local, shape = turn.T @ n, s.shape
    if isinstance(shape, coal.Box):
        reach = np.abs(local) @ shape.halfSide
    elif isinstance(shape, coal.Sphere):
        reach = shape.radius
    elif isinstance(shape, coal.Capsule):
        reach = shape.radius + shape.halfLength * abs(local[2])
    else:
        reach = shape.radius * np.hypot(local[0], local[1]) + shape.halfLength * abs(local[2])
    return reach + n @ x

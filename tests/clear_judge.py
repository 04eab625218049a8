"""Judges a recorded run from outside: were the people clear of all statics, and did they stay so?

Two questions, neither answered with anything of the core but its body frames:

1. *Clear*: at every committed pose, does the convex hull of each part meet a static? Distances by
   `coal`, hull against triangles or primitive.
2. *Side*: between two committed poses, could the part get from one to the other without meeting
   the static? A single sheet, a pole or a rod has no inside that a jump could end in, so poses
   alone do not tell. Asked for is a witness, a continuous motion of the part that meets nothing:

   - the sum of the distances at both ends exceeds the longest way of a vertex; or
   - a plane that has both hulls on one side and the obstacle on the other; or
   - the hull of both sets of vertices is disjoint from the obstacle, or, the step cut into
     pieces, those of the pieces are: the vertices move straight; or
   - the rigid motion (origin straight, rotation by the shortest arc) is clear, by conservative
     advancement; or
   - two or four such motions are, over poses stepped back a little (`DETOURS`): a step that was
     made in pieces may bend around an edge.

   With a witness the part is where it could have got to: on its side. Without any it has crossed.
   Only the last three can miss a way that exists, and only where the obstacle stands in all.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import coal
import numpy as np
from coal_scene import coal_hull, coal_shape

from halfphysics import rotations as rot
from halfphysics.shapes import Mesh, Plane

#: Pairs farther apart than this are not looked at [m].
NEAR = 0.005
#: coal's own distances are good to this [m].
ROUNDING = 1e-6
#: Poses looked at together: bounds the memory.
CHUNK = 512
#: A step without witness is cut in halves at most this often.
STRAIGHT_DEPTH, ARC_DEPTH, BENT_DEPTH = 4, 12, 1
#: How far a part may step back from an obstacle on its way from one pose to the next [m]: not far
#: enough to get around anything that it was thrown at.
DETOURS = (0.005, 0.02)


@dataclass
class Verdict:
    """What was found: distances [m], and where."""

    poses: int = 0
    start: float = np.inf
    gap: float = np.inf
    where: tuple[str, str, int] = ("", "", -1)
    crossed: list[tuple[str, str, int]] = field(default_factory=list)
    inside: set[int] = field(default_factory=set)

    @property
    def clear(self) -> bool:
        """No committed pose intersects anything and nothing was crossed between two."""
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
        return _Static(
            s.name, model, coal.Transform3s(), low, high, triangles=vertices[np.asarray(faces)]
        )
    shape = coal_shape(s.shape, solid=False)
    # Facets lie within the round shape: the true extent by its own box.
    shape.computeLocalAABB()
    half = np.abs(turn) @ np.maximum(np.abs(shape.aabb_local.min_), np.abs(shape.aabb_local.max_))
    return _Static(s.name, shape, place, position - half, position + half)


class Judge:
    """Looks at the committed poses of one simulator."""

    def __init__(self, simulator):
        world = simulator.world
        self.world, self.stepper = world, world.stepper
        self.statics = [_static(s) for s in world.scene.statics.values()]
        self.ignored = [world.scene.ignores("person", s.name) for s in self.statics]
        self.names, self.bodies, self.points, self.shapes = [], [], [], []
        for person in world.people:
            for part in person.body.variant.parts:
                if len(part.vertices) < 4:
                    continue
                self.names.append(f"{person.name}/{part.name}")
                self.bodies.append(world.model.body(f"{person.name}/{part.name}").id)
                self.points.append(np.asarray(part.vertices, float))
                self.shapes.append(coal_hull(self.points[-1]))
        lows = np.array([p.min(axis=0) for p in self.points])
        highs = np.array([p.max(axis=0) for p in self.points])
        self.middle, self.half = 0.5 * (lows + highs), 0.5 * (highs - lows)
        self.size = np.array([np.linalg.norm(p, axis=1).max() for p in self.points])
        self.request = coal.DistanceRequest()
        self.touching = coal.CollisionRequest()

    def judge(self, start, frames) -> Verdict:
        """`start`: coordinates (nq,) of the first pose; `frames`: with their substeps recorded."""
        return self.judge_poses(np.concatenate([start[None], *(f.substeps for f in frames)]))

    def judge_poses(self, poses) -> Verdict:
        """`poses`: coordinates (T, nq) of one after the other, the first at index 0."""
        verdict = Verdict(poses=len(poses) - 1)
        for first in range(0, max(1, len(poses) - 1), CHUNK):
            self._chunk(poses[first : first + CHUNK + 1], first, verdict)
        return verdict

    def gap_to(self, static, pose):
        """Distance of a `halfphysics.scene.Static` from a pose (nq,); inf beyond `NEAR`."""
        x, turn = self._frames(pose[None])
        low, high = self._boxes(x, turn)
        s, best = _static(static), np.inf
        for i in range(len(self.points)):
            if (low[0, i] < s.high).all() and (high[0, i] > s.low).all():
                best = min(best, self._distance(i, x[0, i], turn[0, i], s)[0])
        return best

    # -- one chunk -------------------------------------------------------------------------

    def _frames(self, poses):
        x, q = zip(*(self.stepper.body_frames(p) for p in poses), strict=True)
        x, q = np.array(x)[:, self.bodies], np.array(q)[:, self.bodies]
        return x, rot.to_matrix(rot.normalize(q))

    def _boxes(self, x, turn):
        middle = x + np.einsum("spij,pj->spi", turn, self.middle)
        half = np.einsum("spij,pj->spi", np.abs(turn), self.half) + NEAR
        return middle - half, middle + half

    def _chunk(self, poses, first, verdict):
        x, turn = self._frames(poses)
        low, high = self._boxes(x, turn)
        # Boxes around a part's way from each pose to the next.
        swept_low = np.minimum(low[:-1], low[1:])
        swept_high = np.maximum(high[:-1], high[1:])
        for s, ignored in zip(self.statics, self.ignored, strict=True):
            if ignored:
                continue
            if s.plane is not None:
                n, offset = s.plane
                near = np.where(n > 0.0, swept_low, swept_high) @ n < offset
            else:
                near = (swept_low < s.high).all(axis=2) & (swept_high > s.low).all(axis=2)
            for i in np.flatnonzero(near.any(axis=0)):
                known = {}

                def at(k, i=i, s=s, known=known):
                    if k not in known:
                        known[k] = self._distance(i, x[k, i], turn[k, i], s)
                        self._note(known[k][0], i, s, first + k, verdict)
                    return known[k]

                for k in np.flatnonzero(near[:, i]):
                    before, after = at(int(k)), at(int(k) + 1)
                    # One that is proved is enough: the others are not looked at as patiently.
                    ways = x[k : k + 2, i], turn[k : k + 2, i]
                    if s.plane is None and not self._kept(
                        i, s, before, after, *ways, patient=not verdict.crossed
                    ):
                        verdict.crossed.append((self.names[i], s.name, first + int(k) + 1))

    def _note(self, gap, i, s, pose, verdict):
        if pose == 0:
            verdict.start = min(verdict.start, gap)
        if gap < -ROUNDING:
            verdict.inside.add(pose)
        if gap < verdict.gap:
            verdict.gap, verdict.where = float(gap), (self.names[i], s.name, pose)

    def _distance(self, i, x, turn, s):
        """Distance and a normal from the static to the part (any, where they meet)."""
        if s.plane is not None:
            return ((self.points[i] @ turn.T + x) @ s.plane[0]).min() - s.plane[1], s.plane[0]
        result = coal.DistanceResult()
        pose = coal.Transform3s(turn, x)
        d = coal.distance(self.shapes[i], pose, s.shape, s.place, self.request, result)
        return d, np.array(result.getNearestPoint1()) - np.array(result.getNearestPoint2())

    # -- the way between two poses -----------------------------------------------------------

    def _kept(self, i, s, before, after, x, turn, patient=True):
        if before[0] <= 0.0 or after[0] <= 0.0:
            return True  # inside at a committed pose: counted there
        w0, w1 = (self.points[i] @ turn[k].T + x[k] for k in (0, 1))
        way = np.sqrt(np.max(np.sum((w1 - w0) ** 2, axis=1)))
        if before[0] + after[0] > way:
            return True
        both = np.concatenate([w0, w1])
        left = None
        if s.triangles is not None:
            t = s.triangles
            low, high = both.min(axis=0), both.max(axis=0)
            left = t[((t.min(axis=1) <= high) & (t.max(axis=1) >= low)).all(axis=1)]
        for _, away in (before, after):
            length = np.linalg.norm(away)
            if length <= 0.0:
                continue
            n = away / length
            bottom = (both @ n).min()
            if left is not None:
                left = left[(left @ n).max(axis=1) >= bottom]
                if not len(left):
                    return True
            elif _highest(s, n) < bottom:
                return True
        return (
            self._straight(w0, w1, s, STRAIGHT_DEPTH)
            or self._arc(i, s, x, turn, 0.0, 1.0, before[0], after[0], ARC_DEPTH)
            or (patient and self._bent(i, s, x, turn, before, after, BENT_DEPTH))
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

    def _bent(self, i, s, x, turn, before, after, depth):
        """The rigid motion in two, and those in two, over poses stepped back from the middle."""
        turned = rot.matrix_to_rotvec(turn[0].T @ turn[1])
        ends = [n / max(np.linalg.norm(n), 1e-12) for _, n in (before, after)]
        out = [*ends, ends[0] + ends[1]]
        for share, n, detour in product((0.5, 0.0, 1.0), out, DETOURS):
            middle = x[0] + share * (x[1] - x[0]) + detour * n
            between = turn[0] @ rot.rotvec_to_matrix(share * turned)
            there = self._distance(i, middle, between, s)
            if there[0] <= 0.0:
                continue
            legs = [
                (np.array([x[0], middle]), np.array([turn[0], between]), before, there),
                (np.array([middle, x[1]]), np.array([between, turn[1]]), there, after),
            ]
            if all(
                self._arc(i, s, y, r, 0.0, 1.0, a[0], b[0], ARC_DEPTH)
                or (depth > 0 and self._bent(i, s, y, r, a, b, depth - 1))
                for y, r, a, b in legs
            ):
                return True
        return False

    def _arc(self, i, s, x, turn, a, b, gap_a, gap_b, depth):
        turned = rot.matrix_to_rotvec(turn[0].T @ turn[1])
        way = np.linalg.norm(x[1] - x[0]) + self.size[i] * np.linalg.norm(turned)
        if gap_a + gap_b > (b - a) * way:
            return True
        if depth == 0:
            return False
        c = 0.5 * (a + b)
        gap, _ = self._distance(
            i, x[0] + c * (x[1] - x[0]), turn[0] @ rot.rotvec_to_matrix(c * turned), s
        )
        if gap <= 0.0:
            return False
        return self._arc(i, s, x, turn, a, c, gap_a, gap, depth - 1) and self._arc(
            i, s, x, turn, c, b, gap, gap_b, depth - 1
        )


def _highest(s, n):
    """The farthest that a convex primitive reaches along n (an upper bound by its hull)."""
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

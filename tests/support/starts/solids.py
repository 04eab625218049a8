"""Shapes for measuring starts in penetration: convex solids, and the convex hulls of a person.

Depths are those of `coal` (EPA), or exact along a direction; kinematics are the body's own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import coal
import numpy as np

from halfphysics.base import rotations as rot
from support import short_rows as rows
from support.judges.coal_shapes import coal_hull

#: Smaller depths are no penetration: the accuracy of EPA and of the substep's own solve [m].
EXACT = 1e-6
#: Steps of the search for the end of an overlap, and its tolerance [m].
ADVANCES, ARRIVED = 60, 1e-8


def _request():
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-9
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    return request


REQUEST = _request()


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex piece of a static: a box, or (half None) the half-space under a plane.

    Attributes:
        name: For reports.
        turn: Its axes in the world (3, 3), columns; a plane's normal is the third.
        centre: Of the box, or a point of the plane (3,) [m].
        half: Half extents (3,) [m].
        near: Of a thin wall: its face (0 to 5: +x, -x, +y ...) on the root's side. The half-space
            beyond that face counts as inside.
        static: The static of this piece; pieces of one are left together.
    """

    name: str
    turn: np.ndarray
    centre: np.ndarray
    half: np.ndarray | None = None
    near: int | None = None
    static: str = ""

    @cached_property
    def normals(self):
        """Outward normals of its faces (m, 3)."""
        if self.half is None:
            return self.turn[:, 2][None]
        return np.stack([self.turn[:, 0], -self.turn[:, 0], self.turn[:, 1], -self.turn[:, 1],
                         self.turn[:, 2], -self.turn[:, 2]])  # fmt: skip

    @cached_property
    def offsets(self):
        """The solid is where normals . x < offsets (m,)."""
        half = np.zeros(1) if self.half is None else np.repeat(self.half, 2)
        return self.normals @ self.centre + half

    @cached_property
    def geometry(self):
        return None if self.half is None else coal.Box(*(2.0 * self.half))

    @cached_property
    def place(self):
        return coal.Transform3s(self.turn, self.centre)

    def separation(self, points):
        """Largest distance of points (..., n, 3) together from one of the faces' planes (...):
        positive only where the hull of the points is clear."""
        return ((points @ self.normals.T).min(axis=-2) - self.offsets).max(axis=-1)

    def crossed(self, a, b):
        """Which of the lines from a to b (n, 3) meet the solid (n,)."""
        at, speed = a @ self.normals.T - self.offsets, (b - a) @ self.normals.T
        level = np.abs(speed) < 1e-12
        when = -at / np.where(level, 1.0, speed)
        low = np.where(level | (speed > 0.0), 0.0, when).max(axis=1)
        high = np.where(level | (speed < 0.0), 1.0, when).min(axis=1)
        return (np.maximum(low, 0.0) < np.minimum(high, 1.0)) & ~(level & (at > 0.0)).any(axis=1)

    def moved(self, turn, shift):
        """The same solid under a rotation (3, 3), then a shift (3,)."""
        return replace(self, turn=turn @ self.turn, centre=turn @ self.centre + shift)


def box(name, low, high, near=None):
    """An axis-parallel box between two corners."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    return Solid(name, np.eye(3), 0.5 * (low + high), 0.5 * (high - low), near)


def ground(name="floor", z=0.0):
    """The half-space under a height."""
    return Solid(name, np.eye(3), np.array([0.0, 0.0, z]))


class Hulls:
    """The convex pieces of a person: rigid parts, or sets of skin vertices."""

    def __init__(self, body, contact):
        self.body, self.contact = body, contact
        if contact == "parts":
            parts = [p for p in body.variant.parts if len(p.vertices) >= 4]
            self.joint = np.array([p.index for p in parts])
            self.local = [np.asarray(p.vertices, float) for p in parts]
            self.shapes = [coal_hull(p) for p in self.local]
        else:
            sets = body.skin_hulls
            first = np.asarray(sets.first)
            self.joint = np.asarray(sets.part)
            self.index = np.split(np.asarray(sets.vertex), first[1 : len(self.joint)])

    def __len__(self):
        return len(self.joint)

    def at(self, motion):
        """All hulls along a motion of T poses."""
        return Posed(self, motion)


class Posed:
    """Hulls at T poses.

    Attributes:
        joints: (T, 55, 3) [m]. skin: all skin vertices (T, V, 3).
        points: Per hull its points (T, n, 3). low, high: its box (T, H, 3).
    """

    def __init__(self, hulls, motion):
        self.hulls = hulls
        self.joints, quats = hulls.body.joint_frames(motion)
        self.skin = hulls.body.vertices(motion)
        if hulls.contact == "parts":
            turns = self.turns = rot.to_matrix(quats)
            self.points = [
                np.einsum("tij,nj->tni", turns[:, j], p) + self.joints[:, j, None]
                for j, p in zip(hulls.joint, hulls.local, strict=True)
            ]
        else:
            self.points = [self.skin[:, i] for i in hulls.index]
        self.low = np.stack([p.min(axis=1) for p in self.points], axis=1)
        self.high = np.stack([p.max(axis=1) for p in self.points], axis=1)
        self._known, self._faces = {}, {}

    def shape(self, h, k):
        """Hull h at pose k: its geometry and placement."""
        if self.hulls.contact == "parts":
            j = self.hulls.joint[h]
            return self.hulls.shapes[h], self.turns[k, j], self.joints[k, j]
        if (h, k) not in self._known:
            middle = self.points[h][k].mean(axis=0)
            self._known[h, k] = _quick_hull(self.points[h][k] - middle), np.eye(3), middle
        return self._known[h, k]

    def moved(self, shift):
        """The same poses, moved (3,)."""
        out = object.__new__(Posed)
        out.hulls = self.hulls
        out.__dict__.update({k: self.__dict__[k] for k in ("turns",) if k in self.__dict__})
        out.joints, out.skin = self.joints + shift, self.skin + shift
        out.points = [p + shift for p in self.points]
        out.low, out.high = self.low + shift, self.high + shift
        out._known = {key: (s, turn, x + shift) for key, (s, turn, x) in self._known.items()}
        out._faces = {}
        return out

    def forget(self):
        self._known.clear()

    def depth(self, h, k, solid, shift=0.0):
        """EPA depth of hull h at pose k, moved by `shift` (3,), in a solid; 0 where clear."""
        points = self.points[h][k] + shift
        apart = solid.separation(points)
        if apart >= 0.0 or solid.half is None:
            return max(0.0, -apart)
        return max(0.0, -self.distance(h, k, solid, shift))

    def distance(self, h, k, solid, shift=0.0):
        """Signed distance of a hull from a solid."""
        if solid.half is None:
            return solid.separation(self.points[h][k] + shift)
        shape, turn, x = self.shape(h, k)
        place = coal.Transform3s(turn, x + shift)
        result = coal.DistanceResult()
        return coal.distance(shape, place, solid.geometry, solid.place, REQUEST, result)

    def lowest(self, h, solid):
        """How far hull h reaches down each face normal of a solid (T, m)."""
        key = h, id(solid)
        if key not in self._faces:
            self._faces[key] = (self.points[h] @ solid.normals.T).min(axis=1)
        return self._faces[key]

    def way_out(self, h, k, solid, n):
        """How far hull h has to go along n (3,) until it is out of a solid for good [m]."""
        apart = self.lowest(h, solid)[k] - solid.offsets
        if solid.near is not None:
            apart = apart[solid.near : solid.near + 1]
        if len(apart) == 1:
            along = n @ solid.normals[solid.near or 0]
            if apart[0] >= 0.0:
                return 0.0
            return -apart[0] / along if along > 1e-6 else np.inf
        along = solid.normals @ n
        # A hull on the outer side of a face that it does not approach never meets the solid.
        if ((apart >= 0.0) & (along >= -1e-12)).any():
            return 0.0
        # Clear when it is past the farthest that the solid reaches along n.
        reach = n @ solid.centre + np.abs(n @ solid.turn) @ solid.half
        r = reach - (self.points[h][k] @ n).min()
        for _ in range(ADVANCES):
            if r <= 0.0:
                return 0.0
            gap = max((apart + r * along).max(), 0.0)
            gap = gap if gap > ARRIVED else self.distance(h, k, solid, r * n)
            if gap <= ARRIVED:
                break
            r -= gap
        return max(r, 0.0)

    def meets(self, h, k, solid, shift):
        """Is hull h at pose k, moved by `shift`, in the solid (beyond the wall)?"""
        apart = self.lowest(h, solid)[k] + solid.normals @ shift - solid.offsets
        if solid.near is not None:
            return bool(apart[solid.near] < -ARRIVED)
        if apart.max() >= -ARRIVED:
            return False
        return solid.half is None or self.distance(h, k, solid, shift) < -ARRIVED


def _quick_hull(points):
    """As `coal_hull`, by coal's own qhull: skin hulls are made anew at every pose."""
    corners = coal.StdVec_Vec3s()
    corners.extend(list(points))
    return coal.Convex.convexHull(corners, True, "Qt")


def bounds(solid):
    if solid.half is None:
        return np.full(3, -np.inf), np.full(3, np.inf)
    reach = np.abs(solid.turn) @ solid.half
    return solid.centre - reach, solid.centre + reach


def near_poses(posed, h, solid, reach=0.0):
    """Poses (T,) at which the box of hull h comes within `reach` of that of the solid."""
    low, high = bounds(solid)
    return rows.every((posed.low[:, h] < high + reach) & (posed.high[:, h] > low - reach))

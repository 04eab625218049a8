"""A static as the judge of clearness sees it: coal's geometry, boxes, triangles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Mesh, Plane
from support import short_rows as rows
from support.judges.coal_shapes import coal_shape, coal_triangles
from support.judges.triangle_soup import triangle_boxes

REQUEST = coal.DistanceRequest()
#: Of a mesh the triangles this near are asked first [m]: a tree over all of them takes as long as
#: hundreds of queries.
NEAR = 0.02, 0.2


@dataclass
class JudgedStatic:
    """A static in the world.

    Attributes:
        make, place: coal's geometry, made when it is first asked for, and its pose; None for a
            plane.
        low, high: Corners of a box around it (3,) [m].
        plane: Normal (3,) and offset [m] of a plane.
        triangles: Those of a mesh (F, 3, 3), with boxes `lows`, `highs` (F, 3).
    """

    name: str
    make: Callable[[], object] | None
    place: object
    low: np.ndarray
    high: np.ndarray
    plane: tuple[np.ndarray, float] | None = None
    triangles: np.ndarray | None = None
    lows: np.ndarray | None = None
    highs: np.ndarray | None = None

    @classmethod
    def of(cls, s):
        """Of a `halfphysics.scene.scene.Static`."""
        turn, position = rot.to_matrix(s.quaternion), np.asarray(s.position, float)
        if isinstance(s.shape, Plane):
            normal = turn @ np.asarray(s.shape.normal, float)
            wide = np.full(3, np.inf)
            offset = s.shape.offset + normal @ position
            return cls(s.name, None, None, -wide, wide, plane=(normal, offset))
        if isinstance(s.shape, Mesh):
            vertices, faces = s.shape.triangles()
            vertices = np.asarray(vertices) @ turn.T + position
            low, high = vertices.min(axis=0), vertices.max(axis=0)
            faces = np.asarray(faces, dtype=np.int64)
            t = vertices[faces]
            make = cache(lambda: coal_triangles(vertices, faces))
            return cls(s.name, make, coal.Transform3s(), low, high, None, t, *triangle_boxes(t))
        shape = coal_shape(s.shape, solid=False)
        # Facets lie within the round shape: the true extent by its own box.
        shape.computeLocalAABB()
        box = shape.aabb_local
        half = np.abs(turn) @ np.maximum(np.abs(box.min_), np.abs(box.max_))
        place = coal.Transform3s(turn, position)
        return cls(s.name, lambda: shape, place, position - half, position + half)

    @property
    def shape(self):
        """coal's geometry."""
        return self.make()

    def near(self, low, high):
        """Which boxes (..., 3) meet its box."""
        if self.plane is not None:
            n, offset = self.plane
            return np.where(n > 0.0, low, high) @ n < offset
        return rows.every((low < self.high) & (high > self.low))

    def within(self, low, high):
        """The same solid, with only the triangles that meet a box."""
        if self.triangles is None:
            return self
        kept = self._meet(low, high)
        return replace(
            self, triangles=self.triangles[kept], lows=self.lows[kept], highs=self.highs[kept]
        )

    def distance(self, points, solid):
        """Distance [m] of a piece and a direction from the static to it (any, if they meet).

        points: The piece's corners (n, 3); solid: coal's geometry and place of it.
        """
        if self.plane is not None:
            return (points @ self.plane[0]).min() - self.plane[1], self.plane[0]
        low, high = points.min(axis=0), points.max(axis=0)
        for reach in NEAR:
            shape = self._around(low - reach, high + reach)
            if shape is not None:
                d, away = self._coal(solid, shape)
                if d <= reach:
                    return d, away
        return self._coal(solid, self.shape)

    def _coal(self, solid, shape):
        """Distance by coal and a direction."""
        result = coal.DistanceResult()
        d = coal.distance(*solid, shape, self.place, REQUEST, result)
        return d, np.array(result.getNearestPoint1()) - np.array(result.getNearestPoint2())

    def _around(self, low, high):
        """coal's geometry of a mesh's triangles that meet a box; None if none does."""
        kept = [] if self.triangles is None else np.flatnonzero(self._meet(low, high))
        if not len(kept):
            return None
        corners = self.triangles[kept].reshape(-1, 3)
        return coal_triangles(corners, np.arange(len(corners)).reshape(-1, 3))

    def _meet(self, low, high):
        """Which triangles' boxes meet a box (F,): numpy is slow along short rows."""
        out = np.ones(len(self.lows), dtype=bool)
        for k in range(3):
            out &= (self.lows[:, k] <= high[k]) & (self.highs[:, k] >= low[k])
        return out

    def behind(self, points, normals, far=0.0):
        """Whether planes of these normals prove that it is not within `far` of points (n, 3).

        Of a mesh every triangle has to be behind one of the planes, or away from the points' box.
        """
        if self.plane is not None:
            return (points @ self.plane[0]).min() - self.plane[1] > far
        left = None
        if self.triangles is not None:
            low, high = points.min(axis=0) - far, points.max(axis=0) + far
            left = self.triangles[self._meet(low, high)]
            if not len(left):
                return True
        for n in normals:
            bottom = (points @ n).min() - far
            if left is None:
                if self._highest(n) < bottom:
                    return True
                continue
            left = left[rows.largest(left @ n) >= bottom]
            if not len(left):
                return True
        return False

    def _highest(self, n):
        """A convex primitive's largest extent along n (an upper bound by its hull)."""
        turn, x = self.place.getRotation(), self.place.getTranslation()
        local, shape = turn.T @ n, self.shape
        if isinstance(shape, coal.Box):
            reach = np.abs(local) @ shape.halfSide
        elif isinstance(shape, coal.Sphere):
            reach = shape.radius
        elif isinstance(shape, coal.Capsule):
            reach = shape.radius + shape.halfLength * abs(local[2])
        else:
            reach = shape.radius * np.hypot(local[0], local[1]) + shape.halfLength * abs(local[2])
        return reach + n @ x

"""Queries of the skin's judge (`skin_judge`) on items: distances, insides, and separation.

Primitives by their formulas, meshes by `triangle_soup`; the undecided cases by `coal`.
All points are in the item's own frame.
"""

from __future__ import annotations

import coal
import numpy as np

from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from support import short_rows as rows
from support.judges.coal_shapes import coal_shape
from support.judges.triangle_soup import Soup

#: Triangle edges shorter than this are one point [m]: seams of meshes.
SAME_PLACE = 1e-9
#: Up to this many pairs, single queries are quicker than another axis.
FEW = 8


def signed_distance(shape, points):
    """Distances (n,) [m] of points (n, 3) from a primitive, negative inside."""
    if isinstance(shape, Plane):
        return points @ np.asarray(shape.normal) - shape.offset
    if isinstance(shape, Sphere):
        return rows.length(points) - shape.radius
    if isinstance(shape, Capsule):
        above = np.abs(points[:, 2]) - 0.5 * shape.length
        side = np.hypot(points[:, 0], points[:, 1])
        return np.hypot(side, np.maximum(above, 0.0)) - shape.radius
    if isinstance(shape, Box):
        beside = np.abs(points) - 0.5 * np.asarray(shape.size)
    else:
        side = np.hypot(points[:, 0], points[:, 1]) - shape.radius
        beside = np.stack([side, np.abs(points[:, 2]) - 0.5 * shape.length], axis=1)
    outside = rows.length(np.maximum(beside, 0.0))
    return outside + np.minimum(rows.largest(beside), 0.0)


def _closest(shape, points):
    """The points (n, 3) of a primitive that are closest to points outside it."""
    if isinstance(shape, Box):
        half = 0.5 * np.asarray(shape.size)
        return np.clip(points, -half, half)
    core = np.zeros_like(points)
    if isinstance(shape, Capsule):
        core[:, 2] = np.clip(points[:, 2], -0.5 * shape.length, 0.5 * shape.length)
    arm = points - core
    if isinstance(shape, Cylinder):
        arm[:, 2] = 0.0
    size = rows.length(arm)[:, None]
    arm *= np.minimum(1.0, shape.radius / np.maximum(size, 1e-12))
    if isinstance(shape, Cylinder):
        core[:, 2] = np.clip(points[:, 2], -0.5 * shape.length, 0.5 * shape.length)
    return core + arm


def _support(shape, n):
    """A primitive's extent along directions n (k, 3) of any length."""
    if isinstance(shape, Box):
        return np.abs(n) @ (0.5 * np.asarray(shape.size))
    size = rows.length(n)
    if isinstance(shape, Sphere):
        return shape.radius * size
    if isinstance(shape, Capsule):
        return shape.radius * size + 0.5 * shape.length * np.abs(n[:, 2])
    return shape.radius * np.hypot(n[:, 0], n[:, 1]) + 0.5 * shape.length * np.abs(n[:, 2])


class Primitive:
    """A plane, box, ball, capsule or cylinder."""

    def __init__(self, shape):
        self.shape, self.solid = shape, True
        self.plane = isinstance(shape, Plane)
        self.middle = np.zeros((1, 3))
        wide = np.full(3, np.inf)
        if not self.plane:
            wide = np.array([_support(shape, axis[None])[0] for axis in np.eye(3)])
        self.low, self.high = -wide, wide
        self.coal = coal_shape(shape, solid=True)

    def smallest(self, points, most):
        """The smallest distance of the points (n, 3) and its index; (inf, -1) beyond `most`."""
        d = signed_distance(self.shape, points)
        i = int(d.argmin())
        return (float(d[i]), i) if d[i] <= most else (np.inf, -1)

    def depths(self, points):
        """Depths of points (n, 3), (n,) [m]: 0 outside."""
        return np.maximum(-signed_distance(self.shape, points), 0.0)

    def clear_of(self, points):
        """Whether all of the points are outside."""
        return bool((signed_distance(self.shape, points) > 0.0).all())

    def met_by(self, corners):
        """Which (k,) hulls of `corners` (k, m, 3) meet it, by any of several tests."""
        k, m = corners.shape[:2]
        d = signed_distance(self.shape, corners.reshape(-1, 3)).reshape(k, m)
        if self.plane:
            return np.flatnonzero(~rows.every(d > 0.0))
        first = corners[:, :1]
        apart = d[:, 0] > rows.largest(rows.length(corners - first))
        left = np.flatnonzero(~apart)
        for j in range(m):
            p = corners[left]
            n = p[:, j] - _closest(self.shape, p[:, j])
            low = rows.smallest(np.einsum("kmi,ki->km", p, n))
            left = left[~(low > _support(self.shape, n))]
        here = coal.Transform3s()
        return np.array([i for i in left if _collide(hull_of(corners[i]), self.coal, here)], int)


class Surface:
    """The triangles of a mesh; `solid` where they close."""

    def __init__(self, vertices, faces, solid):
        vertices, faces = np.asarray(vertices, float), np.asarray(faces, dtype=np.int64)
        self.solid, self.plane = solid, False
        corners = vertices[faces]
        area = rows.length(rows.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        self.soup = Soup(corners[area > 0.0])
        self.low, self.high = self.soup.low, self.soup.high
        self.middle = corners[:, 0]
        self.coal = coal.BVHModelOBBRSS()
        self.coal.beginModel(len(faces), len(vertices))
        self.coal.addVertices(vertices)
        self.coal.addTriangles(faces)
        self.coal.endModel()

    def smallest(self, points, most):
        """As in `Primitive`; distances from the surface, positive inside too."""
        return self.soup.smallest(points, most)

    def depths(self, points):
        """Depths of points (n, 3), (n,) [m]: 0 outside, and for open pieces."""
        out = np.zeros(len(points))
        if self.solid:
            near = np.flatnonzero(rows.every((points > self.low) & (points < self.high)))
            inside = near[self.soup.winding(points[near]) > 0.5]
            out[inside] = self.soup.distances(points[inside])
        return out

    def met_by(self, corners):
        """As in `Primitive`."""
        item, which = self.soup.near(rows.smallest(corners, 1), rows.largest(corners, 1))
        together = _not_apart(corners[item], self.soup.triangles[which])
        found = set()
        for k in together:
            i = int(item[k])
            if i not in found and _collide(
                hull_of(corners[i]), hull_of(self.soup.triangles[which[k]]), coal.Transform3s()
            ):
                found.add(i)
        return np.array(sorted(found), dtype=int)


def _not_apart(a, b):
    """Which of k hulls of a (k, m, 3) and triangles b (k, 3, 3) no axis of theirs separates."""
    left = np.arange(len(a))
    sides = b[:, [1, 2, 0]] - b
    bones = a[:, [1, 2, 0]] - a[:, :3]
    ways = a[:, 3:] - a[:, : a.shape[1] - 3]

    def axes():
        yield lambda i: rows.cross(sides[i, 0], sides[i, 1])
        yield lambda i: rows.cross(bones[i, 0], bones[i, 1])
        if a.shape[1] > 3:
            yield lambda i: rows.cross(a[i, 4] - a[i, 3], a[i, 5] - a[i, 3])
        for edges in (bones, ways):
            for j in range(edges.shape[1]):
                for k in range(3):
                    yield lambda i, e=edges, j=j, k=k: rows.cross(e[i, j], sides[i, k])

    for axis in axes():
        if len(left) <= FEW:
            break
        n = axis(left)
        p, q = np.einsum("kmi,ki->km", a[left], n), np.einsum("kmi,ki->km", b[left], n)
        apart = rows.smallest(p) > rows.largest(q)
        apart |= rows.largest(p) < rows.smallest(q)
        left = left[~apart]
    return left


def hull_of(points):
    """A coal hull of 3 or 6 points; so few are all checked, for any faces."""
    if len(points) == 3:
        return coal.TriangleP(*points)
    corners, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for p in points:
        corners.append(p)
    ends, sides = ((0, 1, 2), (3, 4, 5)), ((0, 1, 4), (1, 2, 5), (2, 0, 3))
    for f in (*ends, *sides):
        faces.append(coal.Triangle(*f))
    return coal.Convex(corners, faces)


def _collide(a, b, place):
    return coal.collide(a, place, b, place, coal.CollisionRequest(), coal.CollisionResult()) > 0


def obstacles_of(shape):
    """A shape as obstacles: meshes by their closed and open pieces."""
    if not isinstance(shape, Mesh):
        return [Primitive(shape)]
    vertices, faces = _merged(np.asarray(shape.vertices), np.asarray(shape.faces))
    closed = _closed(vertices, faces)
    pieces = [(faces[closed], True), (faces[~closed], False)]
    return [Surface(vertices, f, solid) for f, solid in pieces if len(f)]


def _merged(vertices, faces):
    rounded = np.round(vertices / SAME_PLACE).astype(np.int64)
    _, first, place = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    faces = place.reshape(-1)[faces]
    real = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return vertices[first], faces[real]


def _closed(vertices, faces):
    """Which triangles (F,) belong to closed pieces: every edge is used as often either way."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(vertices)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(n, n)).tocsr()
    rim = (abs(graph - graph.T)).tocoo()
    piece = connected_components(graph, directed=False)[1]
    open_ = np.zeros(piece.max() + 1, dtype=bool)
    open_[piece[rim.row[rim.data > 0.5]]] = True
    return ~open_[piece[faces[:, 0]]]

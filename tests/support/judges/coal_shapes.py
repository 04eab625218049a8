"""Shapes as `coal` takes them: hulls of points, primitives, triangles."""

from __future__ import annotations

import coal
import numpy as np

from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere


def _corners(points):
    out = coal.StdVec_Vec3s()
    out.extend(list(np.asarray(points, dtype=float)))
    return out


def coal_hull(points):
    """The convex hull of points (n, 3)."""
    return coal.Convex.convexHull(_corners(points), True, "Qt")


#: Triangles of a height under this are left out: coal takes any ball for one inside them [m].
FLAT = 1e-9


def _with_area(vertices, faces):
    """The triangles that are not flat: their edges are those of their neighbours."""
    corners = vertices[faces]
    edges = corners - np.roll(corners, 1, axis=1)
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    return faces[area > FLAT * longest]


def coal_shape(shape, solid):
    """A coal geometry: `solid` meshes are their hulls, others triangles."""
    if isinstance(shape, Plane):
        return coal.Halfspace(np.array(shape.normal, dtype=float), float(shape.offset))
    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    if isinstance(shape, Capsule):
        return coal.Capsule(shape.radius, shape.length)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if solid:
        return coal_hull(np.asarray(shape.vertices))
    vertices = np.asarray(shape.vertices, dtype=float)
    return coal_triangles(vertices, _with_area(vertices, np.asarray(shape.faces)))


def coal_triangles(vertices, faces):
    """A tree over triangles of vertices (n, 3)."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(faces), len(vertices))
    model.addVertices(vertices)
    model.addTriangles(np.asarray(faces, dtype=np.int64))
    model.endModel()
    return model

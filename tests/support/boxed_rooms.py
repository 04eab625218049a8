"""Rooms and other static meshes made of boxes, with z up, and the same with y up."""

from __future__ import annotations

import numpy as np

from halfphysics.geometry.mesh import Mesh

#: Corners of a box from two bits each, and its sides as pairs of triangles.
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SIDES = {
    "-x": (0, 1, 3, 2), "+x": (4, 6, 7, 5), "-y": (0, 4, 5, 1),
    "+y": (2, 3, 7, 6), "-z": (0, 2, 6, 4), "+z": (1, 5, 7, 3),
}  # fmt: skip


def box(low, high, sides=tuple(SIDES)):
    faces = [t for s in sides for a, b, c, d in [SIDES[s]] for t in ((a, b, c), (a, c, d))]
    low, high = np.asarray(low, float), np.asarray(high, float)
    return low + CORNERS * (high - low), np.array(faces)


def room(low, high, sides=tuple(SIDES)):
    """Sides of a room in z-up metres with a table and a cupboard in it."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    table, cupboard = low + np.array((1.0, 1.0, 0.7)), low + np.array((0.1, 0.1, 0.0))
    parts = [
        box(low, high, sides),
        box(table, table + np.array((1.2, 0.8, 0.05))),
        box(cupboard, cupboard + np.array((0.6, 1.0, 1.9))),
    ]
    starts = np.cumsum([0, *(len(v) for v, _ in parts)])[:-1]
    faces = [f + start for (_, f), start in zip(parts, starts, strict=True)]
    return Mesh(np.vstack([v for v, _ in parts]), np.vstack(faces))


def y_up(mesh):
    """The same in a file with y up: (x, y, z) as (x, z, -y)."""
    x, y, z = mesh.vertices.T
    return Mesh(np.stack([x, z, -y], axis=1), mesh.faces)


OPEN = ("-z", "-x", "-y")  # a scan: floor and two walls
ROOMS = {
    "closed, about zero": room((-3, -2, 0), (3, 2, 2.6)),
    "closed, from a corner": room((0, 0, 0), (6, 4, 2.6)),
    "open, about zero": room((-3, -2, 0), (3, 2, 2.6), OPEN),
    "open, somewhere": room((1.3, -7.1, -0.6), (6.3, -3.1, 1.8), ("-z", "-x", "+x")),
    "corridor": room((0, 0, 0), (12, 1.6, 2.5)),
    "narrow corridor about zero": room((-6, -0.8, 0), (6, 0.8, 2.5)),
    "tall hall": room((-5, -4, 0), (5, 4, 12)),
    "basement": room((0, 0, -3), (4, 3, 0)),
    "a floor alone": room((-4, -3, 0), (4, 3, 2.0), ("-z",)),
    "a wall": Mesh(*box((-2, -0.1, 0), (2, 0.1, 2.5))),
    "an open wall": Mesh(*box((-2, 0, 0), (2, 0.2, 2.5), ("-x", "+x", "-y", "+y"))),
    "ground of a town": Mesh(*box((-300, -300, 0), (300, 300, 40))),
}

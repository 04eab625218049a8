"""Thin-walled solids of revolution: pipes, cups, wine glasses, with their distances by formula."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from halfphysics.geometry.shapes import Mesh

#: Outline of a wine glass from the middle of its foot to the rim, (radius, height) [m].
WINE_GLASS = np.array([(0, 0), (34, 0), (34, 3), (6, 9), (4, 20), (4, 85), (12, 92), (30, 105),
                       (38, 125), (40, 145), (37, 170), (33, 200)]) / 1000.0  # fmt: skip


@dataclass(frozen=True, eq=False)
class Turned:
    """A solid of revolution about z: its outline (n, 2) as (radius, height), closed by the axis.

    The outline goes counter-clockwise in (radius, height): from the axis below to the axis above.
    """

    outline: np.ndarray

    def mesh(self, count):
        """Triangles, `count` sections around; flat by radius (1 - cos(pi / count))."""
        vertices, faces, rings = [], [], []
        angle = 2.0 * np.pi * np.arange(count) / count
        for r, z in self.outline:
            many = count if r > 0.0 else 1
            rings.append(len(vertices) + np.arange(count) % many)
            a = angle[:many]
            vertices += np.column_stack([r * np.cos(a), r * np.sin(a), np.full(many, z)]).tolist()
        for low, high in itertools.pairwise(rings):
            a, b, c, d = low, np.roll(low, -1), high, np.roll(high, -1)
            for corners in ((a, b, d), (a, d, c)):
                f = np.stack(corners, axis=1)
                faces.append(f[[len(set(row)) == 3 for row in f.tolist()]])
        return Mesh(np.array(vertices), np.concatenate(faces))

    def signed_distance(self, points):
        """Signed distances of points (n, 3) from the smooth solid [m], negative inside."""
        p = np.stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]], axis=1)
        a, b = self.outline[:-1], self.outline[1:]
        distance, inside = np.full(len(p), np.inf), np.zeros(len(p), dtype=bool)
        for start, end in zip(a, b, strict=True):
            way = end - start
            share = np.clip(((p - start) @ way) / (way @ way), 0.0, 1.0)
            distance = np.minimum(
                distance, np.linalg.norm(p - start - share[:, None] * way, axis=1)
            )
            # A ray outwards crosses the outline once more where it goes up than down, or less.
            between = (start[1] > p[:, 1]) != (end[1] > p[:, 1])
            if way[1] != 0.0:
                at = start[0] + (p[:, 1] - start[1]) / way[1] * way[0]
                inside ^= between & (p[:, 0] < at)
        return np.where(inside, -distance, distance)


def cup(radius=0.035, height=0.08, wall=0.0025):
    """A cup, open above, its bottom as thick as its wall."""
    inner = radius - wall
    return Turned(np.array([(0, 0), (radius, 0), (radius, height), (inner, height), (inner, wall),
                            (0, wall)]))  # fmt: skip


def wine_glass(wall=0.0025):
    """A foot, a stem and a bowl of this wall."""
    bowl = [(r - wall, z) for r, z in WINE_GLASS[:6:-1]]
    return Turned(np.array([*WINE_GLASS, *bowl, (0.0, WINE_GLASS[6, 1] + wall)]))


def pipe(radius, wall, height, count):
    """A pipe of straight sections, open at both ends, and pieces of `span` of these each."""
    inner = radius - wall
    angle = 2.0 * np.pi * np.arange(count) / count
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    loops = [(radius, 0.0), (radius, height), (inner, height), (inner, 0.0)]
    vertices = np.concatenate([np.column_stack([r * ring, np.full(count, z)]) for r, z in loops])
    i = np.arange(count)
    j = (i + 1) % count
    faces = []
    for k in range(4):
        a, b = k * count, (k + 1) % 4 * count
        faces += [np.stack([a + i, a + j, b + j], axis=1), np.stack([a + i, b + j, b + i], axis=1)]
    mesh = Mesh(vertices, np.concatenate(faces))

    def pieces(span):
        out = []
        for first in range(0, count, span):
            of = np.arange(first, first + span + 1) % count
            corners = vertices.reshape(4, count, 3)[:, of].reshape(-1, 3)
            n = np.arange(len(corners))
            out.append(Mesh(corners, np.stack([n, np.roll(n, 1), np.roll(n, 2)], axis=1)).hull)
        return out

    return mesh, pieces

"""Meshes of starts in penetration: boxes, and the one connected surface around many of them."""

from __future__ import annotations

import numpy as np
import trimesh

from support.rooms import PIECES, SCALE


def box_mesh(low, high):
    """A closed box between two corners."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    mesh = trimesh.creation.box(high - low)
    return mesh.apply_translation(0.5 * (low + high))


def union_mesh(boxes):
    """The surface of the union of axis-parallel boxes [(low, high), ...].

    Space is cut along all their sides; the surface is the walls between cells that are in some
    box and cells that are in none. Corners are shared: boxes that touch are one piece.
    """
    lows, highs = (np.array(x, float) for x in zip(*boxes, strict=True))
    grid = [np.unique(np.round(np.concatenate([lows[:, a], highs[:, a]]), 9)) for a in range(3)]
    # One empty layer around all boxes.
    full = np.zeros([len(g) + 1 for g in grid], dtype=bool)
    for low, high in zip(np.round(lows, 9), np.round(highs, 9), strict=True):
        first = [np.searchsorted(g, x) for g, x in zip(grid, low, strict=True)]
        last = [np.searchsorted(g, x) for g, x in zip(grid, high, strict=True)]
        full[tuple(slice(i + 1, j + 1) for i, j in zip(first, last, strict=True))] = True
    corners, faces = {}, []

    def corner(index):
        return corners.setdefault(tuple(index), len(corners))

    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        step = np.diff(full.astype(np.int8), axis=axis)
        for index in np.argwhere(step != 0):
            out = step[tuple(index)] < 0  # from full to empty: the normal is +axis
            at = [0, 0, 0]
            at[axis] = index[axis]
            ring = []
            for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                at[b], at[c] = index[b] - 1 + i, index[c] - 1 + j
                ring.append(corner(at))
            ring = ring if out else ring[::-1]
            faces += [[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]]
    vertices = np.array([[grid[a][i[a]] for a in range(3)] for i in corners])
    return trimesh.Trimesh(vertices, faces, process=False)


def sheet_mesh(x, y):
    """An open rectangle about the origin, seen from +z: two triangles."""
    corners = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def furniture(mesh, folder, z, rng, pieces=3):
    """The same mesh with real pieces of furniture, standing at height z, 2.3 to 3.2 m off."""
    out = [mesh]
    for _ in range(pieces):
        file, height = PIECES[rng.integers(len(PIECES))]
        piece = trimesh.load(folder / f"{file}.obj", force="mesh", process=False)
        piece = trimesh.Trimesh(SCALE * piece.vertices[:, [0, 2, 1]] * (1, -1, 1), piece.faces,
                                process=False)  # fmt: skip
        angle, away = rng.uniform(-np.pi, np.pi), rng.uniform(2.3, 3.2)
        piece.apply_translation([away * np.cos(angle), away * np.sin(angle), z + height])
        out.append(piece)
    return trimesh.util.concatenate(out)


def finely(mesh, times):
    """Every triangle cut in four, several times; not beyond 60,000."""
    for _ in range(times):
        if 4 * len(mesh.faces) > 60_000:
            break
        mesh = mesh.subdivide()
    return mesh

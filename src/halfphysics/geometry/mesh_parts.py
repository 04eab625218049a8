"""A mesh divided into connected solids, each closed, and lone flat sheets, each a thin plate.

A modelled box has a flap of two triangles, a wall has marks that float before it: sheets that
enclose nothing. Cut along with the rest they would ruin it (coacd wants a closed manifold), so they
become plates as thin as pieces may stick out. The lining of a doorway is a surface with a hole that
bends around three sides: a fan about the hole's middle would fill the doorway, and the triangles of
the least area (Barequet and Sharir 1995) close it where the wall is.
"""

from __future__ import annotations

import contextlib

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.geometry import mesh_queries
from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.integer]

#: More solids than this are cut as one.
MOST_SOLIDS = 64
#: A sheet is flat where it leaves its plane by at most this share of its longest extent.
_FLAT = 1e-4
#: A flat sheet is convex where its outline's hull has at most this share more area.
_CONVEX = 1e-3
#: How far from whole the winding number of all else may be at a lone sheet: in the side of a box
#: that was not joined to the others it is 0.5.
_ALONE = 0.2
#: Edges of the largest hole that is closed by the least area: time grows with the third power.
_MOST_EDGES = 64
#: A fan is kept unless its area is larger by more than this share.
_LESS = 1e-6


def solids_of(mesh: Mesh, thickness: float) -> list[Mesh]:
    """Closed solids of a mesh, holes bridged; the mesh itself where they cannot be told apart.

    That is where one of them is a hollow, or there are more than `MOST_SOLIDS`.

    Args:
        mesh: Outward triangles, closed or not.
        thickness: Of the plates that stand for flat sheets [m].
    """
    solids: list[Mesh] = []
    for part, flat in _divided(mesh):
        solids += _plates(part, thickness) if flat else [part]
    return [mesh] if len(solids) > MOST_SOLIDS else solids


def bridged(mesh: Mesh) -> Mesh:
    """The same surface with the holes of its solids closed, as `solids_of` closes them."""
    parts = [part for part, _ in _divided(mesh)]
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]
    vertices = np.concatenate([part.vertices for part in parts])
    return mesh if parts[0] is mesh else Mesh(vertices, np.concatenate(faces))


def _divided(mesh: Mesh) -> list[tuple[Mesh, bool]]:
    """Parts with their holes closed, and whether each is a lone flat sheet, which is as it was;
    the mesh alone where they cannot be told apart."""
    whole = [(mesh, False)]
    faces = mesh.faces
    of_face = _sheets(faces)
    parts = [Mesh(mesh.vertices, faces[of_face == k]) for k in np.unique(of_face)]
    if mesh.closed and not all(part.closed for part in parts):
        # Solids that share all edges of a face: divide connected parts instead of sheets.
        links = np.concatenate([faces[:, :2], faces[:, 1:]])
        of_face = mesh_queries.components(len(mesh.vertices), links)[faces[:, 0]]
        parts = [Mesh(mesh.vertices, faces[of_face == k]) for k in np.unique(of_face)]
    if len(parts) > MOST_SOLIDS:
        return whole
    flat = [not part.closed and _is_flat(part) for part in parts]
    if all(flat):
        return whole
    for k, part in enumerate(parts):
        if flat[k] and not _is_alone(part, [other for other in parts if other is not part]):
            return whole
    made = [(part if f else _bridged(part), f) for part, f in zip(parts, flat, strict=True)]
    hollow = any(not f and part.closed and signed_volume(part) <= 0.0 for part, f in made)
    return whole if hollow else made


def signed_volume(mesh: Mesh) -> float:
    """What a closed mesh encloses [m^3], negative where it is inside out."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces] - mesh.vertices[0], 1, 0)
    return float(np.einsum("fi,fi->", a, np.cross(b, c))) / 6.0


def _sheets(faces: Indices) -> NDArray[np.int32]:
    """Label (F,) of the surface every face is in: solids that share a corner or an edge are two."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, which, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    order = np.argsort(which, kind="stable")
    twice = np.repeat(count == 2, count)
    pairs = (order % len(faces))[twice].reshape(-1, 2)
    return mesh_queries.components(len(faces), pairs)


def _plane(sheet: Mesh) -> tuple[Array, Array]:
    """Unit axes (3, 3) of a sheet's vertices, the normal last; their extents (3,) [m]."""
    from_middle = sheet.vertices - sheet.vertices.mean(axis=0)
    axes = np.linalg.eigh(from_middle.T @ from_middle)[1].T[::-1]
    return axes, np.ptp(from_middle @ axes.T, axis=0)


def _is_flat(sheet: Mesh) -> bool:
    extents = _plane(sheet)[1]
    return bool(extents[2] <= _FLAT * extents.max() and extents[1] > _FLAT * extents.max())


def _is_alone(sheet: Mesh, others: list[Mesh]) -> bool:
    """Whether a sheet closes no hole of the others: their winding number there is whole."""
    largest = int(np.argmax(_areas(sheet.vertices, sheet.faces)))
    middle = sheet.vertices[sheet.faces[largest]].mean(axis=0)[None]
    winding = sum(float(other.query.winding(middle)[0]) for other in others)
    return abs(winding - round(winding)) <= _ALONE


def _plates(sheet: Mesh, thickness: float) -> list[Mesh]:
    """A flat sheet with a thickness [m]: one plate where it is convex, else one per triangle."""
    from scipy.spatial import ConvexHull

    axes, _ = _plane(sheet)
    # In two dimensions a hull's "volume" is its area.
    hull = float(ConvexHull(sheet.vertices @ axes[:2].T).volume)
    one = hull <= (1.0 + _CONVEX) * float(_areas(sheet.vertices, sheet.faces).sum())
    outlines = [sheet.vertices] if one else list(sheet.vertices[sheet.faces])
    half = 0.5 * thickness * axes[2]
    plates = []
    for outline in outlines:
        points = np.concatenate([outline - half, outline + half])
        every = np.arange(len(points), dtype=np.int32)
        named = np.stack([every, np.roll(every, 1), np.roll(every, 2)], axis=1)
        with contextlib.suppress(InputError):  # a sliver: its neighbours cover it
            plates.append(Mesh(points, named).hull)
    return plates


def _bridged(part: Mesh) -> Mesh:
    """An open part with its holes closed: by fans, or with less area where that is possible."""
    if part.closed:
        return part
    n = len(part.vertices)
    rim = mesh_queries.boundary_edges(part.faces, n)
    rims = mesh_queries.components(n, rim)[rim[:, 0]]
    vertices, faces = [part.vertices], [part.faces]
    for k, label in enumerate(np.unique(rims)):
        edges = rim[rims == label]
        every = np.concatenate([part.vertices, part.vertices[edges].mean(axis=(0, 1))[None]])
        vertices.append(every[n:])
        fan = np.column_stack([edges[:, ::-1], np.full(len(edges), n)])
        area = float(_areas(every, fan).sum())
        fan[:, 2] += k
        loop = _loop(edges)
        if loop is not None and len(loop) <= _MOST_EDGES:
            least, cap = _least_area(part.vertices[loop])
            if (1.0 + _LESS) * least < area:
                fan = loop[cap]
        faces.append(fan.astype(np.int32))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def _loop(edges: Indices) -> Indices | None:
    """Vertices (k,) of directed edges (k, 2) in order, if they are one simple loop."""
    after = dict(edges.tolist())
    loop = [int(edges[0, 0])]
    while len(loop) <= len(edges) and after.get(loop[-1], loop[0]) != loop[0]:
        loop.append(after[loop[-1]])
    simple = len(after) == len(loop) == len(edges)
    return np.array(loop) if simple else None


def _least_area(points: Array) -> tuple[float, Indices]:
    """The triangles (k - 2, 3) between the points (k, 3) of a loop with the least total area.

    The polygon i..k is a triangle i, j, k and the polygons i..j and j..k: from the short ones to
    the whole loop. The triangles run against the loop; of several equal ones the first.
    """
    count = len(points)
    best = np.zeros((count, count))
    split = np.zeros((count, count), dtype=np.int64)
    for length in range(2, count):
        for i in range(count - length):
            k = i + length
            a, b, c = points[i], points[i + 1 : k], points[k]
            area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
            total = best[i, i + 1 : k] + best[i + 1 : k, k] + area
            chosen = int(np.argmin(total))
            best[i, k], split[i, k] = total[chosen], i + 1 + chosen
    triangles, todo = [], [(0, count - 1)]
    while todo:
        i, k = todo.pop()
        if k - i >= 2:
            j = int(split[i, k])
            triangles.append((k, j, i))
            todo += [(i, j), (j, k)]
    return float(best[0, count - 1]), np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _areas(vertices: Array, faces: Indices) -> Array:
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    result: Array = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return result

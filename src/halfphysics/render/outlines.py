"""Lines in pictures: edges, so that white walls and glass stand out, and squares on the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.creases import folds
from halfphysics.render.look import EDGE_WIDTH, GRID, Color, Theme
from halfphysics.render.rasterizer import Camera, Surface

Array = NDArray[np.float64]

# Edges that bend by more are drawn [degrees].
_SHARP = 40.0
# An edge is drawn outside of the faces beside it, by this along the normal of each [m].
_LIFT = 0.001
# More edges are not drawn: a scan has no edges, only noise.
_MOST = 3000
# A line is drawn in pieces of at most this length [pixels], and in at most so many: the renderer
# visits every sample of a triangle's bounding box.
_PIECE, _PIECES = 48.0, 60
# Pieces outside of a picture that is this many times wider than high are left out.
_WIDEST = 4.0
# An edge is drawn nearer than the faces beside it, by this share of its distance.
_NEARER = 0.002


def edges(surface: Surface) -> Array:
    """Sharp and open edges of a mesh (E, 2, 3) [m]; none of a mesh that has very many.

    They lie a little outside of the surface, so that it does not hide them.
    """
    found = folds(surface.vertices, surface.faces)
    sharp = found.bend < np.cos(np.radians(_SHARP))
    pairs = found.pairs[sharp]
    out = _LIFT * (found.normals[pairs[:, 0]] + found.normals[pairs[:, 1]])
    lifted = found.points[found.sides[sharp]] + out[:, None]
    segments: Array = np.concatenate([lifted, found.points[found.lone]])
    return segments if len(segments) <= _MOST else np.zeros((0, 2, 3))


@dataclass(frozen=True, kw_only=True, eq=False)
class Border:
    """Sharp and open edges of a mesh whose vertices move.

    Attributes:
        sides: Vertices at the ends of each edge (E, 2).
        out: By how much an edge is drawn outside of the surface (E, 3) [m].
    """

    sides: NDArray[np.int64]
    out: Array

    def at(self, vertices: Array) -> Array:
        """The edges (E, 2, 3) [m], where the vertices (V, 3) are."""
        result: Array = vertices[self.sides] + self.out[:, None]
        return result


def border(surface: Surface) -> Border:
    """As `edges`, for a mesh whose vertices move; its vertices are at different places."""
    from scipy.spatial import cKDTree

    found = folds(surface.vertices, surface.faces)
    sharp = found.bend < np.cos(np.radians(_SHARP))
    pairs = found.pairs[sharp]
    out = _LIFT * (found.normals[pairs[:, 0]] + found.normals[pairs[:, 1]])
    sides = np.concatenate([found.sides[sharp], found.lone])
    if len(sides) > _MOST:
        sides, out = sides[:0], out[:0]
    # Folds have their own order of points.
    _, own = cKDTree(surface.vertices).query(found.points)
    lift = np.concatenate([out, np.zeros((len(sides) - len(out), 3))])
    return Border(sides=np.asarray(own, dtype=np.int64)[sides], out=lift)


def shade(color: Color, theme: Theme) -> Color:
    """Colour of the edges of a thing of a colour."""
    r, g, b = (min(theme.edge * c, 1.0) for c in color)
    return r, g, b


def squares(middle: Array, reach: float, z: float) -> Array:
    """Lines of squares on a level ground, at whole multiples of `GRID` (L, 2, 3) [m].

    Args:
        middle: Point around which they lie; only x and y count.
        reach: They end at this distance from it [m].
        z: Height of the ground [m].
    """
    lines = []
    for axis in (0, 1):
        low, high = middle[axis] - reach, middle[axis] + reach
        for at in GRID * np.arange(np.ceil(low / GRID), np.floor(high / GRID) + 1):
            half = np.sqrt(max(reach**2 - (at - middle[axis]) ** 2, 0.0))
            ends = np.full((2, 3), z)
            ends[:, axis] = at
            ends[:, 1 - axis] = middle[1 - axis] + np.array([-half, half])
            lines.append(ends)
    return np.array(lines).reshape(-1, 2, 3)


def _short(local: Array, most: float) -> Array:
    """The same lines in pieces of equal length in the picture, in camera space (P, 2, 3) [m].

    Args:
        local: Lines before the camera (E, 2, 3) [m].
        most: Largest length of a piece, at depth 1 m.
    """
    flat = local[..., :2] / local[..., 2:]
    length = np.linalg.norm(flat[:, 1] - flat[:, 0], axis=1)
    count = np.clip(np.ceil(length / most), 1, _PIECES).astype(int)
    line = np.repeat(np.arange(len(local)), count)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    step = np.arange(len(line)) - first[line]
    start, end = local[line, 0], local[line, 1]
    ends = []
    for k in (step, step + 1):
        share = (k / count[line])[:, None]
        # From a share of the length in the picture to one in space.
        share = share * start[:, 2:] / (end[:, 2:] + share * (start[:, 2:] - end[:, 2:]))
        ends.append(start + share * (end - start))
    return np.stack(ends, axis=1)


def drawn(
    segments: Array,
    color: Color,
    camera: Camera,
    height: int,
    *,
    width: float = EDGE_WIDTH,
    fade: tuple[float, float] | None = None,
) -> Surface | None:
    """Lines as thin strips that face the camera; None: no line is in front of it.

    Args:
        segments: Lines, world frame (E, 2, 3) [m].
        color: Their colour.
        camera: The camera.
        height: Height of the picture [pixels].
        width: Of the lines [pixels].
        fade: As in `Surface`.
    """
    axes = camera.axes()
    local = (segments - camera.position) @ axes.T
    # Cut at the near plane.
    depth = local[..., 2]
    seen = depth.max(axis=1) > 2.0 * camera.near
    local = local[seen]
    if not len(local):
        return None
    for end in (0, 1):
        behind = local[:, end, 2] < 2.0 * camera.near
        a, b = local[behind, end], local[behind, 1 - end]
        share = (2.0 * camera.near - a[:, 2]) / (b[:, 2] - a[:, 2])
        local[behind, end] = a + share[:, None] * (b - a)
    tangent = float(np.tan(np.radians(0.5 * camera.fov)))
    local = _short(local, 2.0 * _PIECE * tangent / height)
    flat = local[..., :2] / local[..., 2:]
    limit = tangent * np.array([_WIDEST, 1.1])
    outside = np.logical_or(np.all(flat > limit, axis=1), np.all(flat < -limit, axis=1))
    seen = ~np.any(outside, axis=1)
    flat, local = flat[seen], local[seen]
    if not len(local):
        return None
    along = flat[:, 1] - flat[:, 0]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)[:, None]
    half = width * tangent / height
    near = (1.0 - _NEARER) * local[..., 2:]
    sides = [np.concatenate([(flat + s * half * across) * near, near], axis=2) for s in (-1, 1)]
    corners = np.concatenate([sides[0], sides[1][:, ::-1]], axis=1).reshape(-1, 3)
    first = 4 * np.arange(len(local))[:, None]
    faces = np.concatenate([first + np.array(side) for side in ((0, 1, 2), (0, 2, 3))])
    return Surface(
        vertices=corners @ axes + camera.position,
        faces=faces.astype(np.int32),
        color=color,
        casts=False,
        rim=0.0,
        fade=fade,
    )

"""A furnished room with a chosen number of triangles, made in code.

Walls, floor and furniture are boxes with rounded edges, finely divided; cushions bulge. Each
piece is convex, so that the peer can use it as a convex collision mesh.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from halfphysics.bench.record import Options
from halfphysics.geometry.shapes import Mesh

Array = NDArray[np.float64]

#: Inner size of the room, thickness of walls and floor [m]. The floor is z = 0; the person
#: stands at the origin, 1.4 m from the wall at -x.
ROOM, THICK = np.array([5.0, 4.0, 2.5]), 0.1
MIDDLE = np.array([1.1, 0.0])
#: Seat of the sofa [m]: height of its front, drop towards its back, position of its front edge,
#: depth; height of the arm rests.
SEAT, SLOPE, SEAT_FRONT, DEPTH, ARM_REST = 0.46, 0.03, -0.1, 0.38, 0.70
#: The face of the wall on the person's left, and the open face of the shelf on the right [m].
WALL_FACE, SHELF_FACE = 2.0, -1.6


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A box with round edges.

    Attributes:
        low, high: Corners of the box (3,) [m].
        radius: Radius of the edges [m].
        bulge: Relative increase of thickness from the rim to the middle.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    radius: float = 0.004
    bulge: float = 0.0


@dataclass(frozen=True, eq=False)
class Room:
    """A room as one mesh, and the points (n, 3) of its convex pieces."""

    mesh: Mesh
    hulls: tuple[Array, ...]


@cache
def room(triangles: int) -> Room:
    """The room with at least `triangles` triangles, and as few more as even division allows."""
    return mesh_of(furniture(), triangles)


def mesh_of(pieces: tuple[Piece, ...], triangles: int) -> Room:
    """Pieces as one mesh of at least `triangles` triangles, evenly divided."""
    low, high = 1e-3, 1.0
    for _ in range(60):  # the longest edge that gives so many
        middle = 0.5 * (low + high)
        enough = sum(_count(piece, middle) for piece in pieces) >= triangles
        low, high = (middle, high) if enough else (low, middle)
    vertices, faces, first = [], [], 0
    for piece in pieces:
        v, f = rounded_box(piece, low)
        vertices.append(v)
        faces.append(f + first)
        first += len(v)
    mesh = Mesh(np.concatenate(vertices), np.concatenate(faces))
    return Room(mesh, tuple(rounded_box(piece, 0.25)[0] for piece in pieces))


def furniture() -> tuple[Piece, ...]:
    """Walls, floor, sofa, shelf, table and a cupboard."""
    return tuple((*_walls(), *_sofa(), *_shelf(), *_table(), _cupboard()))


def _walls() -> Iterator[Piece]:
    (x0, y0), (x1, y1) = MIDDLE - 0.5 * ROOM[:2], MIDDLE + 0.5 * ROOM[:2]
    t, top = THICK, float(ROOM[2])
    yield Piece(low=(x0, y0, -t), high=(x1, y1, 0.0))
    yield Piece(low=(x0 - t, y0, 0.0), high=(x0, y1, top))
    yield Piece(low=(x1, y0, 0.0), high=(x1 + t, y1, top))
    yield Piece(low=(x0, y0 - t, 0.0), high=(x1, y0, top))
    yield Piece(low=(x0, y1, 0.0), high=(x1, y1 + t, top))


def _sofa() -> Iterator[Piece]:
    """The sofa behind the person: base, two cushions, back rest, arm rests."""
    front, back = SEAT_FRONT, SEAT_FRONT - DEPTH
    low, high = SEAT - SLOPE - 0.16, SEAT - SLOPE - 0.02
    yield Piece(low=(back - 0.2, -1.0, 0.08), high=(front, 0.32, low - 0.001), radius=0.01)
    for y in (-0.995, -0.335):
        cushion = (back + 0.005, y, low), (front, y + 0.65, high)
        yield Piece(low=cushion[0], high=cushion[1], radius=0.04, bulge=0.15)
    yield Piece(low=(back - 0.2, -1.0, low), high=(back, 0.5, 0.9), radius=0.06)
    for y in (-1.185, 0.325):
        yield Piece(low=(back + 0.005, y, low), high=(front, y + 0.18, ARM_REST), radius=0.05)


def _shelf() -> Iterator[Piece]:
    """The shelf on the person's right, open to the left: sides and boards."""
    low, high, board = SHELF_FACE - 0.35, SHELF_FACE, 0.025
    for x in (-0.5, 0.5 - board):
        yield Piece(low=(x, low, 0.001), high=(x + board, high, 1.9), radius=0.002)
    for z in np.linspace(0.1, 1.8, 6):
        inner = (-0.5 + board + 0.001, low, float(z)), (0.499 - board, high, float(z) + board)
        yield Piece(low=inner[0], high=inner[1], radius=0.002)


def _table() -> Iterator[Piece]:
    yield Piece(low=(1.0, -0.6, 0.71), high=(2.2, 0.6, 0.75), radius=0.01)
    for x in (1.05, 2.09):
        for y in (-0.55, 0.49):
            yield Piece(low=(x, y, 0.001), high=(x + 0.06, y + 0.06, 0.709))


def _cupboard() -> Piece:
    return Piece(low=(2.6, 0.9, 0.001), high=(3.4, 1.9, 2.0), radius=0.01)


def _ticks(piece: Piece, longest: float) -> list[Array]:
    """Grid coordinates of a piece along each axis, from -half to half; one ends each rounding."""
    half = 0.5 * (np.array(piece.high) - np.array(piece.low))
    out = []
    for h in half:
        r = min(piece.radius, 0.5 * h)
        rim = np.linspace(-h, r - h, max(1, int(np.ceil(r / longest))) + 1)
        inner = np.linspace(r - h, h - r, max(1, int(np.ceil(2 * (h - r) / longest))) + 1)
        out.append(np.concatenate([rim, inner[1:-1], -rim[::-1]]))
    return out


def _count(piece: Piece, longest: float) -> int:
    a, b, c = (len(x) - 1 for x in _ticks(piece, longest))
    return 4 * (a * b + b * c + c * a)


def rounded_box(piece: Piece, longest: float) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and outward faces of a piece; no edge of its grid exceeds `longest` [m].

    Neighbouring sides have their own copies of common vertices; `Mesh` merges them.
    """
    ticks = _ticks(piece, longest)
    vertices, faces, first = [], [], 0
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        nu, nv = len(ticks[u]), len(ticks[v])
        grid = np.zeros((nu, nv, 3))
        grid[..., u], grid[..., v] = ticks[u][:, None], ticks[v]
        corner = np.arange(nu * nv).reshape(nu, nv)
        a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
        quads = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
        for sign, order in ((-1, [0, 2, 1]), (1, [0, 1, 2])):
            grid[..., axis] = ticks[axis][0] * -sign
            vertices.append(grid.reshape(-1, 3).copy())
            faces.append(quads[:, order] + first)
            first += nu * nv
    return _shaped(piece, np.concatenate(vertices)), np.concatenate(faces).astype(np.int32)


def _shaped(piece: Piece, points: Array) -> Array:
    """Points of a box's surface moved to the rounded, bulging surface, in place in the room."""
    low, high = np.array(piece.low), np.array(piece.high)
    half = 0.5 * (high - low)
    r = np.minimum(piece.radius, 0.5 * half)
    core = np.clip(points, r - half, half - r)
    away = (points - core) / r
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    points = core + r * away
    if piece.bulge:
        # A paraboloid over the middle: concave, so the piece stays convex.
        middle = 1.0 - 0.5 * ((points[:, :2] / half[:2]) ** 2).sum(axis=1)
        points = points * np.stack([np.ones_like(middle)] * 2 + [1.0 + piece.bulge * middle], 1)
    result: Array = 0.5 * (low + high) + points
    return result


def sizes(options: Options) -> tuple[int, int]:
    """Numbers of triangles of the rooms in the cases."""
    return (10_000, 100_000) if options.quick else (100_000, 1_000_000)

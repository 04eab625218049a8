"""Furniture as triangle meshes, made in code from boxes with rounded edges.

A piece of furniture stands at the origin of its own frame, which is on the floor under its
middle, and faces +x. Its bodies are closed and may overlap, as in scanned and modelled rooms.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from halfphysics.bench.room import Piece, rounded_box
from halfphysics.geometry.mesh_queries import merge_vertices

Array = NDArray[np.float64]
Faces = NDArray[np.int32]

#: A kind of furniture is made of (depth, width, height) [m]: low and high corner of every body,
#: rounding of its edges [m] and how much it bulges.
Make = Callable[[float, float, float], Iterator[Piece]]

#: Furniture stands this high over the floor [m].
_OFF = 0.002


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of furniture.

    Attributes:
        least, most: Smallest and largest depth, width and height [m].
        make: Makes its bodies.
        wall: Whether it stands with its back to a wall.
        top: Height at which a person sits, lies or puts hands on it, as a fraction of its own.
    """

    least: tuple[float, float, float]
    most: tuple[float, float, float]
    make: Make
    wall: bool = True
    top: float = 1.0


def _box(
    x0: float, y0: float, z0: float, x1: float, y1: float, z1: float, *,
    radius: float = 0.006, bulge: float = 0.0,
) -> Piece:  # fmt: skip
    return Piece(low=(x0, y0, z0), high=(x1, y1, z1), radius=radius, bulge=bulge)


def _sofa(depth: float, width: float, height: float) -> Iterator[Piece]:
    """Seats, back and arm rests, cushions that lean on the back; the seat is at 0.52 of it."""
    x, y, seat, arm = 0.5 * depth, 0.5 * width, 0.52 * height, 0.16
    back = -x + 0.24
    count = max(1, round((width - 2 * arm) / 0.65))
    edges = np.linspace(-y + arm, y - arm, count + 1)
    for low, high in itertools.pairwise(edges):
        yield _box(back - 0.05, low + 0.003, 0.05, x, high - 0.003, seat, radius=0.05)
        yield _box(back - 0.10, low + 0.01, seat - 0.03, back + 0.05, high - 0.01, height,
                   radius=0.06)  # fmt: skip
    yield _box(-x, -y, 0.05, back - 0.04, y, height - 0.04, radius=0.06)
    for side in (-1.0, 1.0):
        low, high = sorted((side * y, side * (y - arm)))
        yield _box(-x, low, 0.05, x - 0.01, high, seat + 0.17, radius=0.05)


def _bed(depth: float, width: float, height: float) -> Iterator[Piece]:
    """A divan, pillows and a head board; it faces the side from which a person gets in."""
    x, y = 0.5 * depth, 0.5 * width
    yield _box(-x, -y, 0.04, x, y, height, radius=0.06)
    yield _box(-x, y, _OFF, x, y + 0.05, height + 0.45, radius=0.015)
    count = max(1, round(depth / 0.8))
    edges = np.linspace(-x + 0.08, x - 0.08, count + 1)
    for low, high in itertools.pairwise(edges):
        yield _box(low + 0.03, y - 0.45, height - 0.03, high - 0.03, y - 0.06, height + 0.09,
                   radius=0.05)  # fmt: skip


def _plate(depth: float, width: float, height: float, thick: float, leg: float) -> Iterator[Piece]:
    x, y = 0.5 * depth, 0.5 * width
    yield _box(-x, -y, height - thick, x, y, height, radius=min(0.01, 0.4 * thick))
    for a in (-x + 0.03, x - 0.03 - leg):
        for b in (-y + 0.03, y - 0.03 - leg):
            yield _box(a, b, _OFF, a + leg, b + leg, height - 0.5 * thick)


def _table(depth: float, width: float, height: float) -> Iterator[Piece]:
    """A plate on four legs."""
    yield from _plate(depth, width, height, 0.04, 0.06)


def _coffee_table(depth: float, width: float, height: float) -> Iterator[Piece]:
    """A thick plate on four legs, a board under it."""
    yield from _plate(depth, width, height, 0.07, 0.07)
    x, y = 0.5 * depth - 0.05, 0.5 * width - 0.05
    yield _box(-x, -y, 0.14, x, y, 0.17)


def _desk(depth: float, width: float, height: float) -> Iterator[Piece]:
    """A plate on two sides, drawers under one of them, a monitor."""
    x, y = 0.5 * depth, 0.5 * width
    yield _box(-x, -y, height - 0.035, x, y, height)
    yield _box(-x + 0.02, -y + 0.02, _OFF, x - 0.04, -y + 0.40, height - 0.02)
    yield _box(-x + 0.02, y - 0.05, _OFF, x - 0.04, y - 0.02, height - 0.02)
    yield _box(-x + 0.06, -0.10, height - 0.001, -x + 0.24, 0.10, height + 0.02)
    yield _box(-x + 0.13, -0.28, height + 0.01, -x + 0.17, 0.28, height + 0.40, radius=0.01)


def _chair(depth: float, width: float, height: float) -> Iterator[Piece]:
    """Seat at half its height, back, four legs."""
    x, y, seat, leg = 0.5 * depth, 0.5 * width, 0.5 * height, 0.04
    yield _box(-x, -y, seat - 0.05, x, y, seat, radius=0.015, bulge=0.05)
    yield _box(-x, -y, seat - 0.02, -x + 0.04, y, height, radius=0.015)
    for a in (-x, x - leg):
        for b in (-y, y - leg):
            yield _box(a, b, _OFF, a + leg, b + leg, seat - 0.02)


def _shelf(depth: float, width: float, height: float) -> Iterator[Piece]:
    """Sides, back, boards, some books: open to the front."""
    x, y, board = 0.5 * depth, 0.5 * width, 0.025
    for side in (-y, y - board):
        yield _box(-x, side, _OFF, x, side + board, height, radius=0.003)
    yield _box(-x, -y, _OFF, -x + 0.012, y, height, radius=0.003)
    for k, z in enumerate(np.linspace(0.06, height - board, 6)):
        yield _box(-x, -y, float(z), x - 0.003, y, float(z) + board, radius=0.003)
        if k < 5:
            start = -y + 0.06 + 0.11 * (k % 3)
            yield _box(-x + 0.02, start, float(z) + 0.01, x - 0.06, start + 0.28, float(z) + 0.24)


def _cabinet(depth: float, width: float, height: float) -> Iterator[Piece]:
    """A body, doors that stand out a little, a plate on top."""
    x, y = 0.5 * depth, 0.5 * width
    yield _box(-x, -y, 0.05, x - 0.02, y, height - 0.02)
    yield _box(-x - 0.0, -y - 0.01, height - 0.03, x + 0.01, y + 0.01, height)
    count = max(2, round(width / 0.5))
    edges = np.linspace(-y, y, count + 1)
    for low, high in itertools.pairwise(edges):
        yield _box(x - 0.03, low + 0.004, 0.07, x, high - 0.004, height - 0.05, radius=0.004)
    yield _box(-x + 0.03, -y + 0.03, _OFF, x - 0.06, y - 0.03, 0.07)


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "sofa": Kind(least=(0.85, 1.5, 0.80), most=(1.0, 2.4, 0.92), make=_sofa, top=0.52),
        "armchair": Kind(least=(0.82, 0.95, 0.80), most=(0.95, 1.1, 0.92), make=_sofa, top=0.52),
        "bed": Kind(least=(1.4, 2.0, 0.42), most=(1.8, 2.1, 0.55), make=_bed),
        "table": Kind(least=(0.75, 1.1, 0.71), most=(0.95, 1.8, 0.77), make=_table, wall=False),
        "coffee_table": Kind(
            least=(0.5, 0.8, 0.36), most=(0.7, 1.2, 0.46), make=_coffee_table, wall=False
        ),
        "desk": Kind(least=(0.6, 1.1, 0.71), most=(0.8, 1.5, 0.76), make=_desk),
        "chair": Kind(
            least=(0.42, 0.42, 0.84), most=(0.48, 0.48, 0.96), make=_chair, wall=False, top=0.5
        ),
        "shelf": Kind(least=(0.28, 0.8, 1.6), most=(0.38, 1.3, 2.1), make=_shelf),
        "cabinet": Kind(least=(0.38, 0.9, 0.50), most=(0.55, 1.8, 1.1), make=_cabinet),
    }
)


def mesh_of(pieces: Iterator[Piece] | tuple[Piece, ...], longest: float) -> tuple[Array, Faces]:
    """Bodies as vertices (V, 3) and faces (F, 3), no edge of their grids over `longest` [m]."""
    vertices, faces, first = [], [], 0
    for piece in pieces:
        v, f = merge_vertices(*rounded_box(piece, longest))
        vertices.append(v)
        faces.append(f + first)
        first += len(v)
    return np.concatenate(vertices), np.concatenate(faces).astype(np.int32)


def without_undersides(vertices: Array, faces: Faces, height: float = 0.25) -> Faces:
    """Faces without those that look down below a height, which a walking scanner misses."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    down = normal[:, 2] < -0.9 * np.linalg.norm(normal, axis=1)
    low = np.maximum(np.maximum(a[:, 2], b[:, 2]), c[:, 2]) < height
    result: Faces = faces[~(down & low)]
    return result


def uneven(vertices: Array, size: float, phase: Array) -> Array:
    """Points displaced by up to about `size` [m], smoothly; equal points move equally.

    phase: (3, 3) [rad], phases of the displacement.
    """
    waves = np.array([[9.0, 5.0, 4.0], [-6.0, 11.0, 5.0], [4.0, -7.0, 12.0]])
    result: Array = vertices + size * np.sin(vertices @ waves.T[:, [1, 2, 0]] + phase[0]) * np.cos(
        vertices @ waves.T + phase[1]
    )
    return result

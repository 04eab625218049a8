"""What the cases are made of: the default body, motions cut to a second or two, and rooms."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import halfphysics as hp

Array = NDArray[np.float64]

#: Metres per unit of the meshes of the test data.
SCALE = 0.7


@cache
def body() -> hp.Body:
    """The default body."""
    return hp.Body.default()


def data() -> Path:
    """Folder of motions and meshes: $HALFPHYSICS_TEST_DATA, or ../shared/data."""
    default = Path(__file__).resolve().parents[3] / "shared/data"
    return Path(os.environ.get("HALFPHYSICS_TEST_DATA", default))


def clips() -> dict[str, Path]:
    """Motion files by name."""
    files = sorted((data() / "motion").glob("*.*"))
    return {file.stem: file for file in files if file.suffix in (".npz", ".bvh")}


def meshes() -> dict[str, Path]:
    """Mesh files by name."""
    return {file.stem: file for file in sorted((data() / "meshes").glob("*/*.obj"))}


def moved(motion: hp.Motion, by: ArrayLike) -> hp.Motion:
    """A motion somewhere else; `by` (3,) [m]."""
    return hp.Motion(motion.translation + np.asarray(by, dtype=float), motion.rotations, motion.fps)


@cache
def clip(name: str, seconds: float = 1.5, first: float = 0.4) -> hp.Motion:
    """A part of a clip on the floor, its pelvis over the origin at the start.

    Args:
        name: Of the file.
        seconds: How long a part.
        first: Where it begins, as a share of what can be left out.
    """
    whole = hp.Motion.load(clips()[name])
    count = min(len(whole), round(seconds * whole.fps) + 1)
    start = int(first * (len(whole) - count))
    cut = whole[start : start + count].grounded(body())
    pelvis = body().joints(cut)[0, 0]
    return moved(cut, (-pelvis[0], -pelvis[1], 0.0))


def standing(frames: int, lean: float = 0.0) -> hp.Motion:
    """A person upright at the origin, arms out, who leans forward steadily up to `lean` [rad]."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = (np.pi / 2.0, 0.0, 0.0)
    rotations[:, 3, 0] = np.linspace(0.0, lean, frames)
    motion = hp.Motion(np.zeros((frames, 3)), rotations, 30.0)
    return motion.grounded(body())


def floor(**options: Any) -> hp.Scene:
    """A scene with a floor at z = 0."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(), **options)
    return scene


def bowling() -> hp.Scene:
    """A floor, and solids of every kind where a person is about to move."""
    scene = floor()
    scene.add_object("ball", hp.Sphere(0.11), mass=0.43, position=(0.3, 0.0, 0.12))
    scene.add_object("crate", hp.Box((0.3, 0.3, 0.3)), density=100.0, position=(0.5, 0.2, 0.151))
    scene.add_object("can", hp.Cylinder(0.04, 0.12), mass=0.3, position=(0.5, 0.2, 0.362))
    roll = {"position": (-0.3, 0.1, 0.06), "quaternion": (0.5, 0.5, 0.5, 0.5)}
    scene.add_object("roll", hp.Capsule(0.05, 0.3), mass=1.0, restitution=0.3, **roll)
    post = {"position": (0.35, -0.3, 0.6), "friction": 0.3}
    scene.add_static("post", hp.Cylinder(0.05, 1.2), **post)
    drop = {"position": (0.0, 0.0, 2.1), "velocity": (0.2, 0.1, -1.0)}
    scene.add_object("drop", hp.Box((0.2, 0.1, 0.05)), mass=0.5, **drop)
    asleep = {"position": (0.1, -0.45, 0.9), "start": "asleep"}
    scene.add_object("lamp", hp.Sphere(0.08), mass=0.5, **asleep)
    return scene


# -- a furnished room as one mesh --------------------------------------------------------------

#: Boxes with rounded edges: lowest and highest corner [m], radius of the edges [m], and how much
#: thicker the middle is than the rim, as a share.
_FURNITURE = (
    ((-2.0, -2.0, -0.1), (2.5, 2.0, 0.0), 0.004, 0.0),  # floor
    ((-2.1, -2.0, 0.0), (-2.0, 2.0, 2.5), 0.004, 0.0),  # walls
    ((-2.0, 0.75, 0.0), (2.5, 0.85, 2.5), 0.004, 0.0),
    ((-0.7, -0.6, 0.08), (-0.22, 0.5, 0.26), 0.01, 0.0),  # sofa: base, cushions, back
    ((-0.64, -0.55, 0.27), (-0.22, -0.06, 0.41), 0.04, 0.15),
    ((-0.64, -0.05, 0.27), (-0.22, 0.44, 0.41), 0.04, 0.15),
    ((-0.88, -0.6, 0.27), (-0.66, 0.5, 0.9), 0.06, 0.0),
    ((0.45, -0.5, 0.38), (1.1, 0.5, 0.42), 0.01, 0.0),  # low table and its legs
    ((0.5, -0.45, 0.001), (0.56, -0.39, 0.379), 0.004, 0.0),
    ((0.5, 0.39, 0.001), (0.56, 0.45, 0.379), 0.004, 0.0),
    ((1.0, -0.45, 0.001), (1.06, -0.39, 0.379), 0.004, 0.0),
    ((1.0, 0.39, 0.001), (1.06, 0.45, 0.379), 0.004, 0.0),
    ((-0.5, -0.95, 0.001), (-0.47, -0.65, 1.9), 0.002, 0.0),  # shelf: sides and boards
    ((0.47, -0.95, 0.001), (0.5, -0.65, 1.9), 0.002, 0.0),
    ((-0.46, -0.95, 0.5), (0.46, -0.65, 0.525), 0.002, 0.0),
    ((-0.46, -0.95, 1.1), (0.46, -0.65, 1.125), 0.002, 0.0),
)


@cache
def room_mesh(longest: float) -> hp.Mesh:
    """The furnished room, no edge of its triangles longer than about `longest` [m]."""
    vertices, faces, first = [], [], 0
    for low, high, radius, bulge in _FURNITURE:
        points, triangles = _rounded_box(low, high, radius, bulge, longest)
        vertices.append(points)
        faces.append(triangles + first)
        first += len(points)
    return hp.Mesh(np.concatenate(vertices), np.concatenate(faces))


def furnished(longest: float = 0.06) -> hp.Scene:
    """The room, and things in it that can be pushed about."""
    scene = hp.Scene()
    scene.add_static("room", room_mesh(longest))
    scene.add_object("cup", hp.Cylinder(0.04, 0.1), mass=0.3, position=(0.5, 0.1, 0.471))
    scene.add_object("ball", hp.Sphere(0.11), mass=0.43, position=(0.25, 0.2, 0.112))
    scene.add_object("book", hp.Box((0.25, 0.18, 0.04)), mass=0.8, position=(0.55, -0.2, 0.441))
    pillow = {"position": (-0.4, 0.2, 0.7), "start": "asleep"}
    scene.add_object("pillow", hp.Box((0.3, 0.3, 0.1)), mass=0.4, **pillow)
    return scene


def _rounded_box(
    low: Sequence[float], high: Sequence[float], radius: float, bulge: float, longest: float
) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and outward faces of a box with rounded edges and a bulging top and bottom."""
    half = 0.5 * (np.array(high) - np.array(low))
    ticks = [_ticks(h, min(radius, 0.5 * h), longest) for h in half]
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
            grid[..., axis] = sign * half[axis]
            vertices.append(grid.reshape(-1, 3).copy())
            faces.append(quads[:, order] + first)
            first += nu * nv
    points, inset = np.concatenate(vertices), np.minimum(radius, 0.5 * half)
    core = np.clip(points, inset - half, half - inset)
    away = (points - core) / inset
    points = core + inset * away / np.linalg.norm(away, axis=1, keepdims=True)
    middle = 1.0 - 0.5 * ((points[:, :2] / half[:2]) ** 2).sum(axis=1)
    points[:, 2] *= 1.0 + bulge * middle
    return points + half + np.array(low), np.concatenate(faces).astype(np.int32)


def _ticks(half: float, radius: float, longest: float) -> Array:
    """Where a side from -half to half is divided."""
    inner = np.linspace(radius - half, half - radius, max(1, round(2 * half / longest)) + 1)
    return np.concatenate([[-half], inner, [half]])

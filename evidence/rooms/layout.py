"""Furnished test scenes from a seed: rooms with walls, a doorway and furniture.

World: z up, the floor at z = 0, the room's middle at the origin. The same number and seed give
the same bytes. Every second room is like a modelled one, with a mesh per piece; the others are like
scans: one uneven mesh, without undersides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evidence.rooms.furniture import KINDS, mesh_of, uneven, without_undersides
from halfphysics.base import rotations as rot
from halfphysics.bench.room import Piece
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Walls [m]: how thick and high; of the doorway: width, height.
WALL, HIGH = 0.2, 2.5
_DOOR, _DOOR_HIGH = (0.72, 0.92), 2.05
#: Furniture of the rooms, in this order, each piece where there is space.
_ROOMS = (
    ("sofa", "cabinet", "coffee_table", "shelf", "armchair", "chair"),
    ("bed", "cabinet", "desk", "chair", "shelf"),
    ("table", "chair", "chair", "cabinet", "shelf", "sofa"),
    ("bed", "sofa", "table", "shelf", "chair"),
    ("sofa", "armchair", "coffee_table", "cabinet", "desk"),
)
_TRIES = 400
#: Unevenness of scanned rooms [m]; edge length of bodies for engines [m].
_UNEVEN, _COARSE = 0.002, 0.25


@dataclass(frozen=True, kw_only=True)
class Footprint:
    """A rectangle on the floor: middle (2,), half its size (2,) [m], turn about z [rad]."""

    place: tuple[float, float]
    half: tuple[float, float]
    yaw: float = 0.0

    def local(self, points: Array) -> Array:
        """Points (n, 2) of the world in its frame."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        moved = np.asarray(points) - self.place
        result: Array = moved @ np.array([[c, -s], [s, c]])
        return result

    def world(self, points: Array) -> Array:
        """Points (n, 2) of its frame in the world."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        result: Array = np.asarray(points) @ np.array([[c, s], [-s, c]]) + self.place
        return result

    def distance(self, points: Array) -> Array:
        """Distances (n,) of points (n, 2) of the world, negative inside [m]."""
        away = np.abs(self.local(points)) - self.half
        outside = np.linalg.norm(np.maximum(away, 0.0), axis=1)
        result: Array = outside + np.minimum(away.max(axis=1), 0.0)
        return result

    def apart(self, other: Footprint) -> float:
        """Separation of two footprints along the edges of either [m]; under 0: they overlap."""
        best = -np.inf
        for one, its in ((self, other), (other, self)):
            a, b = its.half
            corners = one.local(its.world(np.array([[-a, -b], [a, -b], [a, b], [-a, b]])))
            gap = np.maximum(corners.min(axis=0) - one.half, -corners.max(axis=0) - one.half)
            best = max(best, float(gap.max()))
        return best


@dataclass(frozen=True, kw_only=True)
class Item:
    """A piece of furniture at its place, facing along its turn.

    Attributes:
        name, kind: Its name, and its kind (`KINDS`).
        at: Its footprint; the first axis is its depth.
        height: Its whole height [m].
    """

    name: str
    kind: str
    at: Footprint
    height: float

    @property
    def top(self) -> float:
        """Height at which a person sits, lies or puts hands on it [m]."""
        return KINDS[self.kind].top * self.height


@dataclass(frozen=True, kw_only=True, eq=False)
class Room:
    """A furnished room.

    Attributes:
        scene: Its statics: all in one mesh "room" where `scanned`, else floor, walls and items.
        size: Inner width and depth [m].
        door: Middle of the doorway (2,); `outward`: the way out through it (2,).
        items: Its furniture.
        walls: Footprints of the walls, without the doorway.
        scanned: Whether it is one uneven mesh.
        bodies: The same room with a static per convex body, for engines without meshes.
    """

    scene: Scene
    bodies: Scene
    size: tuple[float, float]
    door: Array
    outward: Array
    items: tuple[Item, ...]
    walls: tuple[Footprint, ...]
    scanned: bool

    @property
    def triangles(self) -> int:
        """Number of triangles of its meshes."""
        shapes = (s.shape for s in self.scene.statics.values())
        return sum(len(shape.faces) for shape in shapes if isinstance(shape, Mesh))


def room(number: int, seed: int = 0) -> Room:
    """The test scene with a number, 0 to 19 in the report."""
    rng = np.random.default_rng([seed, number, 0])
    size = rng.uniform(3.8, 6.0), rng.uniform(3.6, 5.2)
    walls, footprints, door, outward = _walls(rng, np.array(size))
    items = _furnished(rng, np.array(size), door, outward, _ROOMS[number % len(_ROOMS)])
    scanned = number % 2 == 1
    scene = _scene(rng, items, walls, size, scanned=scanned)
    return Room(
        scene=scene,
        bodies=_bodies(items, walls),
        size=size,
        door=door,
        outward=outward,
        items=items,
        walls=footprints,
        scanned=scanned,
    )


def _walls(
    rng: np.random.Generator, size: Array
) -> tuple[list[Piece], tuple[Footprint, ...], Array, Array]:
    """Bodies of the walls, their footprints, the doorway's middle and the way out of it."""
    side = int(rng.integers(4))
    width = rng.uniform(*_DOOR)
    axis, sign = side // 2, 1.0 if side % 2 else -1.0
    along = 1 - axis
    middle = rng.uniform(-0.5, 0.5) * (size[along] - width - 0.8)
    pieces, footprints = [], []

    def put(low: Array, high: Array, bottom: float) -> None:
        pieces.append(Piece(low=(*low, bottom), high=(*high, HIGH), radius=0.008))
        if bottom == 0.0:
            centre, half = 0.5 * (low + high), 0.5 * (high - low)
            footprints.append(
                Footprint(place=(float(centre[0]), float(centre[1])), half=(half[0], half[1]))
            )

    for k in range(4):
        a, s = k // 2, 1.0 if k % 2 else -1.0
        low, high = -0.5 * size, 0.5 * size
        # Along x the walls reach over the corners.
        if a == 1:
            low[0], high[0] = low[0] - WALL, high[0] + WALL
        low[a], high[a] = sorted((s * 0.5 * size[a], s * (0.5 * size[a] + WALL)))
        if k != side:
            put(low, high, 0.0)
            continue
        for part in (0, 1):
            lo, hi = low.copy(), high.copy()
            (hi if part == 0 else lo)[along] = middle + (part - 0.5) * width
            put(lo, hi, 0.0)
        lo, hi = low.copy(), high.copy()
        lo[along], hi[along] = middle - 0.5 * width - 0.01, middle + 0.5 * width + 0.01
        put(lo, hi, _DOOR_HIGH)
    door, outward = np.zeros(2), np.zeros(2)
    door[axis], door[along] = sign * (0.5 * size[axis] + 0.5 * WALL), middle
    outward[axis] = sign
    return pieces, tuple(footprints), door, outward


def _furnished(
    rng: np.random.Generator, size: Array, door: Array, outward: Array, kinds: tuple[str, ...]
) -> tuple[Item, ...]:
    """Place `kinds` against walls or free, apart, the doorway left open; some find no place."""
    entrance = door - 0.6 * outward
    free = Footprint(place=(float(entrance[0]), float(entrance[1])), half=(0.55, 0.55))
    items: list[Item] = []
    for name in kinds:
        kind = KINDS[name]
        for _ in range(_TRIES):
            depth, width, height = rng.uniform(kind.least, kind.most)
            wall = int(rng.integers(4))
            yaw = 0.5 * np.pi * wall + np.radians(rng.normal(0.0, 1.5 if kind.wall else 12.0))
            spread = 0.5 * size - (0.5 * max(depth, width) + 0.1)
            place = rng.uniform(-spread, spread)
            if kind.wall:
                # Its back is a few centimetres from the wall.
                a, s = wall % 2, -1.0 if wall < 2 else 1.0
                tilt = 0.5 * width * abs(np.sin(yaw - 0.5 * np.pi * wall))
                place[a] = s * (0.5 * size[a] - 0.5 * depth - tilt - rng.uniform(0.02, 0.06))
            at = Footprint(
                place=(float(place[0]), float(place[1])),
                half=(0.5 * depth, 0.5 * width),
                yaw=float(yaw),
            )
            # Head boards stand out.
            near = 0.12 if kind.wall else 0.35
            if all(at.apart(item.at) >= near for item in items) and at.apart(free) >= 0.0:
                known = sum(item.kind == name for item in items)
                label = f"{name}{known + 1}" if known else name
                items.append(Item(name=label, kind=name, at=at, height=float(height)))
                break
    return tuple(items)


def _bodies(items: tuple[Item, ...], walls: list[Piece]) -> Scene:
    """Floor, walls and items, each of their convex bodies apart."""
    scene = Scene()
    scene.add_static("floor", Plane())
    for k, piece in enumerate(walls):
        scene.add_static(f"walls {k}", Mesh(*mesh_of((piece,), _COARSE)))
    for item in items:
        (a, b), turn = item.at.half, rot.exp([0.0, 0.0, item.at.yaw])
        pieces = KINDS[item.kind].make(2.0 * a, 2.0 * b, item.height)
        for k, piece in enumerate(pieces):
            mesh = Mesh(*mesh_of((piece,), _COARSE))
            place = (*item.at.place, 0.0)
            scene.add_static(f"{item.name} {k}", mesh, position=place, quaternion=turn)
    return scene


def _scene(
    rng: np.random.Generator,
    items: tuple[Item, ...],
    walls: list[Piece],
    size: tuple[float, float],
    *,
    scanned: bool,
) -> Scene:
    longest = float(rng.uniform(0.045, 0.075))
    meshes = {"walls": mesh_of(tuple(walls), 3.0 * longest)}
    for item in items:
        (a, b), h = item.at.half, item.height
        meshes[item.name] = mesh_of(KINDS[item.kind].make(2.0 * a, 2.0 * b, h), longest)
    scene = Scene()
    turns = {item.name: item for item in items}
    if not scanned:
        scene.add_static("floor", Plane())
        for name, (v, f) in meshes.items():
            at = turns[name].at if name in turns else Footprint(place=(0.0, 0.0), half=(0.0, 0.0))
            scene.add_static(
                name,
                Mesh(v, f),
                position=(*at.place, 0.0),
                quaternion=rot.exp([0.0, 0.0, at.yaw]),
            )
        return scene
    x, y = 0.5 * size[0] + 1.8, 0.5 * size[1] + 1.8
    floor = Piece(low=(-x, -y, -0.15), high=(x, y, 0.0), radius=0.004)
    vertices, faces, first = [], [], 0
    phase = rng.uniform(0.0, 2.0 * np.pi, (3, 3))
    for name, (v, f) in meshes.items():
        if name in turns:
            at = turns[name].at
            f = without_undersides(v, f)
            v = np.column_stack([at.world(v[:, :2]), v[:, 2]])
            v = uneven(v, _UNEVEN, phase)
        vertices.append(v)
        faces.append(f + first)
        first += len(v)
    v, f = mesh_of((floor,), 0.25)
    vertices.append(v)
    faces.append(f + first)
    scene.add_static("room", Mesh(np.concatenate(vertices), np.concatenate(faces)))
    return scene

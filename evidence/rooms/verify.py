"""Does a skin intersect static geometry? An independent check with the collision library `coal`.

Triangle against triangle, frame by frame: no tree, distance or winding number of this package is
used. A body wholly inside a closed mesh meets none of its triangles; a body that starts outside
passes through them first, and `metrics.penetration` finds it. Needs ``pip install '.[evidence]'``;
without it nothing is verified, and the report says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: The message without `coal`.
MISSING = "not verified: pip install '.[evidence]'"
#: Size of the cells that find skin near geometry [m]. Triangles with a longer edge are always
#: tested, so that none is missed.
_CELL = 0.07
#: Minimum distances up to this are exact [m]: every point of a triangle is within 0.58 of its
#: longest edge from a corner, so that one of its corners is in a tested cell.
_NEAR = 0.4 * _CELL
#: Frames skinned together, which bounds the memory.
_CHUNK = 32
#: Largest number of cells; a larger box gets larger cells.
_CELLS = 20_000_000


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The result of the check.

    Attributes:
        library: Name and version of the library, such as "coal 3.0.3".
        frames: Number of frames of the motion; `checked`: how many of them were tested.
        intersecting: Number of tested frames in which the skin intersects static geometry.
        distance: Minimum distance between the skin and static geometry over the frames without an
            intersection [m]; None if it is over 28 mm.
    """

    library: str
    frames: int
    checked: int
    intersecting: int
    distance: float | None

    def __str__(self) -> str:
        every = "" if self.checked == self.frames else f" looked at of {self.frames}"
        near = "" if self.distance is None else f", nearest {1e3 * self.distance:.3f} mm"
        return (
            f"verified by {self.library}: {self.intersecting} of {self.checked} frames{every} "
            f"intersect{near}"
        )


def library() -> str | None:
    """Name and version of the library; None: it is not installed."""
    if find_spec("coal") is None:
        return None
    try:
        return f"coal {version('coal')}"
    except PackageNotFoundError:  # not installed by pip: the module knows its version
        import coal

        return f"coal {coal.__version__}"


def verify(motion: Motion, body: Body, scene: Scene, *, every: int = 1) -> Verdict | None:
    """Find triangles of the skin that intersect the static geometry of the scene.

    Args:
        motion: Motion of the body.
        body: The body with the skin.
        scene: Tested are its statics that do not ignore the person: meshes by their triangles,
            primitives exactly, planes as half spaces.
        every: Test every n-th frame, and the last one.

    Returns:
        None where the library is not installed.

    Raises:
        InputError: An `every` under 1.
    """
    if not isinstance(every, int) or every < 1:
        raise InputError(f"every: found {every!r}, expected a whole number from 1")
    judge = library()
    if judge is None:
        return None
    frames = sorted({*range(0, len(motion), every), len(motion) - 1})
    obstacles = _Obstacles(scene)
    intersecting, nearest = 0, np.inf
    faces = np.ascontiguousarray(body.faces)
    for skins in _skins(motion, body, frames):
        obstacles.focus(skins)
        for skin in skins:
            met, distance = obstacles.ask(skin, faces)
            intersecting += met
            nearest = min(nearest, distance)
    return Verdict(
        library=judge,
        frames=len(motion),
        checked=len(frames),
        intersecting=intersecting,
        distance=float(nearest) if nearest <= _NEAR else None,
    )


def _skins(motion: Motion, body: Body, frames: list[int]) -> Iterator[Array]:
    for first in range(0, len(frames), _CHUNK):
        part = frames[first : first + _CHUNK]
        yield np.asarray(body.vertices(motion, frames=part)).reshape(len(part), -1, 3)


class _Obstacles:
    """The statics of a scene for coal: one tree of all triangles, and primitives."""

    def __init__(self, scene: Scene) -> None:
        import coal

        self._coal: Any = coal
        self._here = coal.Transform3s()
        vertices, faces, first = [], [], 0
        lows, highs = [np.zeros((0, 3))], [np.zeros((0, 3))]
        self._solids: list[tuple[Any, Any]] = []
        self._planes: list[tuple[Array, float]] = []
        for static in scene.statics.values():
            if scene.ignores(static.name, "person"):
                continue
            turn = rot.to_matrix(np.asarray(static.quaternion))
            shape, position = static.shape, np.asarray(static.position)
            if isinstance(shape, Mesh):
                vertices.append(shape.vertices @ turn.T + position)
                faces.append(np.asarray(shape.faces, dtype=np.int64) + first)
                first += len(shape.vertices)
            elif isinstance(shape, Plane):
                normal = turn @ np.asarray(shape.normal)
                self._planes.append((normal, shape.offset + float(normal @ position)))
            else:
                self._solids.append((self._solid(shape), coal.Transform3s(turn, position)))
                # Round shapes exceed their triangles by far less than a cell.
                points = shape.triangles()[0] @ turn.T + position
                lows.append(points.min(axis=0)[None])
                highs.append(points.max(axis=0)[None])
        self._tree: Any = None
        if vertices:
            points, triangles = np.concatenate(vertices), np.concatenate(faces)
            self._tree = self._made(points, triangles)
            corners = points[triangles]
            lows.append(corners.min(axis=1))
            highs.append(corners.max(axis=1))
        self._low, self._high = np.concatenate(lows), np.concatenate(highs)
        self._cells: _Cells | None = None

    def _solid(self, shape: Any) -> Any:
        if isinstance(shape, Box):
            return self._coal.Box(*shape.size)
        if isinstance(shape, Sphere):
            return self._coal.Sphere(shape.radius)
        if isinstance(shape, Capsule):
            return self._coal.Capsule(shape.radius, shape.length)
        if isinstance(shape, Cylinder):
            return self._coal.Cylinder(shape.radius, shape.length)
        raise InputError(f"verify: found a {type(shape).__name__}, expected a mesh or a primitive")

    def _made(self, points: Array, faces: Any) -> Any:
        model = self._coal.BVHModelOBBRSS()
        model.beginModel(len(faces), len(points))
        model.addVertices(np.ascontiguousarray(points))
        model.addTriangles(np.ascontiguousarray(faces))
        model.endModel()
        return model

    def focus(self, skins: Array) -> None:
        """Restrict the next tests to the box of these skins (t, V, 3)."""
        if len(self._low):
            low, high = skins.min(axis=(0, 1)), skins.max(axis=(0, 1))
            self._cells = _Cells(self._low, self._high, low, high)

    def ask(self, skin: Array, faces: Any) -> tuple[bool, float]:
        """Whether a skin (V, 3) intersects the statics; the minimum distance if not [m]."""
        nearest = np.inf
        for normal, offset in self._planes:
            nearest = min(nearest, float((skin @ normal).min()) - offset)
        if nearest <= 0.0:
            return True, np.inf
        near = faces[:0] if self._cells is None else self._cells.near(skin, faces)
        if len(near):
            model = self._made(*_part(skin, near))
            others = [] if self._tree is None else [(self._tree, self._here)]
            for other, place in (*others, *self._solids):
                met, distance = self._pair(model, other, place)
                if met:
                    return True, np.inf
                nearest = min(nearest, distance)
        return False, nearest

    def _pair(self, model: Any, other: Any, place: Any) -> tuple[bool, float]:
        coal = self._coal
        request, found = coal.CollisionRequest(), coal.CollisionResult()
        if coal.collide(model, self._here, other, place, request, found):
            return True, np.inf
        asked, answer = coal.DistanceRequest(), coal.DistanceResult()
        return False, float(coal.distance(model, self._here, other, place, asked, answer))


def _part(skin: Array, faces: Any) -> tuple[Array, Any]:
    """The vertices of some faces only."""
    used, numbers = np.unique(faces, return_inverse=True)
    return skin[used], numbers.reshape(-1, 3)


class _Cells:
    """Cells of space near the boxes of triangles, within a box."""

    def __init__(self, low: Array, high: Array, least: Array, most: Array) -> None:
        """Boxes (n, 3) of triangles; the corners (3,) of the box that matters."""
        self._origin = least - 2.0 * _CELL
        span = most - least + 4.0 * _CELL
        self._side = max(_CELL, float(np.cbrt(np.prod(span) / _CELLS)))
        count = np.ceil(span / self._side).astype(int) + 1
        # Each box covers its cells and their neighbours.
        first = np.floor((low - self._origin) / self._side).astype(np.int64) - 1
        last = np.floor((high - self._origin) / self._side).astype(np.int64) + 1
        inside = (last >= 0).all(axis=1) & (first < count).all(axis=1)
        first = np.clip(first[inside], 0, count - 1)
        last = np.clip(last[inside], 0, count - 1) + 1
        # Cumulative sums of these marks along the three axes count the boxes that cover each cell.
        marks = np.zeros(count + 1, dtype=np.int32)
        ends = (first, last)
        for corner in np.ndindex(2, 2, 2):
            at = tuple(ends[c][:, axis] for axis, c in enumerate(corner))
            np.add.at(marks, at, 1 - 2 * (sum(corner) % 2))
        for axis in range(3):
            np.cumsum(marks, axis=axis, out=marks)
        self._full = marks[:-1, :-1, :-1] > 0

    def near(self, skin: Array, faces: Any) -> Any:
        """The faces (n, 3) of a skin (V, 3) that may intersect a triangle."""
        at = np.floor((skin - self._origin) / self._side).astype(np.int64)
        touched = self._full[at[:, 0], at[:, 1], at[:, 2]]
        corners = [skin[faces[:, k]] for k in range(3)]
        kept = touched[faces].any(axis=1)
        for a, b in ((0, 1), (1, 2), (2, 0)):
            edge = corners[a] - corners[b]
            kept |= np.einsum("ij,ij->i", edge, edge) > self._side**2
        return faces[kept]

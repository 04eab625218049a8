"""Places to stand in a scene that is one mesh, and a walk between them.

World: z up. A floor is large, low, and faces up; a mesh without one gets a plane under it. A place
is clear where no vertex of a standing body is near the mesh or inside it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from evidence.rooms.strolls import Way, stroll
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Possible extents of a scene [m]: a smaller or larger one is in another unit.
_SIZES = (0.25, 500.0)
#: Triangles whose normal is this near to up may be a floor; how thick one is [m].
_LEVEL, _THICK = 0.95, 0.10
#: A floor has at least this area [m^2], this fraction of all faces up, and is in the lowest part.
_AREA, _SHARE, _LOW = 2.0, 0.25, 0.35
#: Heights of the soles over the floor, tried in turn [m]; clearance from all else [m].
_LIFTS, _CLEAR = (0.004, 0.02, 0.05), 0.002
#: A mesh without a floor: places are up to this far from it [m].
_AROUND = 1.6
_TRIES, _PLACES, _LENGTHS = 300, 14, (1.2, 5.0)
#: Heights at which a path is tested [m], the distance that counts as inside [m], and the fraction
#: of the path that should be inside: something to walk through, and space beside it.
_HEIGHTS, _NEAR, _MIDDLING = (0.3, 0.7, 1.1, 1.4), 0.18, 0.2


def floor(mesh: Mesh) -> float | None:
    """Height of the floor of a scene [m], None where it has none."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    twice = np.linalg.norm(normal, axis=1)
    up = normal[:, 2] > _LEVEL * twice
    if not up.any():
        return None
    heights, areas = (a[up, 2] + b[up, 2] + c[up, 2]) / 3.0, 0.5 * twice[up]
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    order = np.argsort(heights, kind="stable")
    heights, areas = heights[order], areas[order]
    total = np.concatenate([[0.0], np.cumsum(areas)])
    last = np.searchsorted(heights, heights + _THICK, side="right")
    inside = total[last] - total[:-1]
    large = (inside >= max(_AREA, _SHARE * total[-1])) & (heights <= low + _LOW * (high - low))
    if not large.any():
        return None
    first = int(np.argmax(large))
    window = slice(first, last[first])
    middle = np.searchsorted(np.cumsum(areas[window]), 0.5 * areas[window].sum())
    return float(heights[window][middle])


def walk_through(mesh: Mesh, body: Body, seed: int, fps: float = 30.0) -> Sequence:
    """A walk on the floor of a mesh between two clear places, through what is between them.

    Raises:
        InputError: The mesh is too small or large for a scene in metres, or has no place to stand.
    """
    size = float(np.ptp(mesh.vertices, axis=0).max())
    if not _SIZES[0] <= size <= _SIZES[1]:
        raise InputError(
            f"the scene is {size:.3g} m wide, expected {_SIZES[0]:g} to {_SIZES[1]:g}: is it in "
            "metres? Scale it first"
        )
    rng = np.random.default_rng([seed, 2])
    ground = floor(mesh)
    scene = Scene()
    scene.add_static("scene", mesh)
    if ground is None:
        low = float(mesh.vertices[:, 2].min())
        scene.add_static("floor", Plane((0.0, 0.0, 1.0), low))
    else:
        low = ground
    places = _places(rng, mesh, body, low, around=ground is None)
    if not places:
        raise InputError(
            f"found no clear place for a body of {body.stature:.2f} m on the floor at "
            f"z = {low:.2f} m, expected one. Is z its up axis (y of .glb), and is it in metres?"
        )
    start, goal, lift = _pair(rng, mesh, places, low)
    way = Way(np.array([start, goal]))
    motion = stroll(body, way, speed=1.0, fps=fps)
    shift = np.array([0.0, 0.0, low + lift - 0.004])
    return Sequence(motion.with_frames(motion.translation + shift, motion.rotations), scene, body)


def _candidates(rng: np.random.Generator, mesh: Mesh, low: float, around: bool) -> Array:
    """Points (n, 2) over the floor."""
    if around:
        least = mesh.vertices[:, :2].min(axis=0) - _AROUND
        most = mesh.vertices[:, :2].max(axis=0) + _AROUND
        return rng.uniform(least, most, (_TRIES, 2))
    corners = mesh.vertices[mesh.faces]
    level = (np.abs(corners[:, :, 2] - low) < _THICK).all(axis=1)
    corners = corners[level]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                          axis=1)  # fmt: skip
    which = rng.choice(len(corners), _TRIES, p=area / area.sum())
    u = np.sort(rng.random((_TRIES, 2)), axis=1)
    weights = np.stack([u[:, 0], u[:, 1] - u[:, 0], 1.0 - u[:, 1]], axis=1)
    return np.asarray(np.einsum("nk,nkd->nd", weights, corners[which])[:, :2])


def _places(
    rng: np.random.Generator, mesh: Mesh, body: Body, low: float, *, around: bool
) -> list[tuple[Array, float]]:
    """Clear places (2,) and the heights of the soles over the floor there [m]."""
    # The arms hang, so the heading hardly matters.
    stand = stroll(body, Way(np.array([[0.0, 0.0], [2.0, 0.0]])), speed=1.0)[0]
    skin = np.asarray(body.vertices(stand)).reshape(-1, 3)
    few = skin[:: max(1, len(skin) // 300)]
    query, found = mesh.query, []
    for place in _candidates(rng, mesh, low, around):
        for lift in _LIFTS:
            shift = np.array([*place, low + lift - 0.004])
            if _free(query, few + shift) and _free(query, skin + shift):
                found.append((place, lift))
                break
        if len(found) == _PLACES:
            break
    return found


def _free(query: object, points: Array) -> bool:
    distance = query.closest(points)[0]  # type: ignore[attr-defined]
    return bool(distance.min() > _CLEAR and not query.inside(points).any())  # type: ignore[attr-defined]


def _pair(
    rng: np.random.Generator, mesh: Mesh, places: list[tuple[Array, float]], low: float
) -> tuple[Array, Array, float]:
    """Start, goal and lift of a path of a suitable length that passes through something."""
    best: tuple[float, Array, Array, float] | None = None
    for i, (a, lift) in enumerate(places):
        for j, (b, _) in enumerate(places):
            length = float(np.linalg.norm(b - a))
            if i == j or not _LENGTHS[0] <= length <= _LENGTHS[1]:
                continue
            line = a + np.linspace(0.0, 1.0, 2 + int(length / 0.1))[:, None] * (b - a)
            points = [np.column_stack([line, np.full(len(line), low + z)]) for z in _HEIGHTS]
            share = float((mesh.query.closest(np.concatenate(points))[0] < _NEAR).mean())
            odd = abs(share - _MIDDLING)
            if best is None or odd < best[0]:
                best = odd, a, b, lift
    if best is not None:
        return best[1], best[2], best[3]
    angle = rng.uniform(0.0, 2.0 * np.pi)
    place, lift = places[0]
    return place, place + 1.5 * np.array([np.cos(angle), np.sin(angle)]), lift

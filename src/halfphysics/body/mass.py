"""Mass, centre of mass and inertia of the body's parts, from the volume inside the skin.

The skin is closed (holes are capped), its volume is exact by the divergence theorem, and its
interior is sampled along parallel rays. The intervals of a ray inside the skin are exact, so few
rays suffice. Every sample belongs to the part of the nearest skin vertex. Sums of hull volumes
would count the overlaps at the joints twice.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh_queries import boundary_edges
from halfphysics.geometry.mesh_solids import solid_moments
from halfphysics.geometry.parallel_rays import cells, crossings, ray_key

Array = NDArray[np.float64]

#: Distance of rays and of samples along them [m], away from small parts.
PITCH = 0.006
#: Factor of density where a ray may meet a small part (2 mm: a finger tip has some 400 samples).
REFINE = 3
#: Sampled and exact volume of a piece may differ by this fraction of the whole volume before the
#: skin is called tangled.
TANGLED = 0.02


@dataclass(frozen=True, kw_only=True, eq=False)
class Solid:
    """Volume and its moments for each of n parts, all in the skin's frame.

    Attributes:
        volume: (n,) [m^3]; 0 for parts without samples.
        centroid: (n, 3) [m]; the origin for parts without samples.
        moment: (n, 3, 3) [m^5], inertia about the centroid per unit density.
        total: Volume inside the skin [m^3]; the sum of `volume`.
    """

    volume: Array
    centroid: Array
    moment: Array
    total: float


def solid_parts(
    vertices: ArrayLike, faces: ArrayLike, labels: ArrayLike, n_parts: int, fine: ArrayLike = ()
) -> Solid:
    """Divide the volume inside a skin among parts.

    Each connected piece of the skin (body, eyes, tongue) is a solid of its own; holes are capped.

    Args:
        vertices: Skin vertices (V, 3) [m].
        faces: Triangles (F, 3), outward; if all are inward they are reversed.
        labels: Part of every vertex (V,), in 0..n_parts-1.
        n_parts: Number of parts.
        fine: Parts that are sampled `REFINE` times as densely.

    Raises:
        InputError: the skin encloses no volume.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    faces = np.asarray(faces, dtype=np.int64)
    labels = np.asarray(labels, dtype=np.int64)
    is_fine = np.isin(labels, np.asarray(fine, dtype=np.int64))
    samples = [s for s in _sample_pieces(vertices, faces, labels, is_fine) if len(s[0])]
    if not samples:
        raise InputError(
            "mass: the skin encloses no volume; its faces are flat, empty or unordered"
        )
    points, sizes, weight, owner = (np.concatenate(column) for column in zip(*samples, strict=True))

    def total(values: Array) -> Array:
        return np.bincount(owner, weights=values, minlength=n_parts).astype(np.float64)

    volume = total(weight)
    safe = np.where(volume > 0.0, volume, 1.0)
    centroid = np.stack([total(weight * points[:, i]) for i in range(3)], axis=1) / safe[:, None]
    offset = points - centroid[owner]
    second = np.empty((n_parts, 3, 3))
    for i in range(3):
        for j in range(i + 1):
            # A sample is a small box, whose own moment keeps the inertia of small parts regular.
            own = sizes[:, i] ** 2 / 12.0 if i == j else 0.0
            second[:, i, j] = second[:, j, i] = total(weight * (offset[:, i] * offset[:, j] + own))
    trace = np.trace(second, axis1=1, axis2=2)
    moment = trace[:, None, None] * np.eye(3) - second
    return Solid(volume=volume, centroid=centroid, moment=moment, total=float(volume.sum()))


def close_holes(vertices: ArrayLike, faces: ArrayLike) -> tuple[Array, NDArray[np.int64]]:
    """The surface with a fan of triangles over every hole; unchanged if there is none.

    Returns vertices (V + holes, 3) and faces (F + rim edges, 3). The fans meet at the middle of
    their rim, so eye sockets and mouths close flat. The result is closed in the sense of chains:
    each edge is used equally often in both directions, even where more than two faces meet.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    faces = np.asarray(faces, dtype=np.int64)
    rim = boundary_edges(faces, len(vertices))
    if len(rim) == 0:
        return vertices, faces
    hole = np.unique(_connected(len(vertices), rim)[rim[:, 0]], return_inverse=True)[1]
    middle = np.zeros((int(hole.max()) + 1, 3))
    np.add.at(middle, hole, vertices[rim].mean(axis=1))
    middle /= np.bincount(hole)[:, None]
    caps = np.stack([rim[:, 1], rim[:, 0], len(vertices) + hole], axis=1)
    return np.concatenate([vertices, middle]), np.concatenate([faces, caps])


def _connected(n: int, edges: NDArray[np.int64]) -> NDArray[np.int32]:
    """Connected component of each of n vertices; edges (k, 2)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    result: NDArray[np.int32] = connected_components(graph, directed=False)[1]
    return result


def _sample_pieces(
    vertices: Array, faces: NDArray[np.int64], labels: NDArray[np.int64], is_fine: NDArray[np.bool_]
) -> list[tuple[Array, Array, Array, NDArray[np.int64]]]:
    """Samples of every connected piece: points (n, 3), sizes (n, 3), volumes (n,), parts (n,)."""
    from scipy.spatial import cKDTree

    whole = solid_moments(*close_holes(vertices, faces))[0] if len(faces) else 0.0
    if whole < 0.0:
        faces, whole = faces[:, ::-1], -whole
    links = np.concatenate([faces[:, :2], faces[:, 1:]])
    piece = _connected(len(vertices), links)[faces[:, 0]]
    samples = []
    for k in np.unique(piece):
        used, local = np.unique(faces[piece == k], return_inverse=True)
        corners, triangles = close_holes(vertices[used], local.reshape(-1, 3))
        exact = solid_moments(corners, triangles)[0]
        if exact <= 0.0:
            continue  # a sheet or an inner shell: it encloses no flesh
        fine = np.zeros(len(corners), dtype=bool)
        fine[: len(used)] = is_fine[used]
        points, sizes = _inside(corners, triangles, np.asarray(fine[triangles].any(axis=1)))
        weight = sizes.prod(axis=1)
        found = weight.sum()
        if found == 0.0:
            continue  # too small for the rays: under a few cubic millimetres
        if abs(found - exact) > TANGLED * whole:
            warnings.warn(
                f"mass: the skin is tangled: {1e3 * exact:.3f} litres by its faces, "
                f"{1e3 * found:.3f} inside it; the latter is used",
                HalfPhysicsWarning,
                stacklevel=4,
            )
        else:
            weight *= exact / found
        nearest = cKDTree(vertices[used], leafsize=32).query(points)[1]
        samples.append((points, sizes, weight, labels[used][nearest]))
    return samples


def _inside(
    vertices: Array, faces: NDArray[np.int64], fine: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Boxes that fill a closed outward surface: centres (n, 3) and sizes (n, 3).

    Rays run along z through the middles of square cells. The grid is centred on the surface, so a
    symmetric surface has symmetric samples. Cells that faces marked `fine` (F,) touch are divided.
    """
    # A person is thinnest along z, so rays along z need the fewest samples.
    centre = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    unit = (vertices - centre) / PITCH
    corners = unit[faces][..., :2]
    low, high = corners.min(axis=1), corners.max(axis=1)
    owner, cell = cells(np.floor(low), np.floor(high))
    key = ray_key(cell)
    divided = np.unique(key[fine[owner]])
    boxes = []
    for refine in (1, REFINE):
        in_divided = np.isin(key, divided)
        chosen = np.unique(owner[in_divided if refine > 1 else ~in_divided])
        ray, z, sign = crossings(unit * refine, faces[chosen])
        keep = np.isin(ray_key(ray // refine), divided) == (refine > 1)
        boxes.append(_boxes(ray[keep], z[keep], sign[keep]) / refine)
    middle, size = np.concatenate(boxes, axis=1)
    return centre + PITCH * middle, PITCH * size


def _boxes(ray: NDArray[np.int64], z: Array, sign: NDArray[np.int64]) -> Array:
    """Stacked middles and sizes (2, n, 3) of boxes about unit long that fill the rays' insides."""
    order = np.lexsort((z, ray_key(ray)))
    ray, z, sign = ray[order], z[order], sign[order]
    group = np.unique(ray_key(ray), return_inverse=True)[1]
    # A ray with fewer exits than entries ran along an edge or through a vertex: drop it.
    whole = np.flatnonzero(np.asarray(np.bincount(group, weights=sign))[group] == 0)
    ray, z, sign = ray[whole], z[whole], sign[whole]
    inside = np.flatnonzero(np.cumsum(sign)[:-1] > 0)
    bottom, length = z[inside], z[inside + 1] - z[inside]
    count = np.maximum(np.ceil(length), 1.0).astype(np.int64)
    which = np.repeat(np.arange(len(count)), count)
    rank = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    step = (length / count)[which]
    middle = np.column_stack([ray[inside][which] + 0.5, bottom[which] + (rank + 0.5) * step])
    size = np.column_stack([np.ones((len(which), 2)), step])
    return np.stack([middle, size])

"""What is soft, handed to the core: layers over hard frames, and the samples that press on them.

Only worlds in which something is soft have any of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.skin_samples import skin_samples
from halfphysics.body.soft_skin import SoftSkin, soft_core
from halfphysics.geometry.contact_pieces import joined as joined_pieces
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_solids import convex_hull
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.surface_samples import SurfaceSamples, surface_samples

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.body.rigid_parts import Part
    from halfphysics.scene.articulated import LinkGeom
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.scene import Scene
    from halfphysics.scene.soft import Soft
    from halfphysics.settings import Settings

Array = NDArray[np.float64]

#: Samples of a piece that are inside another piece of the object, or so near, are no surface [m].
INNER = 1e-3


def anything_soft(scene: Scene, settings: Settings) -> bool:
    """Whether a world has a soft layer, or soft skin."""
    layers = [s.soft for s in scene.statics.values()] + [o.soft for o in scene.objects.values()]
    return any(layer is not None for layer in layers) or settings.soft_skin is not False


def skin_of(settings: Settings) -> SoftSkin | None:
    """The soft skin that settings ask for; None: people are hard."""
    if isinstance(settings.soft_skin, SoftSkin):
        return settings.soft_skin
    return SoftSkin() if settings.soft_skin else None


def layer_arguments(soft: Soft) -> tuple[str, float, float, float, float, float, float]:
    """The first arguments of the core's calls, in their order."""
    foam = (soft.densification, soft.hysteresis, soft.recovery)
    none = (0.0, 0.0, 1.0)
    return (
        soft.law,
        soft.thickness,
        soft.stiffness,
        soft.damping,
        *(foam if soft.law == "foam" else none),
    )


def set_soft_static(core: Any, static: Static) -> None:
    """The layer of the static that was added last, if it has one."""
    soft, made = static.soft, static.soft_frame
    if soft is None or made is None:
        return
    corners = np.zeros((0, 3))
    if isinstance(made.frame, Mesh):
        corners = np.minimum(made.corner_thickness(), soft.thickness)
    core.set_soft_static(*layer_arguments(soft), np.ascontiguousarray(corners))


def set_samples(core: Any, samples: SurfaceSamples) -> None:
    """The samples of the rigid shape that was added last."""
    core.set_samples(
        np.ascontiguousarray(samples.points),
        np.ascontiguousarray(samples.normals),
        np.ascontiguousarray(samples.areas),
    )


def set_soft_piece(core: Any, item: Object, number: int) -> None:
    """Layer and samples of the piece of an object that was added last."""
    if item.soft is not None:
        core.set_soft_shape(*layer_arguments(item.soft))
    set_samples(core, object_samples(item)[number].moved(np.eye(3), -np.asarray(item.com)))


def set_link_samples(core: Any, geom: LinkGeom) -> None:
    """The samples of the solid of a link that was added last."""
    samples = surface_samples(geom.shape)
    set_samples(core, samples.moved(rot.to_matrix(geom.quaternion), np.asarray(geom.position)))


def set_part_samples(core: Any, part: Part) -> None:
    """The samples of the rigid part of a person that was added last: of its hull."""
    set_samples(core, surface_samples(Mesh(*convex_hull(part.vertices, "part"))))


def set_skin_samples(core: Any, person: int, body: Body, settings: Settings) -> None:
    """The samples of a person's skin, and the soft tissue above its core."""
    samples, skin = skin_samples(body), skin_of(settings)
    count = len(samples)
    thickness, stiffness, damping = np.zeros(count), np.zeros(count), np.zeros(count)
    if skin is not None:
        thickness = soft_core(body, skin).thickness[samples.vertex]
        modulus = body.weights[samples.vertex] @ skin.by_part()[1]
        some = thickness > 0.0
        stiffness[some] = modulus[some] / thickness[some]
        damping = skin.damping_time * stiffness
    core.set_skin_samples(
        person,
        np.ascontiguousarray(samples.vertex, dtype=np.int32),
        samples.area,
        np.ascontiguousarray(samples.normal),
        np.ascontiguousarray(samples.part, dtype=np.int32),
        thickness,
        stiffness,
        damping,
    )


_known: WeakKeyDictionary[Object, tuple[SurfaceSamples, ...]] = WeakKeyDictionary()


def object_samples(item: Object) -> tuple[SurfaceSamples, ...]:
    """Samples of an object's pieces, in its frame: points of their hard surface, made once.

    Of a soft object they lie under its unloaded surface, with the areas of that.
    """
    if item not in _known:
        _known[item] = _made(item)
    return _known[item]


def _made(item: Object) -> tuple[SurfaceSamples, ...]:
    pieces = item.pieces
    if item.soft is None:
        return tuple(_outer(pieces, k) for k in range(len(pieces)))
    outside = surface_samples(item.true_shape)
    t = item.soft.thickness
    under = SurfaceSamples(outside.points - t * outside.normals, outside.normals, outside.areas)
    if len(pieces) == 1:
        return (under,)
    far = np.stack([_distance(piece, under.points) for piece in pieces])
    nearest = far.argmin(axis=0)
    return tuple(under[nearest == k] for k in range(len(pieces)))


def _outer(pieces: Sequence[Shape], number: int) -> SurfaceSamples:
    """Samples of a piece that are on the surface of all of them together."""
    samples = surface_samples(pieces[number])
    outside = samples.points + INNER * samples.normals
    free = np.ones(len(samples), dtype=bool)
    for k, other in enumerate(pieces):
        if k != number:
            free &= other.depth(outside) <= 0.0
    return samples[free]


def _distance(piece: Shape, points: Array) -> Array:
    """Of points (n, 3) from a piece, 0 inside (n,) [m]."""
    mesh = joined_pieces([piece])
    far = mesh.query.closest(points)[0]
    return np.where(mesh.query.inside(points), 0.0, far)

"""The surfaces that can hold a person up: static, kinematic and resting things of a scene.

A thing that moves freely holds nobody up by itself: what it exerts is its contact impulses, which
the simulation knows. Where it rests on something fixed it passes on what stands on it, so it is a
surface in those frames. So is a fixed link of an articulated object; its other links are not. In
a result soft layers are no surfaces either: what they carry is known.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.geometry.shape_base import Shape
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.material_pairs import PERSON
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.support.known_forces import soft_things

if TYPE_CHECKING:
    from halfphysics.results.contacts import Contacts
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface:
    """A shape of a scene and its poses.

    Attributes:
        name: As in `Result.names`.
        shape: In its own frame.
        position: Of its frame in the world (T or 1, 3) [m].
        quaternion: World from its frame (T or 1, 4).
        friction: Coefficient with each part of a person (55,); nan: they pass through each other.
        holds: Frames in which it can hold somebody up (T,); None: all.
    """

    name: str
    shape: Shape
    position: Array
    quaternion: Array
    friction: Array
    holds: Mask | None = None

    @cached_property
    def _turn(self) -> Array:
        """World from its frame (T or 1, 3, 3)."""
        return rot.to_matrix(self.quaternion)

    def local(self, points: Array, frames: NDArray[np.integer]) -> Array:
        """Points of the world (n, 3) in its frame, in frames (n,)."""
        if len(self.position) == 1:
            # Not a matrix product: threads of the library would cost more than they save.
            found: Array = np.einsum("ji,nj->ni", self._turn[0], points - self.position[0])
            return found
        away = points - self.position[frames]
        result: Array = np.einsum("nji,nj->ni", self._turn[frames], away)
        return result

    def world(self, vectors: Array, frames: NDArray[np.integer]) -> Array:
        """Vectors of its frame (n, 3) in the world, in frames (n,)."""
        if len(self.position) == 1:
            found: Array = np.einsum("ij,nj->ni", self._turn[0], vectors)
            return found
        result: Array = np.einsum("nij,nj->ni", self._turn[frames], vectors)
        return result

    def origin(self, frames: NDArray[np.integer]) -> Array:
        """Its origin in the world (n or 1, 3) [m], in frames (n,)."""
        return self.position if len(self.position) == 1 else self.position[frames]


def surfaces_of(
    scene: Scene,
    tracks: Mapping[str, Any],
    names: tuple[str, ...],
    contacts: Contacts | None,
    frames: int,
) -> list[Surface]:
    """The surfaces of a scene.

    Args:
        scene: Statics, objects and articulated objects.
        tracks: Poses (`ObjectTrack`) of objects and links by name; those without one are at their
            start.
        names, contacts: Of the result, which say in which frames an object rests on something
            fixed. None: every object counts as resting.
        frames: T.
    """
    known = set() if contacts is None else soft_things(scene)
    found = [
        _surface(scene, name, name, static.shape, static.position[None], static.quaternion[None])
        for name, static in scene.statics.items()
        if name not in known
    ]
    resting = {} if contacts is None else _resting(scene, names, contacts, frames)
    for name, item in scene.objects.items():
        if name in known:
            continue
        position, quaternion = _poses(item, tracks.get(name))
        holds = None
        if contacts is not None and not isinstance(item, KinematicObject):
            holds = resting[name]
            if not holds.any():
                continue
        found.append(_surface(scene, name, name, item.true_shape, position, quaternion, holds))
    for jointed in scene.articulated.values():
        for name, link in zip(jointed.link_names, jointed.links, strict=True):
            if not link.fixed or name not in tracks:
                continue
            position, quaternion = _poses(link, tracks[name])
            for geom in link.geoms:
                place = position + rot.rotate(
                    quaternion, np.broadcast_to(geom.position, position.shape)
                )
                turn = rot.multiply(quaternion, np.broadcast_to(geom.quaternion, quaternion.shape))
                found.append(_surface(scene, name, jointed.name, geom.shape, place, turn))
    return [surface for surface in found if not np.isnan(surface.friction).all()]


def _surface(
    scene: Scene,
    name: str,
    owner: str,
    shape: Shape,
    position: Array,
    quaternion: Array,
    holds: Mask | None = None,
) -> Surface:
    parts = [f"{PERSON}/{part}" for part in JOINT_NAMES]
    friction = [
        np.nan if scene.ignores(part, owner) else scene.friction_of(part, owner) for part in parts
    ]
    return Surface(
        name=name,
        shape=shape,
        position=np.asarray(position, dtype=np.float64),
        quaternion=rot.normalize(quaternion),
        friction=np.array(friction),
        holds=holds,
    )


def _poses(item: Any, track: Any) -> tuple[Array, Array]:
    source = item if track is None else track
    return np.atleast_2d(source.position), np.atleast_2d(source.quaternion)


def _resting(
    scene: Scene, names: tuple[str, ...], contacts: Contacts, frames: int
) -> dict[str, Mask]:
    """Frames (T,) in which each object touches something fixed, or something that does."""
    fixed = {*scene.statics}
    fixed |= {name for name, item in scene.objects.items() if isinstance(item, KinematicObject)}
    fixed |= {
        name
        for item in scene.articulated.values()
        for name, link in zip(item.link_names, item.links, strict=True)
        if link.fixed
    }
    held = np.zeros((frames, len(names)), dtype=bool)
    held[:, [i for i, name in enumerate(names) if name in fixed]] = True
    between = contacts[(contacts.subject >= 0) & contacts.impulse.any(axis=1)]
    for _ in range(len(scene.objects)):  # the longest chain
        before = held.sum()
        one = held[between.frame, between.subject] | held[between.frame, between.other]
        np.logical_or.at(held, (between.frame, between.subject), one)
        np.logical_or.at(held, (between.frame, between.other), one)
        if held.sum() == before:
            break
    if frames > 1:  # contacts of (t - 1, t]: the first frame has none
        held[0] = held[1]
    return {name: held[:, names.index(name)] for name in scene.objects}

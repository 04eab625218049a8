"""The solids of a scene that measures use, and their poses over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations
from halfphysics.base.arrays import array_of
from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.geometry.shape_base import Shape
from halfphysics.metrics.argument_checks import Array
from halfphysics.scene.material_pairs import PERSON
from halfphysics.scene.scene import Scene

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.scene.articulated import Link

Track = TypeVar("Track")

#: A shape, its positions (T or 1, 3) [m] and quaternions (T or 1, 4).
Solid = tuple[Shape, Array, Array]


def links_of(scene: Scene) -> dict[str, tuple[str, Link]]:
    """Links by their names in results: name of the articulated object, and the link."""
    return {
        name: (item.name, link)
        for item in scene.articulated.values()
        for name, link in zip(item.link_names, item.links, strict=True)
    }


def known_tracks(scene: Scene, objects: Mapping[str, Track]) -> dict[str, Track]:
    """The tracks of a result's objects and links that its scene has.

    A result from a file whose scene lacks a mesh, one that is gone or came from memory, still has
    the track: nothing can be measured from it.
    """
    links = links_of(scene)
    return {name: its for name, its in objects.items() if name in scene.objects or name in links}


def known_contacts(result: Result) -> NDArray[np.bool_]:
    """Which rows of ``result.contacts`` (n,) are of people and of what the scene has.

    As `known_tracks`: nothing is known of what a scene from a file lacks but its name.
    """
    scene = result.scene
    names = {*scene.statics, *scene.objects, *links_of(scene), *(p.name for p in result.people)}
    # -1, no object, is the last one.
    known = np.array([*(name in names for name in result.names), True])
    mask: NDArray[np.bool_] = known[result.contacts.subject] & known[result.contacts.other]
    return mask


def tracks_of(
    scene: Scene, objects: Mapping[str, Any], frames: int, what: str = "objects"
) -> dict[str, tuple[Array, Array]]:
    """Positions (T, 3) [m] and quaternions (T, 4) of objects and links by name, checked.

    `what` is the argument in messages.

    Raises:
        InputError: No mapping; no such object; no track, or one of another length.
    """
    if not isinstance(objects, Mapping):
        raise InputError(
            f"{what}: expected names and tracks, as in result.objects, found {shown(objects)}"
        )
    tracks, links = {}, links_of(scene)
    for name, track in objects.items():
        if name not in scene.objects and name not in links:
            known = ", ".join([*scene.objects, *links]) or "none"
            raise InputError(f"{what}: the scene has no object {name!r}; it has: {known}")
        if not (hasattr(track, "position") and hasattr(track, "quaternion")):
            raise InputError(
                f"{what}: {name!r}: expected a track with position and quaternion, as in "
                f"result.objects, found {shown(track)}"
            )
        position = np.asarray(array_of(track.position), dtype=np.float64)
        quaternion = np.asarray(array_of(track.quaternion), dtype=np.float64)
        if position.shape != (frames, 3) or quaternion.shape != (frames, 4):
            raise InputError(
                f"{what}: {name!r}: expected position ({frames}, 3) and quaternion ({frames}, 4) "
                f"for a motion of {frames} frames, found {position.shape} and {quaternion.shape}"
            )
        tracks[name] = position, rotations.normalize(quaternion)
    return tracks


def solids_of(
    scene: Scene, tracks: Mapping[str, tuple[Array, Array]], *, visible: bool = False
) -> dict[str, list[Solid]]:
    """Solids that a person can penetrate, by name; a link has one solid per geom.

    Of what is soft, the hard frame; `visible`: the surface that nothing presses.

    The statics, and the objects and links with a track, except those that people ignore.
    """
    links = links_of(scene)
    found: dict[str, list[Solid]] = {
        name: [
            (
                static.shape if visible else static.frame,
                static.position[None],
                static.quaternion[None],
            )
        ]
        for name, static in scene.statics.items()
        if not scene.ignores(name, PERSON)
    }
    for name, (position, turn) in tracks.items():
        whole, link = links.get(name, (name, None))
        if scene.ignores(whole, PERSON):
            continue
        if link is None:
            item = scene.objects[name]
            shape = item.true_shape if visible or item.soft is None else item.frame
            found[name] = [(shape, position, turn)]
            continue
        found[name] = []
        for geom in link.geoms:
            shift = np.broadcast_to(geom.position, position.shape)
            own = np.broadcast_to(geom.quaternion, turn.shape)
            place = position + rotations.rotate(turn, shift)
            found[name].append((geom.shape, place, rotations.multiply(turn, own)))
    return found

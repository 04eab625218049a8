"""Collision shapes of a scene's items, for independent judges: convex solids in their frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shape_base import Shape


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex shape at `position` (3,) and `turn` (3, 3) in the frame of its item."""

    shape: Shape
    position: np.ndarray
    turn: np.ndarray

    def at(self, position, turn):
        """The solid's pose, for an item at position (..., 3) and turn (..., 3, 3): the same two."""
        return position + (turn @ self.position[:, None])[..., 0], turn @ self.turn


def owners(scene):
    """The owner of every name in a result: an object itself, a link's articulated object."""
    links = {n: thing.name for thing in scene.articulated.values() for n in thing.link_names}
    return {**{name: name for name in scene.objects}, **links}


def fixed_links(scene):
    """Names of the links without a joint."""
    things = scene.articulated.values()
    return {n for t in things for n, link in zip(t.link_names, t.links, strict=True) if link.fixed}


def solids_of(scene, name):
    """The solids of an object: its pieces. Of a link ("NAME/LINK"): its geoms."""
    if name in scene.objects:
        return [Solid(piece, np.zeros(3), np.eye(3)) for piece in scene.objects[name].pieces]
    thing = scene.articulated[owners(scene)[name]]
    link = dict(zip(thing.link_names, thing.links, strict=True))[name]
    return [Solid(g.shape, np.array(g.position), rot.to_matrix(g.quaternion)) for g in link.geoms]

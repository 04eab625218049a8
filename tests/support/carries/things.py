"""The things that are carried: solids, where hands hold them, what they stand on.

A thing's own frame is at its `middle`, x away from the person, y to the person's left, z up. Its
solids touch and do not overlap, so their distances are exact outside and the mesh is closed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import trimesh

from support import short_rows as rows

#: Density that the OMOMO reader assumes [kg/m^3], and the most that two hands or one carry [kg].
DENSITY = 400.0
MOST = {2: 6.0, 1: 0.5}
#: A recorded thing rests this high over its support [m]: the simulator starts without overlap.
REST = 0.001
#: The hands wait this far from where they hold: nearby, and before they come [m].
NEAR, OUT = 0.05, 0.11


#: Sides of the meshes of cylinders.
_SIDES = 64


@dataclass(frozen=True)
class Solid:
    """A box of `size` (3,), a cylinder of (radius, length) along `axis`, or a sphere (radius,)."""

    kind: str
    size: tuple[float, ...]
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: int = 2

    def distance(self, points):
        """Signed distances (...,) of points (..., 3) in the thing's frame [m]."""
        p = np.asarray(points) - self.at
        if self.kind == "sphere":
            return rows.length(p) - self.size[0]
        if self.kind == "box":
            off = np.abs(p) - 0.5 * np.asarray(self.size)
        else:
            across = rows.length(np.delete(p, self.axis, axis=-1)) - self.size[0]
            off = np.stack([across, np.abs(p[..., self.axis]) - 0.5 * self.size[1]], axis=-1)
        outside = rows.length(np.maximum(off, 0.0))
        return outside + np.minimum(rows.largest(off), 0.0)

    @property
    def mesh(self) -> trimesh.Trimesh:
        if self.kind == "box":
            out = trimesh.creation.box(self.size)
        elif self.kind == "sphere":
            out = trimesh.creation.uv_sphere(self.size[0], count=[48, 48])
        else:
            out = trimesh.creation.cylinder(self.size[0], self.size[1], sections=_SIDES)
            if self.axis == 1:
                # A facet below, not an edge: it does not roll.
                facet = trimesh.transformations.rotation_matrix(np.pi / _SIDES, [0, 0, 1])
                lying = trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
                out.apply_transform(lying @ facet)
        out.apply_translation(self.at)
        return out

    @property
    def low(self) -> float:
        half = self.size[-1] * (1.0 if self.kind == "sphere" else 0.5)
        if self.kind == "cylinder" and self.axis == 1:
            half = self.size[0] * float(np.cos(np.pi / _SIDES))
        return self.at[2] - half


@dataclass(frozen=True)
class Grasp:
    """How one hand holds a thing, in the thing's frame.

    Attributes:
        point: Where the middle of the palm aims at (3,) [m].
        facing: The palm's normal, toward the thing (3,).
        fingers: Directions of the fingers that may be chosen.
        ready: From the place of the hold to where the hand waits at first (3,) [m].
        radius: Of the round part that the fingers close around [m]; None: a flat hand.
    """

    point: tuple[float, float, float]
    facing: tuple[float, float, float]
    fingers: tuple[tuple[float, float, float], ...]
    ready: tuple[float, float, float]
    radius: float | None = None


@dataclass(frozen=True)
class Thing:
    """A thing, its grasps by side, and the boxes it stands on: (size, centre from below the thing).

    `stand`: height of its support [m], 0 the floor; `boxes`: (width x, width y, at x, at y) each.
    """

    name: str
    solids: tuple[Solid, ...]
    grasps: dict[str, Grasp]
    stand: float = 0.0
    boxes: tuple[tuple[float, float, float, float], ...] = ()
    lateral: float = 0.0

    def distance(self, points):
        """Signed distances of points (..., 3) in its frame [m]; exact outside."""
        return np.min([solid.distance(points) for solid in self.solids], axis=0)

    @property
    def low(self) -> float:
        """Its lowest point in its frame [m]."""
        return min(solid.low for solid in self.solids)

    @cached_property
    def mesh(self) -> trimesh.Trimesh:
        return trimesh.util.concatenate([solid.mesh for solid in self.solids])

    @property
    def mass(self) -> float:
        """[kg]"""
        return min(DENSITY * float(self.mesh.volume), MOST[len(self.grasps)])


def _angles(*degrees):
    """Directions ahead, so many degrees below the horizontal."""
    return tuple((float(np.cos(a)), 0.0, float(-np.sin(a))) for a in np.radians(degrees))


def _sides(y, z=0.0, x=0.0):
    """Two flat palms at the left and right side."""
    return {
        side: Grasp(
            (x, left * y, z), (0.0, -left, 0.0), _angles(-10, 10, 30, 50, 70),
            (-0.05, left * OUT, 0.20),
        )
        for side, left in (("left", 1.0), ("right", -1.0))
    }  # fmt: skip


def _below(y, z, x=0.0):
    """Two flat palms under the overhanging left and right."""
    out = {}
    for side, left in (("left", 1.0), ("right", -1.0)):
        turns = np.radians([-20.0, 0.0, 20.0, 40.0])
        fingers = tuple((float(np.cos(a)), float(-left * np.sin(a)), 0.0) for a in turns)
        out[side] = Grasp((x, left * y, z), (0.0, 0.0, 1.0), fingers, (-0.08, left * 0.16, -0.06))
    return out


def _around(radius, z=0.0):
    """The right hand closed around an upright round part, palm to the left."""
    turns = np.radians([-50.0, -30.0, -10.0, 10.0])
    fingers = tuple((float(np.cos(a)), float(np.sin(a)), 0.0) for a in turns)
    return {"right": Grasp((0.0, 0.0, z), (0.0, 1.0, 0.0), fingers, (-0.06, -0.15, 0.06), radius)}


def _on_top(radius):
    """The right hand closed from above around a bar that lies across."""
    return {
        "right": Grasp(
            (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), _angles(-20, 0, 20, 40), (-0.08, 0.0, 0.15), radius
        )
    }


def _legs(x, y, length, below, side=0.04):
    return tuple(
        Solid("box", (side, side, length), (i * x, j * y, below - 0.5 * length))
        for i in (-1, 1)
        for j in (-1, 1)
    )


def _box(*size, at=(0.0, 0.0, 0.0)):
    return Solid("box", tuple(size), at)


def _round(radius, length, at=(0.0, 0.0, 0.0), axis=2):
    return Solid("cylinder", (radius, length), at, axis)


def _one(width_x, width_y):
    return ((width_x, width_y, 0.0, 0.0),)


_ALL = (
    Thing("suitcase", (_box(0.36, 0.25, 0.50),), _sides(0.125, 0.05), 0.50, _one(0.30, 0.25)),
    Thing("largebox", (_box(0.34, 0.40, 0.36),), _sides(0.20, 0.05), 0.45, _one(0.32, 0.36)),
    Thing("smallbox", (_box(0.25, 0.28, 0.22),), _sides(0.14), 0.70, _one(0.24, 0.26)),
    Thing(  # from behind, by its back
        "chair",
        (
            _box(0.40, 0.40, 0.05),
            _box(0.05, 0.40, 0.42, at=(-0.175, 0.0, 0.235)),
            *_legs(0.17, 0.17, 0.42, -0.025),
        ),
        _sides(0.20, 0.20, -0.175),
    ),
    Thing(  # with a drawer under its top
        "smalltable",
        (_box(0.40, 0.46, 0.10), *_legs(0.17, 0.20, 0.58, -0.05)),
        _sides(0.23, 0.0, -0.04),
    ),
    Thing("tray", (_box(0.32, 0.56, 0.03),), _below(0.20, -0.015, -0.11), 1.0, _one(0.22, 0.16)),
    Thing("bowl", (_round(0.14, 0.13),), _sides(0.14), 0.80, _one(0.20, 0.20)),
    Thing("ball", (Solid("sphere", (0.14,)),), _sides(0.14), 0.75, _one(0.20, 0.20)),
    Thing("trashcan", (_round(0.15, 0.42),), _sides(0.15, 0.06), 0.40, _one(0.25, 0.25)),
    Thing(
        "monitor",
        (_box(0.12, 0.50, 0.32), _box(0.22, 0.26, 0.03, at=(0.0, 0.0, -0.175))),
        _sides(0.25),
        0.72,
        _one(0.28, 0.36),
    ),
    Thing("glass", (_round(0.035, 0.13),), _around(0.035), 0.90, _one(0.14, 0.14), -0.26),
    Thing(
        "bottle",
        (_round(0.036, 0.20), _round(0.015, 0.07, at=(0.0, 0.0, 0.135))),
        _around(0.036),
        0.85,
        _one(0.14, 0.14),
        -0.26,
    ),
    Thing("mug", (_round(0.042, 0.13),), _around(0.042), 0.95, _one(0.15, 0.15), -0.26),
    Thing(
        "lid",
        (_round(0.028, 0.11), _round(0.10, 0.014, at=(0.0, 0.0, -0.062))),
        _around(0.028, 0.005),
        0.90,
        _one(0.20, 0.20),
        -0.28,
    ),
    Thing(
        "bar",
        (_round(0.025, 0.50, axis=1),),
        _on_top(0.025),
        0.85,
        ((0.10, 0.08, 0.0, 0.18), (0.10, 0.08, 0.0, -0.18)),
        -0.24,
    ),
)
#: Every thing by its name, those of two hands first.
THINGS = {thing.name: thing for thing in _ALL}

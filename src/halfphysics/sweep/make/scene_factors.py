"""Factors of a scene: mass, friction, size and place of its items. The given scene is unchanged;
the new scene shares every item that no factor changes.

Angles are in degrees, lengths in metres, masses in kilograms; docs/sweeps.md explains each factor.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.suggestions import did_you_mean
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.articulated import Articulated
from halfphysics.scene.items import Object, Static, fixed
from halfphysics.scene.scene import Scene
from halfphysics.scene.trajectories import KinematicObject, start_velocity
from halfphysics.sweep.make.kept import Kept
from halfphysics.sweep.make.scaled import lowest, scaled_object, scaled_static, weighing
from halfphysics.sweep.make.standing import Support, supports
from halfphysics.sweep.plan.factors import OFFSETS, FactorName
from halfphysics.sweep.plan.values import Value

Array = NDArray[np.float64]
Item: TypeAlias = Static | Object
_WEIGHTS = ("mass", "mass_factor")
#: Groups of factors: of all items of a kind, then of one item, which has priority.
_GROUPS = (("objects", "statics"), ("object", "static"))

#: The factors of one item: X of `object.NAME.X` -> its number.
Said: TypeAlias = dict[str, float]


class SceneFactors:
    """Scenes in many variants; caches the last few sizes, and which item supports which."""

    def __init__(self) -> None:
        # The values hold the source item or scene, as the keys are ids.
        self._sizes: Kept[tuple[Item, Item, float]] = Kept(32)
        self._supports: Kept[tuple[Scene, Mapping[str, Support]]] = Kept(4)

    def varied(self, scene: Scene, factors: Mapping[str, Value]) -> Scene:
        """A new scene with the factors of items applied (other factors are ignored).

        Raises:
            InputError: A factor names no item of this scene, or has an impossible value.
        """
        said = said_of(scene, factors)
        items: dict[str, Item | Articulated] = {}
        rises: dict[str, float] = {}
        for name, of in said.items():
            item: Item = scene.statics.get(name) or scene.objects[name]
            items[name] = self._changed(item, of)
            rises[name] = of.get("offset_z", 0.0)
        if any("scale" in of or "offset_z" in of for of in said.values()):
            items |= self._carried(scene, items, said, rises)
        return scene._with(items, _frictions(scene, said))

    def _changed(self, item: Item, said: Said) -> Item:
        """An item with its factors applied, before it is raised with its support."""
        factor = said.get("scale", 1.0)
        shift = np.array([said.get(key, 0.0) for key in OFFSETS])
        if factor != 1.0:
            # The lowest point keeps its height, so the item still stands on its support.
            item, foot = self._sized(item, factor)
            shift[2] += foot - factor * foot
        if "friction" in said or "restitution" in said:
            item = replace(
                item,
                friction=said.get("friction", item.friction),
                restitution=said.get("restitution", item.restitution),
            )
        if isinstance(item, Object):
            mass = said.get("mass", item.mass)
            mass *= said.get("mass_factor", 1.0)
            if mass != item.mass:
                item = weighing(item, mass)
        if said.get("yaw", 0.0) != 0.0:
            item = turned(item, np.radians(said["yaw"]))
        return moved(item, shift) if shift.any() else item

    def _sized(self, item: Item, factor: float) -> tuple[Item, float]:
        """A scaled item, and the previous height of its lowest point above its origin [m]."""

        def make() -> tuple[Item, Item, float]:
            if isinstance(item, Static):
                return item, scaled_static(item, factor), lowest(item)
            return item, scaled_object(item, factor), lowest(item)

        return self._sizes.get((id(item), factor), make)[1:]

    def _carried(
        self,
        scene: Scene,
        items: Mapping[str, Any],
        said: Mapping[str, Said],
        rises: dict[str, float],
    ) -> dict[str, Any]:
        """Items raised or lowered with a support whose place or size has changed."""
        found = self._supports.get(id(scene), lambda: (scene, supports(scene)))[1]
        total: dict[str, float] = {}

        def rise(name: str) -> float:
            if name not in total:
                total[name] = rises.get(name, 0.0) + carry(name)
            return total[name]

        def carry(name: str) -> float:
            support = found.get(name)
            if support is None:
                return 0.0
            size = said.get(support.name, {}).get("scale")
            grown = 0.0 if size is None else (size - 1.0) * support.height
            return rise(support.name) + grown

        carried = {}
        for name in found:
            height = carry(name)
            if height != 0.0:
                every = {**scene.statics, **scene.objects, **scene.articulated}
                item = items.get(name, every[name])
                carried[name] = moved(item, np.array([0.0, 0.0, height]))
        return carried


def said_of(scene: Scene, factors: Mapping[str, Value]) -> dict[str, Said]:
    """The factors of every item of a scene that has any.

    A factor of one item has priority over a factor of all items of its kind.

    Raises:
        InputError: A factor names no item of this scene, or has an impossible value.
    """
    parsed = {factor: FactorName.parse(factor) for factor in factors}
    said: dict[str, Said] = {}
    for groups in _GROUPS:
        for factor, name in parsed.items():
            if name.group in groups and name.bounds is not None:
                name.bounds.check(factor, factors[factor])
                value = float(cast("float", factors[factor]))
                for item in _named(scene, factor, name):
                    said.setdefault(item, {})[name.what] = value
    return said


def _named(scene: Scene, factor: str, name: FactorName) -> Iterable[str]:
    """The names of the items that a factor changes."""
    kind = name.group.removesuffix("s")
    group: Mapping[str, Item] = scene.objects if kind == "object" else scene.statics
    refusals = {n: _refusal(item, name.what) for n, item in group.items()}
    if name.group == kind:
        if name.item not in refusals:
            hint = did_you_mean(name.item, refusals, form=repr, otherwise=".")
            raise InputError(
                f"{factor}: this variant's scene has no {kind} called {name.item!r}{hint} "
                f"It has {_listed(scene)}"
            )
        if refusals[name.item]:
            raise InputError(f"{factor}: {refusals[name.item]}. The scene has {_listed(scene)}")
        return [name.item]
    able = [n for n, refusal in refusals.items() if not refusal]
    if not able:
        raise InputError(
            f"{factor}: this variant's scene has no {kind} of which that can be said. "
            f"It has {_listed(scene)}"
        )
    return able


def _refusal(item: Item, key: str) -> str:
    """The reason why a factor does not apply to an item; empty if it applies."""
    if key in _WEIGHTS and isinstance(item, KinematicObject):
        return f"{item.name!r} is kinematic: nothing pushes it, whatever its mass"
    if key == "scale" and isinstance(item, Static) and isinstance(item.shape, Plane):
        return f"{item.name!r} is a plane, which has no size"
    return ""


def _listed(scene: Scene) -> str:
    groups = {
        "objects": scene.objects,
        "statics": scene.statics,
        "articulated things (no factors)": scene.articulated,
    }
    said = [f"{kind}: {', '.join(items)}" for kind, items in groups.items() if items]
    return "; ".join(said) or "nothing at all"


def _frictions(scene: Scene, said: Mapping[str, Said]) -> dict[tuple[str, str], float]:
    """New frictions of the scene's friction pairs in which a factor changes an item's friction."""
    pairs = {}
    for a, b, _ in scene.friction_pairs:
        told = [said[n]["friction"] for n in (a, b) if "friction" in said.get(n, {})]
        if told:
            pairs[a, b] = min(told)
    return pairs


def moved(item: Any, shift: Array) -> Any:
    """An item translated by `shift` (3,) [m], with its trajectory if it has one."""
    changes = {"position": fixed(item.position + shift)}
    if isinstance(item, KinematicObject):
        changes["positions"] = fixed(item.positions + shift)
    return replace(item, **changes)


def turned(item: Item, angle: float) -> Item:
    """An item rotated by `angle` [rad] about the vertical through its initial origin.

    A trajectory is rotated as a whole; the initial velocity of a free object is unchanged.
    """
    turn = np.array([np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)])
    quaternion = rot.normalize(rot.multiply(turn, item.quaternion))
    if not isinstance(item, KinematicObject):
        return replace(item, quaternion=fixed(quaternion))
    positions = item.position + rot.rotate(turn, item.positions - item.position)
    quaternions = rot.normalize(rot.multiply(turn, item.quaternions))
    velocity, spin = start_velocity(positions, quaternions, item.fps)
    return replace(
        item,
        position=fixed(positions[0]),
        quaternion=fixed(quaternions[0]),
        positions=fixed(positions),
        quaternions=fixed(quaternions),
        velocity=fixed(velocity),
        angular_velocity=fixed(spin),
    )

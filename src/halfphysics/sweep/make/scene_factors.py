"""Factors of a scene: its things lighter, rougher, larger, elsewhere. The scene given stays as it
is; what comes back is a new one that shares every thing that no factor changes.

Angles in degrees, lengths in metres, masses in kilograms; docs/sweeps.md says what each one does.
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
#: Groups of factors: of all things of a kind, then of one, which comes before.
_GROUPS = (("objects", "statics"), ("object", "static"))

#: What is said of one thing: X of `object.NAME.X` -> its number.
Said: TypeAlias = dict[str, float]


class SceneFactors:
    """Scenes in many variants; keeps the last few sizes, and what stands on what."""

    def __init__(self) -> None:
        # With the thing or scene they were made from: the keys are their ids.
        self._sizes: Kept[tuple[Item, Item, float]] = Kept(32)
        self._supports: Kept[tuple[Scene, Mapping[str, Support]]] = Kept(4)

    def varied(self, scene: Scene, factors: Mapping[str, Value]) -> Scene:
        """A new scene with the factors that are about things (other factors are passed over).

        Raises:
            InputError: A factor that names nothing of this scene, or an impossible value.
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
        """A thing as it is said to be, not yet raised by what it stands on."""
        factor = said.get("scale", 1.0)
        shift = np.array([said.get(key, 0.0) for key in OFFSETS])
        if factor != 1.0:
            # What stood on something still does: its lowest point stays at its height.
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
        """A thing in another size, and how far its lowest point was above its origin [m]."""

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
        """What is raised or lowered by what it stands on, which is in another place or size."""
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
    """What the factors say of every thing of a scene that they say anything of.

    What is said of one thing comes before what is said of all of its kind.

    Raises:
        InputError: A factor that names nothing of this scene, or an impossible value.
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
    """The things that a factor is about."""
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
    """Why a factor cannot be said of a thing; empty: it can."""
    if key in _WEIGHTS and isinstance(item, KinematicObject):
        return f"{item.name!r} moves as told and nothing pushes it, whatever its mass"
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
    """Pairs of which the scene says a friction, and a factor says another of one of the two."""
    pairs = {}
    for a, b, _ in scene.friction_pairs:
        told = [said[n]["friction"] for n in (a, b) if "friction" in said.get(n, {})]
        if told:
            pairs[a, b] = min(told)
    return pairs


def moved(item: Any, shift: Array) -> Any:
    """A thing `shift` (3,) [m] away; its trajectory too, if it moves on one."""
    changes = {"position": fixed(item.position + shift)}
    if isinstance(item, KinematicObject):
        changes["positions"] = fixed(item.positions + shift)
    return replace(item, **changes)


def turned(item: Item, angle: float) -> Item:
    """A thing turned about the vertical [rad] through its own origin where it starts.

    A trajectory is turned as a whole; the start velocity of what is free stays as it is.
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

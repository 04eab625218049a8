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
from halfphysics.scene.trajectories import Moving, start_velocity
from halfphysics.sweep.make.kept import Kept
from halfphysics.sweep.make.scaled import lowest, scaled_object, scaled_static, weighing
from halfphysics.sweep.make.standing import Support, supports
from halfphysics.sweep.plan.factors import OFFSETS, FactorName
from halfphysics.sweep.plan.values import Value

Array = NDArray[np.float64]
Thing: TypeAlias = Static | Object
_WEIGHTS = ("mass", "mass_factor")
#: Groups of factors: of all things of a kind, then of one, which comes before.
_GROUPS = (("objects", "statics"), ("object", "static"))

#: What is said of one thing: X of `object.NAME.X` -> its number.
Said: TypeAlias = dict[str, float]


class SceneFactors:
    """Scenes in many variants; keeps the last few sizes, and what stands on what."""

    def __init__(self) -> None:
        # With the thing or scene they were made from: the keys are their ids.
        self._sizes: Kept[tuple[Thing, Thing, float]] = Kept(32)
        self._supports: Kept[tuple[Scene, Mapping[str, Support]]] = Kept(4)

    def varied(self, scene: Scene, factors: Mapping[str, Value]) -> Scene:
        """A new scene with the factors that are about things (other factors are passed over).

        Raises:
            InputError: A factor that names nothing of this scene, or an impossible value.
        """
        said = said_of(scene, factors)
        things: dict[str, Thing | Articulated] = {}
        rises: dict[str, float] = {}
        for name, of in said.items():
            thing: Thing = scene.statics.get(name) or scene.objects[name]
            things[name] = self._changed(thing, of)
            rises[name] = of.get("offset_z", 0.0)
        if any("scale" in of or "offset_z" in of for of in said.values()):
            things |= self._carried(scene, things, said, rises)
        return scene._with(things, _frictions(scene, said))

    def _changed(self, thing: Thing, said: Said) -> Thing:
        """A thing as it is said to be, not yet raised by what it stands on."""
        factor = said.get("scale", 1.0)
        shift = np.array([said.get(key, 0.0) for key in OFFSETS])
        if factor != 1.0:
            # What stood on something still does: its lowest point stays at its height.
            thing, foot = self._sized(thing, factor)
            shift[2] += foot - factor * foot
        if "friction" in said or "restitution" in said:
            thing = replace(
                thing,
                friction=said.get("friction", thing.friction),
                restitution=said.get("restitution", thing.restitution),
            )
        if isinstance(thing, Object):
            mass = said.get("mass", thing.mass)
            mass *= said.get("mass_factor", 1.0)
            if mass != thing.mass:
                thing = weighing(thing, mass)
        if said.get("yaw", 0.0) != 0.0:
            thing = turned(thing, np.radians(said["yaw"]))
        return moved(thing, shift) if shift.any() else thing

    def _sized(self, thing: Thing, factor: float) -> tuple[Thing, float]:
        """A thing in another size, and how far its lowest point was above its origin [m]."""

        def make() -> tuple[Thing, Thing, float]:
            if isinstance(thing, Static):
                return thing, scaled_static(thing, factor), lowest(thing)
            return thing, scaled_object(thing, factor), lowest(thing)

        return self._sizes.get((id(thing), factor), make)[1:]

    def _carried(
        self,
        scene: Scene,
        things: Mapping[str, Any],
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
                thing = things.get(name, every[name])
                carried[name] = moved(thing, np.array([0.0, 0.0, height]))
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
                for thing in _named(scene, factor, name):
                    said.setdefault(thing, {})[name.what] = value
    return said


def _named(scene: Scene, factor: str, name: FactorName) -> Iterable[str]:
    """The things that a factor is about."""
    kind = name.group.removesuffix("s")
    group: Mapping[str, Thing] = scene.objects if kind == "object" else scene.statics
    refusals = {n: _refusal(thing, name.what) for n, thing in group.items()}
    if name.group == kind:
        if name.thing not in refusals:
            hint = did_you_mean(name.thing, refusals, form=repr, otherwise=".")
            raise InputError(
                f"{factor}: this variant's scene has no {kind} called {name.thing!r}{hint} "
                f"It has {_listed(scene)}"
            )
        if refusals[name.thing]:
            raise InputError(f"{factor}: {refusals[name.thing]}. The scene has {_listed(scene)}")
        return [name.thing]
    able = [n for n, refusal in refusals.items() if not refusal]
    if not able:
        raise InputError(
            f"{factor}: this variant's scene has no {kind} of which that can be said. "
            f"It has {_listed(scene)}"
        )
    return able


def _refusal(thing: Thing, key: str) -> str:
    """Why a factor cannot be said of a thing; empty: it can."""
    if key in _WEIGHTS and isinstance(thing, Moving):
        return f"{thing.name!r} moves as told and nothing pushes it, whatever its mass"
    if key == "scale" and isinstance(thing, Static) and isinstance(thing.shape, Plane):
        return f"{thing.name!r} is a plane, which has no size"
    return ""


def _listed(scene: Scene) -> str:
    groups = {
        "objects": scene.objects,
        "statics": scene.statics,
        "articulated things (no factors)": scene.articulated,
    }
    said = [f"{kind}: {', '.join(things)}" for kind, things in groups.items() if things]
    return "; ".join(said) or "nothing at all"


def _frictions(scene: Scene, said: Mapping[str, Said]) -> dict[tuple[str, str], float]:
    """Pairs of which the scene says a friction, and a factor says another of one of the two."""
    pairs = {}
    for a, b, _ in scene.friction_pairs:
        told = [said[n]["friction"] for n in (a, b) if "friction" in said.get(n, {})]
        if told:
            pairs[a, b] = min(told)
    return pairs


def moved(thing: Any, shift: Array) -> Any:
    """A thing `shift` (3,) [m] away; its trajectory too, if it moves on one."""
    changes = {"position": fixed(thing.position + shift)}
    if isinstance(thing, Moving):
        changes["positions"] = fixed(thing.positions + shift)
    return replace(thing, **changes)


def turned(thing: Thing, angle: float) -> Thing:
    """A thing turned about the vertical [rad] through its own origin where it starts.

    A trajectory is turned as a whole; the start velocity of what is free stays as it is.
    """
    turn = np.array([np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)])
    quaternion = rot.normalize(rot.multiply(turn, thing.quaternion))
    if not isinstance(thing, Moving):
        return replace(thing, quaternion=fixed(quaternion))
    positions = thing.position + rot.rotate(turn, thing.positions - thing.position)
    quaternions = rot.normalize(rot.multiply(turn, thing.quaternions))
    velocity, spin = start_velocity(positions, quaternions, thing.fps)
    return replace(
        thing,
        position=fixed(positions[0]),
        quaternion=fixed(quaternions[0]),
        positions=fixed(positions),
        quaternions=fixed(quaternions),
        velocity=fixed(velocity),
        angular_velocity=fixed(spin),
    )

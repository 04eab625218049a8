"""A scene with other masses and frictions: what a user turns while a simulation runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from halfphysics.base.validation import number
from halfphysics.errors import InputError
from halfphysics.scene.articulated import Articulated
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene


def changed(base: Scene, masses: Mapping[str, float], frictions: Mapping[str, float]) -> Scene:
    """A copy of a scene with other masses and frictions; the same scene if none is given.

    Args:
        base: The scene; it stays as it is.
        masses: Name of an object -> its mass [kg]; of an articulated object: of all its links.
        frictions: Name of an item of the scene -> its friction.

    Raises:
        InputError: An impossible value, or a name that the scene does not have.
    """
    if not masses and not frictions:
        return base
    scene = base._copied()
    for name, value in masses.items():
        what = f"mass of {name!r}"
        mass = number(value, what, above=0.0, unit="kg")
        if name in movable(base):
            _put(scene, _heavier(movable(base)[name], mass))
        else:
            _refuse(what, movable(base))
    for name, value in frictions.items():
        what = f"friction of {name!r}"
        mu = number(value, what, least=0.0)
        items: dict[str, Any] = {**scene.statics, **scene.objects, **scene.articulated}
        if name not in items:
            _refuse(what, items)
        _put(scene, replace(items[name], friction=mu))
    return scene


def movable(scene: Scene) -> dict[str, Any]:
    """Name -> free or articulated object: those whose mass has an effect."""
    free = {n: o for n, o in scene.objects.items() if not isinstance(o, KinematicObject)}
    return {**free, **scene.articulated}


def mass_of(item: Any) -> float:
    """Mass of a free object, or of the movable links of an articulated object [kg]."""
    return float(item.mass)


def _heavier(item: Any, mass: float) -> Any:
    if isinstance(item, Articulated):
        return item.weighing(mass)
    return replace(item, mass=mass, inertia=item.inertia * (mass / item.mass))


def _put(scene: Scene, item: Any) -> None:
    """Replace an item in its group; the order of names stays."""
    for group in (scene._statics, scene._objects, scene._articulated):
        if item.name in group:
            group[item.name] = item


def _refuse(what: str, items: Mapping[str, Any]) -> None:
    raise InputError(f"{what}: found none, expected one of {', '.join(items) or 'nothing'}")

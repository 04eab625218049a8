"""Material pairs: friction, restitution and ignoring of any two rows, handed to the core."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.scene.items import PERSON_FRICTION
from halfphysics.scene.material_pairs import PERSON, ends, of_person
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.names import Names

Array = NDArray[np.float64]


def set_pairings(core: Any, scene: Scene, settings: Settings, names: Names) -> None:
    """Give the core the table of material pairs; rows as `Names.in_scene`."""
    rows = names.in_scene
    friction, restitution, ignore = _by_item(scene, rows)
    for a, b in _apart(scene, set(rows)):
        at = np.ix_(_rows_of(rows, a), _rows_of(rows, b))
        friction[at], ignore[at] = scene.friction_of(a, b), scene.ignores(a, b)
    # Two that contact cannot push do not meet: statics and trajectories, and trajectories and
    # people whose poses are set.
    trajectories = {n for n, item in scene.objects.items() if isinstance(item, KinematicObject)}
    set_ = trajectories | ({PERSON, *names.parts} if settings.drive.poses else set())
    for unmoved in (trajectories | set(scene.statics), set_):
        among = np.array([row in unmoved for row in rows], dtype=bool)
        ignore[np.ix_(among, among)] = 1.0
    # Links of one articulated object pass through each other; an item does not meet itself.
    number = {name: i for i, name in enumerate(dict.fromkeys(rows))}
    item = np.array([-1 if of_person(name) else number[name] for name in rows], dtype=np.int64)
    own = (item[:, None] == item) & (item >= 0)
    friction[own] = restitution[own] = 0.0
    ignore[own] = 1.0
    alone = np.flatnonzero(item >= 0)
    ignore[alone, alone] = 0.0
    core.set_pairings(friction, restitution, ignore)


def friction_rows(scene: Scene, names: Names) -> tuple[Array, NDArray[np.bool_]]:
    """Friction that each row has of its own (rows,), and pairs that have another (rows, rows)."""
    rows = names.in_scene
    own = np.diagonal(_by_item(scene, rows)[0]).copy()
    number = {name: i for i, name in enumerate(dict.fromkeys(rows))}
    item = np.array([-1 if of_person(name) else number[name] for name in rows], dtype=np.int64)
    apart = (item[:, None] == item) & (item[:, None] >= 0)
    for a, b in _apart(scene, set(rows)):
        apart[np.ix_(_rows_of(rows, a), _rows_of(rows, b))] = True
    return own, apart


def _by_item(scene: Scene, rows: list[str]) -> tuple[Array, Array, Array]:
    """Friction, restitution and ignoring (rows, rows) by what each item has of its own."""
    items: dict[str, Any] = {**scene.statics, **scene.objects, **scene.articulated}
    person = [of_person(name) for name in rows]
    own = [
        PERSON_FRICTION if is_person else float(items[name].friction)
        for name, is_person in zip(rows, person, strict=True)
    ]
    bounce = [
        0.0 if is_person else float(items[name].restitution)
        for name, is_person in zip(rows, person, strict=True)
    ]
    shape = len(rows), len(rows)
    friction = np.minimum.outer(own, own).reshape(shape)
    return friction, np.maximum.outer(bounce, bounce).reshape(shape), np.zeros(shape)


def _apart(scene: Scene, rows: set[str]) -> set[tuple[str, str]]:
    """Pairs of rows that a pair of the scene may speak of."""
    named = {frozenset((a, b)) for a, b, _ in scene.friction_pairs}
    named |= {frozenset(pair) for pair in scene.ignored_pairs}
    pairs = set()
    for pair in named:
        a, b = ends(pair)
        # A pair with all parts of people is one with each part that is set apart.
        for x in _meant(a, rows):
            for y in _meant(b, rows):
                if x != y or of_person(x):
                    pairs |= {(x, y), (y, x)}
    return pairs


def _meant(name: str, rows: set[str]) -> set[str]:
    return {row for row in rows if of_person(row)} if name == PERSON else {name} & rows


def _rows_of(rows: list[str], name: str) -> list[int]:
    return [i for i, row in enumerate(rows) if row == name]

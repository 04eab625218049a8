"""Material pairs: friction, restitution and ignoring of any two rows, handed to the core."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.scene.material_pairs import PERSON, of_person
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.names import Names


def set_pairings(core: Any, scene: Scene, settings: Settings, names: Names) -> None:
    """Give the core the table of material pairs; rows as `Names.in_scene`."""
    rows = names.in_scene
    shape = len(rows), len(rows)
    friction, restitution, ignore = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    # Two that contact cannot push do not meet: statics and trajectories, and trajectories and
    # people whose poses are set.
    trajectories = {n for n, item in scene.objects.items() if isinstance(item, KinematicObject)}
    unmoved = trajectories | set(scene.statics)
    set_ = trajectories | ({PERSON, *names.parts} if settings.drive.poses else set())
    for i, a in enumerate(rows):
        for j, b in enumerate(rows):
            if a == b and not of_person(a):
                ignore[i, j] = i != j  # links of one articulated object; an item and itself
                continue
            friction[i, j] = scene.friction_of(a, b)
            restitution[i, j] = scene.restitution_of(a, b)
            both = {a, b}
            ignore[i, j] = scene.ignores(a, b) or both <= unmoved or both <= set_
    core.set_pairings(friction, restitution, ignore)

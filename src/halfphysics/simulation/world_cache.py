"""World cache: a world used again for a scene whose items have the same shapes.

Building a world takes time mostly for its people: their parts are compiled, the hulls of their skin
handed to the core. None of it depends on masses, friction and starts of objects, and little on
settings.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.settings import HALF_PHYSICS
from halfphysics.simulation.compiled_model import armature_of, model_arrays
from halfphysics.simulation.core_settings import set_settings
from halfphysics.simulation.joined_model import join_model
from halfphysics.simulation.names import parts_set_apart
from halfphysics.simulation.pairing import set_pairings

if TYPE_CHECKING:
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.world import World

#: Settings that a world is made for: what touches, what the drive can exert, and how far joints go.
FIXED = ("contact", "self_contact", "weight", "blocked", "strength", "joint_limits", "soft_skin")


def use_again(world: World, scene: Scene, settings: Settings) -> bool:
    """Give a world another scene, if that differs only in masses, materials and starts.

    The world is then, to the last bit, what `build_world` would make of its people and the new
    scene; it has to be reset. A new one is needed where an object moves on a trajectory or is held,
    where a baseline moves the people, and where settings differ in what a world is made for
    (`FIXED`).

    Returns:
        Whether it could be done; if not, the world is as it was.
    """
    if not _fits(world, scene, settings):
        return False
    world.stiffness = stiffness_array(settings.stiffness, "Settings.stiffness")
    world.changed(scene, settings)
    armature = armature_of(world.stiffness)
    world.joined = join_model(world.bodies, world.called.people, scene, {}, armature)
    world.stepper.set_model(**model_arrays(world.joined))
    set_pairings(world.stepper, scene, settings, world.called)
    set_settings(world.stepper, settings, scene.gravity)
    return True


def _fits(world: World, scene: Scene, settings: Settings) -> bool:
    was = world.made_of
    if world.held or not settings.drive == world.settings.drive == HALF_PHYSICS:
        return False
    if any(getattr(settings, field) != getattr(world.settings, field) for field in FIXED):
        return False
    groups = (
        (was.statics, scene.statics),
        (was.objects, scene.objects),
        (was.articulated, scene.articulated),
    )
    if any(list(old) != list(new) for old, new in groups):
        return False
    # What may press a soft layer is listed when a world is made.
    if world.soft and set(was.ignored_pairs) != set(scene.ignored_pairs):
        return False
    return (
        all(_same_static(old, scene.statics[n]) for n, old in was.statics.items())
        and all(_same_shape(old, scene.objects[n]) for n, old in was.objects.items())
        and all(old is scene.articulated[n] for n, old in was.articulated.items())
        and parts_set_apart(was) == parts_set_apart(scene)
    )


def _same_static(a: Static, b: Static) -> bool:
    return a is b or (
        a.shape == b.shape
        and a.soft == b.soft
        and np.array_equal(a.position, b.position)
        and np.array_equal(a.quaternion, b.quaternion)
    )


def _same_shape(a: Object, b: Object) -> bool:
    if isinstance(a, KinematicObject) or isinstance(b, KinematicObject):
        return False
    return a is b or (
        a.shape == b.shape
        and a.soft == b.soft
        and a.decomposition is b.decomposition
        and a.start == b.start
        and np.array_equal(a.com, b.com)
    )

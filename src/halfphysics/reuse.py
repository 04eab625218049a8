"""A world used again: for another scene whose things have the same shapes.

What a world is made of is mostly its people: their parts compiled, the hulls of their skin handed
to the core. None of it depends on what things weigh, how rough they are and where they start.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.moving import Moving
from halfphysics.person_model import principal

if TYPE_CHECKING:
    from halfphysics.scene import Scene
    from halfphysics.things import Object, Static
    from halfphysics.world import World


def put_scene(world: World, scene: Scene) -> bool:
    """Put a scene in the place of a world's, if it differs only in masses, materials and starts.

    The world is then, to the last bit, what `World` would make of its people and that scene; it has
    to be reset. Worlds with things on trajectories, or where something is held, are made anew.

    Returns:
        Whether it could be done; if not, the world is as it was.
    """
    if not _fits(world, scene):
        return False
    model, changed = world.model, False
    for name, thing in scene.objects.items():
        was = world.scene.objects[name]
        if thing is was:
            continue
        body = model.body(f"object/{name}").id
        if not np.array_equal(thing.position, was.position):
            at = model.jnt_qposadr[model.body_jntadr[body]]
            model.body_pos[body] = model.qpos0[at : at + 3] = thing.position
            changed = True
        if thing.mass != was.mass or not np.array_equal(thing.inertia, was.inertia):
            model.body_mass[body] = thing.mass
            model.body_inertia[body], model.body_iquat[body] = _compiled(thing)
            changed = True
    world.put_scene(scene, changed)
    return True


def _fits(world: World, scene: Scene) -> bool:
    was = world.scene
    if world.held or world.settings.mode != "velocity":
        return False
    groups = (
        (was.statics, scene.statics),
        (was.objects, scene.objects),
        (was.articulated, scene.articulated),
    )
    if any(list(old) != list(new) for old, new in groups):
        return False
    return (
        np.array_equal(was.gravity, scene.gravity)
        and all(_same_static(old, scene.statics[n]) for n, old in was.statics.items())
        and all(_same_shape(old, scene.objects[n]) for n, old in was.objects.items())
        and all(old is scene.articulated[n] for n, old in was.articulated.items())
        and world.told_of(was) == world.told_of(scene)
    )


def _same_static(a: Static, b: Static) -> bool:
    return a is b or (
        a.shape == b.shape
        and np.array_equal(a.position, b.position)
        and np.array_equal(a.quaternion, b.quaternion)
    )


def _same_shape(a: Object, b: Object) -> bool:
    if isinstance(a, Moving) or isinstance(b, Moving):
        return False
    return a is b or (
        a.shape == b.shape
        and a.decomposition is b.decomposition
        and a.start == b.start
        and np.array_equal(a.com, b.com)
    )


def _compiled(thing: Object) -> tuple[Any, Any]:
    """Moments (3,) and quaternion (4,) of an object as a compiled model has them."""
    import mujoco

    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="object", pos=thing.position)
    body.add_freejoint()
    body.mass, body.ipos = thing.mass, [0.0, 0.0, 0.0]
    body.inertia, body.iquat = principal(thing.inertia)
    body.explicitinertial = True
    model = spec.compile()
    return model.body_inertia[1].copy(), model.body_iquat[1].copy()

"""A world used again: for another scene whose things have the same shapes, other settings.

What a world is made of is mostly its people: their parts compiled, the hulls of their skin handed
to the core. None of it depends on what things weigh, how rough they are and where they start, and
little on settings.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.body.mjcf_person import principal
from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.trajectories import Moving
from halfphysics.simulation.world import armature_of

if TYPE_CHECKING:
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.simulator import Simulator
    from halfphysics.simulation.world import World

#: Settings that a world is made for: what touches, what the drive can, how the motion drives.
FIXED = (
    *("contact", "self_contact", "strength", "mode"),
    *("internal_forces", "joint_damping", "torque_frequency", "torque_damping"),
)


def use_again(simulator: Simulator, scene: Scene, settings: Settings, fps: float) -> bool:
    """Give a simulator another scene, if that differs only in masses, materials and starts.

    It is then, to the last bit, what `Simulator` would make of its people and the rest; it has to
    be reset. Where something moves on a trajectory or is held, or settings differ in what a world
    is made for (`FIXED`), a new one is needed.

    Returns:
        Whether it could be done; if not, the simulator is as it was.
    """
    world = simulator.world
    if not _fits(world, scene, settings):
        return False
    model, changed = world.model, _set_firmness(world, settings)
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
    world.put(scene, settings, changed)
    simulator.settings, simulator.dt = settings, 1.0 / fps
    return True


def _set_firmness(world: World, settings: Settings) -> bool:
    """Firmness of the joints by the settings; whether the model changed: fingers' armature has."""
    stiffness = stiffness_array(settings.stiffness, "Settings.stiffness")
    if np.array_equal(stiffness, world.stiffness):
        return False
    world.stiffness, model = stiffness, world.model
    armature = armature_of(stiffness)
    for person in world.people:
        for joint in np.flatnonzero(armature):
            dof = int(model.jnt_dofadr[model.joint(f"{person.name}/{JOINT_NAMES[joint]}").id])
            model.dof_armature[dof : dof + 3] = armature[joint]
    return True


def _fits(world: World, scene: Scene, settings: Settings) -> bool:
    was = world.scene
    if world.held or settings.mode != "velocity":
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
    return (
        all(_same_static(old, scene.statics[n]) for n, old in was.statics.items())
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

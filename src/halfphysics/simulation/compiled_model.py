"""People and a scene as a MuJoCo model, and the arrays of it that the core reads once.

MuJoCo turns the trees of bodies into arrays of masses, inertias and joints. Nothing of it steps:
the geometry goes to the core directly, in float64. `joined_model` makes the same arrays from trees
that were compiled before.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.mjcf_person import add_person, principal
from halfphysics.motion.skeleton import LEFT_HAND_JOINTS, N_JOINTS, RIGHT_HAND_JOINTS
from halfphysics.scene import articulated as jointed
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.items import Object
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.holding import Hold

Array = NDArray[np.float64]

#: (1 + lambda) times the armature of a finger joint [kg m^2] (docs/physics.md, "The drive").
FINGER_INERTIA = 1e-3


def armature_of(stiffness: Array) -> Array:
    """Armature of every joint (55,) [kg m^2] at a stiffness (55,): fingers have one."""
    armature = np.zeros(N_JOINTS)
    fingers = list(LEFT_HAND_JOINTS + RIGHT_HAND_JOINTS)
    armature[fingers] = FINGER_INERTIA / (1.0 + stiffness[fingers])
    return armature


def compile_model(
    bodies: Sequence[Body],
    people: Sequence[str],
    scene: Scene,
    held: Mapping[str, Hold],
    armature: Array,
) -> Any:
    """The `mujoco.MjModel` of people and a scene, without geoms.

    Args:
        bodies: The people's bodies.
        people: Their names: the prefixes of their bodies.
        scene: Its objects and articulated objects get bodies; a held object is a body of the
            person's tree.
        held: Name of an object -> how it is held.
        armature: Of the people's joints (55,) [kg m^2].
    """
    import mujoco

    spec = mujoco.MjSpec()
    for name, body in zip(people, bodies, strict=True):
        add_person(spec, body.variant, prefix=f"{name}/", armature=armature, geoms=False)
    for item in scene.objects.values():
        _add_object(spec, item, people, held.get(item.name))
    for articulated in scene.articulated.values():
        jointed.add_bodies(spec, articulated)
    return spec.compile()


def _add_object(spec: Any, item: Object, people: Sequence[str], hold: Hold | None) -> None:
    # No name of an item has a slash; MuJoCo keeps "world" for itself.
    name = f"object/{item.name}"
    if hold is None:
        body = spec.worldbody.add_body(name=name, pos=item.position)
        body.add_freejoint()
    else:  # no joint: a part of the holder's tree
        parent = spec.body(f"{people[hold.person]}/{hold.part}")
        body = parent.add_body(name=name, pos=hold.position, quat=hold.quaternion)
    given = isinstance(item, KinematicObject)  # its mass is never asked for
    _set_inertia(body, 1.0 if given else item.mass, np.eye(3) if given else item.inertia)


def compiled_inertia(mass: float, inertia: Array) -> tuple[Array, Array]:
    """Moments (3,) [kg m^2] and quaternion (4,) of a body as a compiled model has them.

    Args:
        mass: [kg].
        inertia: About the centre of mass (3, 3) [kg m^2].

    Raises:
        ValueError: MuJoCo refuses them.
    """
    import mujoco

    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body()
    body.add_freejoint()
    _set_inertia(body, mass, inertia)
    model = spec.compile()
    return model.body_inertia[1].copy(), model.body_iquat[1].copy()


def _set_inertia(body: Any, mass: float, inertia: Array) -> None:
    """About the body's origin."""
    body.mass, body.ipos = mass, [0.0, 0.0, 0.0]  # else ipos becomes pos
    body.inertia, body.iquat = principal(inertia)
    body.explicitinertial = True


def joint_arrays(model: Any) -> dict[str, Any]:
    """The arrays of an MjModel that the core's set_joint_forces() takes, by their names there."""
    return {
        "damping": _doubles(model.dof_damping),
        "stiffness": _doubles(model.jnt_stiffness),
        "spring": _doubles(model.qpos_spring),
        "limited": _ints(model.jnt_limited),
        "range": _doubles(model.jnt_range).reshape(-1, 2),
    }


def model_arrays(model: Any) -> dict[str, Any]:
    """The arrays of an MjModel that the core's set_model() takes, by their names there."""
    return {
        "parent": _ints(model.body_parentid),
        "jnt_first": _ints(model.body_jntadr),
        "jnt_count": _ints(model.body_jntnum),
        "dof_first": _ints(model.body_dofadr),
        "dof_count": _ints(model.body_dofnum),
        "pos": _doubles(model.body_pos),
        "quat": _doubles(model.body_quat),
        "ipos": _doubles(model.body_ipos),
        "iquat": _doubles(model.body_iquat),
        "mass": _doubles(model.body_mass),
        "inertia": _doubles(model.body_inertia),
        "jnt_type": _ints(model.jnt_type),
        "jnt_qpos": _ints(model.jnt_qposadr),
        "jnt_dof": _ints(model.jnt_dofadr),
        "jnt_body": _ints(model.jnt_bodyid),
        "jnt_pos": _doubles(model.jnt_pos),
        "jnt_axis": _doubles(model.jnt_axis),
        "qpos0": _doubles(model.qpos0),
        "armature": _doubles(model.dof_armature),
    }


def _ints(x: Any) -> NDArray[np.int32]:
    return np.ascontiguousarray(x, dtype=np.int32)


def _doubles(x: Any) -> Array:
    return np.ascontiguousarray(x, dtype=np.float64)

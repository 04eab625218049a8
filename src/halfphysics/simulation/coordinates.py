"""Where people and objects stand in the model's coordinates, and how they are read from there.

The core has one vector of coordinates, `qpos` (nq,), and one of velocities, `qvel` (nv,), as MuJoCo
lays them out: three numbers of position and a quaternion for a free joint, a quaternion for a ball.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics import _native
from halfphysics.base import rotations as rot
from halfphysics.base.short_repr import short_repr
from halfphysics.body.mjcf_person import addresses
from halfphysics.motion.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.items import Object

Array = NDArray[np.float64]

#: Coordinates of one person: a free root and 54 ball joints.
PERSON_COORDINATES = 7 + 4 * (N_JOINTS - 1)


@dataclass(frozen=True)
class Person:
    """Where one person's numbers stand in the model's coordinates."""

    name: str
    body: Body
    root: int  # body id
    qpos: int  # first coordinate
    count: int  # number of coordinates
    joint_qpos: NDArray[np.int64]  # first coordinate of every joint's quaternion (55,)
    bodies: NDArray[np.int64]  # body id of every joint (55,)

    __repr__ = short_repr

    @staticmethod
    def of(model: Any, prefix: str, name: str, body: Body) -> Person:
        """The person whose bodies have a prefix in a compiled `mujoco.MjModel`."""
        at = addresses(model, prefix)
        root = int(at.body[0])
        return Person(name, body, root, at.root_position, PERSON_COORDINATES, at.quat, at.body)

    def coordinates(self, translation: Array, rotations: Array, axes: Array) -> Array:
        """Coordinates (T, count) of SMPL-X poses: (T, 3) and (T, 55, 3)."""
        q = np.empty((len(translation), self.count))
        q[:, :3] = translation + axes @ self.body.rest_joints[0]
        rotations = np.ascontiguousarray(rotations, dtype=np.float64)
        _native.put_rotations(rotations, self._places - np.int32(self.qpos), q)
        return q

    def pose(self, qpos: Array, axes: Array) -> tuple[Array, Array]:
        """SMPL-X translation (..., 3) and rotations (..., 55, 3) of model coordinates (..., nq)."""
        translation = qpos[..., self.qpos : self.qpos + 3] - axes @ self.body.rest_joints[0]
        rows = np.ascontiguousarray(qpos, dtype=np.float64).reshape(-1, qpos.shape[-1])
        rotations: Array = _native.rotations_of(rows, self._places)
        return translation, rotations.reshape(*qpos.shape[:-1], N_JOINTS, 3)

    @cached_property
    def balls(self) -> NDArray[np.int64]:
        """Joint indices (55,) in the model's order: as the core counts a person's joints."""
        return np.argsort(self.joint_qpos)

    @cached_property
    def _places(self) -> NDArray[np.int32]:
        """First coordinate of every joint's quaternion (55,), as the core takes it."""
        return np.ascontiguousarray(self.joint_qpos, dtype=np.int32)


@dataclass(frozen=True)
class FreeObject:
    """Where the numbers of an object with a free joint stand.

    Its model frame is at the centre of mass, `com` (3,) [m] of the object's own frame.
    """

    name: str
    com: Array
    qpos: int
    dof: int

    @staticmethod
    def of(model: Any, item: Object) -> FreeObject:
        """An object of the scene in a compiled `mujoco.MjModel`."""
        joint = model.body_jntadr[model.body(f"object/{item.name}").id]
        qpos, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        return FreeObject(item.name, np.array(item.com), qpos, dof)

    def pose(self, qpos: Array) -> tuple[Array, Array]:
        """Position (..., 3) and quaternion (..., 4) of the object's own frame."""
        quat = qpos[..., self.qpos + 3 : self.qpos + 7]
        centre = qpos[..., self.qpos : self.qpos + 3]
        if not self.com.any():  # the same numbers, ten times as fast: scenes have many of these
            return centre.copy(), quat
        return centre - rot.rotate(quat, self.com), quat

    def put_at_start(self, item: Object, qpos: Array, qvel: Array) -> None:
        """Write the object's start into coordinates (nq,) and velocities (nv,)."""
        quat = rot.normalize(item.quaternion)
        arm = rot.rotate(quat, self.com)
        qpos[self.qpos : self.qpos + 3] = item.position + arm
        qpos[self.qpos + 3 : self.qpos + 7] = quat
        spin = np.asarray(item.angular_velocity, dtype=np.float64)
        qvel[self.dof : self.dof + 3] = item.velocity + np.cross(spin, arm)
        qvel[self.dof + 3 : self.dof + 6] = rot.rotate(rot.conjugate(quat), spin)


def joints_to_core(people: Sequence[Person], values: Array) -> Array:
    """Values of joints (..., people, 55) in the core's order (..., balls)."""
    each = [values[..., i, person.balls] for i, person in enumerate(people)]
    return np.ascontiguousarray(np.concatenate(each or [np.zeros(0)], axis=-1))


def joints_from_core(people: Sequence[Person], values: Array) -> Array:
    """Vectors of joints (..., people, 55, 3) of those in the core's order (..., balls, 3)."""
    out = np.empty((*values.shape[:-2], len(people), N_JOINTS, 3))
    for i, person in enumerate(people):
        out[..., i, person.balls, :] = values[..., i * N_JOINTS : (i + 1) * N_JOINTS, :]
    return out

"""Objects held to a part of a person: bodies of the person's tree that no joint moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.settings import HALF_PHYSICS
from halfphysics.simulation.coordinates import FreeObject

if TYPE_CHECKING:
    from halfphysics.simulation.coordinates import Person
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Hold:
    """How a person holds an object: by which part, its centre of mass in the joint's frame.

    `joint` is the part's index. Plain numbers: two are equal where they are to the last bit.
    """

    person: int
    joint: int
    position: tuple[float, ...]
    quaternion: tuple[float, ...]

    @property
    def part(self) -> str:
        """Name of the joint."""
        return JOINT_NAMES[self.joint]


@dataclass(frozen=True)
class HeldObject:
    """An object without coordinates of its own: the holder's say where it is."""

    name: str
    com: Array
    person: Person
    hold: Hold

    def pose(self, qpos: Array) -> tuple[Array, Array]:
        """Position (..., 3) and quaternion (..., 4) of the object's own frame."""
        position, turn = part_pose(self.person, self.hold.joint, qpos)
        quat = rot.multiply(turn, np.array(self.hold.quaternion))
        centre = position + rot.rotate(turn, np.array(self.hold.position))
        return centre - rot.rotate(quat, self.com), quat


def part_pose(person: Person, joint: int, qpos: Array) -> tuple[Array, Array]:
    """Position (..., 3) and quaternion (..., 4) of a joint's frame at coordinates (..., nq)."""
    chain = [joint]
    while PARENTS[chain[-1]] >= 0:
        chain.append(PARENTS[chain[-1]])
    offsets = person.body.variant.joint_offsets
    position = qpos[..., person.qpos : person.qpos + 3]
    quat = qpos[..., person.joint_qpos[0] + np.arange(4)]
    for j in reversed(chain[:-1]):
        position = position + rot.rotate(quat, offsets[j])
        quat = rot.multiply(quat, qpos[..., person.joint_qpos[j] + np.arange(4)])
    return position, quat


def velocity(world: World, place: HeldObject) -> tuple[Array, Array]:
    """Of a held object's origin (3,) [m/s], and its spin (3,) [rad/s], as a point of the part."""
    import mujoco

    model, data = world.model, mujoco.MjData(world.model)
    data.qpos[:] = qpos = world.stepper.qpos()
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    moves, turns = np.zeros((3, world.nv)), np.zeros((3, world.nv))
    body = model.body(f"object/{place.name}").id
    mujoco.mj_jac(model, data, moves, turns, place.pose(qpos)[0], body)
    qvel = np.asarray(world.stepper.qvel())
    return moves @ qvel, turns @ qvel


def with_held(world: World, name: str, part: str, person: int) -> Mapping[str, Hold]:
    """`World.held` with one object more, held where it is now.

    Raises:
        InputError: An unknown name, part or person, an object that is not free.
    """
    what = f"attach {shown(name)}"
    if not isinstance(name, str):
        raise InputError(f"attach: {world.unknown_object(name)}")
    if world.settings.drive != HALF_PHYSICS:
        raise InputError(
            f"{what}: with the baseline {type(world.settings).__name__} the person does not bear "
            "the weight of a held object; expected halfphysics.Settings. What a hand grips needs "
            "no attach"
        )
    place = {place.name: place for place in world.objects}.get(name)
    if place is None:
        raise InputError(f"attach: {_stranger(world, name)}")
    if isinstance(world.made_of.objects[name], KinematicObject):
        raise InputError(f"{what}: it moves along its trajectory; expected an object of add_object")
    if not isinstance(place, FreeObject):
        raise InputError(f"{what}: {_holder(world, name)} holds it already; release({name!r}) it")
    if not isinstance(part, str) or part not in JOINT_NAMES:
        # Whose hand it is matters more than how the joint's name is spelled.
        meant = str(part).replace("hand", "wrist")
        hint = did_you_mean(meant, JOINT_NAMES, form=repr)
        raise InputError(
            f"{what}: part: found {shown(part)}, expected a joint's name such as 'right_wrist' "
            f"or 'head'{hint}"
        )
    count = len(world.people)
    if isinstance(person, bool) or not isinstance(person, int | np.integer):
        raise InputError(f"{what}: person: found {shown(person)}, expected an index")
    if not 0 <= person < count:
        expected = f"0 to {count - 1}" if count else "none: there are no people"
        raise InputError(f"{what}: person: found {person}, expected {expected}")
    qpos, joint = world.stepper.qpos(), JOINT_NAMES.index(part)
    position, turn = part_pose(world.people[person], joint, qpos)
    back = rot.conjugate(turn)
    at = rot.rotate(back, qpos[place.qpos : place.qpos + 3] - position)
    quat = rot.normalize(rot.multiply(back, qpos[place.qpos + 3 : place.qpos + 7]))
    hold = Hold(int(person), joint, tuple(map(float, at)), tuple(map(float, quat)))
    return {**world.held, name: hold}


def without_held(world: World, name: str) -> Mapping[str, Hold]:
    """`World.held` without one object.

    Raises:
        InputError: It is not held.
    """
    if not isinstance(name, str):
        raise InputError(f"release: {world.unknown_object(name)}")
    if name in world.held:
        return {n: hold for n, hold in world.held.items() if n != name}
    if name not in {place.name for place in world.objects}:
        raise InputError(f"release: {_stranger(world, name)}")
    held = ", ".join(world.held) or "nothing"
    raise InputError(f"release: {name!r} is not held. Held: {held}")


def not_free(world: World, what: str, name: str) -> InputError:
    """The error for an object that is held."""
    return InputError(f"{what}: {_holder(world, name)} holds {name!r}; release({name!r}) it first")


def _holder(world: World, name: str) -> str:
    hold = world.held[name]
    return f"the {hold.part} of {world.people[hold.person].name!r}"


def _stranger(world: World, name: str) -> str:
    if name in world.made_of.articulated or name in world.called.owner:
        return (
            f"{name!r} is articulated, and what has joints cannot be held; expected an object of "
            "add_object"
        )
    return world.unknown_object(name)

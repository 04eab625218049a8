"""A simulation that runs: its objects pushed, new ones brought, old ones taken away, rays."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import vector
from halfphysics.errors import InputError
from halfphysics.motion.pose import Pose
from halfphysics.scene.rays import Ray, checked_names
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.simulation import holding
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.coordinates import FreeObject

if TYPE_CHECKING:
    from halfphysics.scene.articulated import Link
    from halfphysics.scene.items import Object
    from halfphysics.scene.rays import Hit
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.holding import HeldObject, Hold
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]


def velocity(world: World, name: str) -> tuple[Array, Array]:
    """Velocity (3,) [m/s] of an object's origin and angular velocity (3,) [rad/s], in the world."""
    place, item = _found(world, "velocity", name)
    if not isinstance(place, FreeObject):
        return holding.velocity(world, place)
    quat, six = _turn(world, place), world.stepper.qvel()[place.dof : place.dof + 6]
    spin = rot.rotate(quat, six[3:])
    return six[:3] - np.cross(spin, rot.rotate(quat, item.com)), spin


def set_velocity(
    world: World, name: str, linear: ArrayLike, angular: ArrayLike | None = None
) -> None:
    """The work behind `Simulator.set_velocity`."""
    place, item = _pushed(world, "set_velocity", name)
    what = f"set_velocity of {name!r}"
    v = vector(linear, f"{what}: velocity", unit="m/s")
    w = velocity(world, name)[1]
    if angular is not None:
        w = vector(angular, f"{what}: angular_velocity", unit="rad/s")
    quat = _turn(world, place)
    six = np.concatenate(
        [v + np.cross(w, rot.rotate(quat, item.com)), rot.rotate(rot.conjugate(quat), w)]
    )
    world.stepper.set_velocity(_body(world, name), six)


def apply_impulse(
    world: World,
    name: str,
    impulse: ArrayLike,
    point: ArrayLike | None,
    angular: ArrayLike | None,
) -> None:
    """The work behind `Simulator.apply_impulse`."""
    place, item = _pushed(world, "apply_impulse", name)
    what = f"apply_impulse on {name!r}"
    p = vector(impulse, f"{what}: impulse", unit="N s")
    turning = np.zeros(3)
    if point is not None:
        centre = world.stepper.qpos()[place.qpos : place.qpos + 3]
        turning += np.cross(vector(point, f"{what}: point", unit="m") - centre, p)
    if angular is not None:
        turning += vector(angular, f"{what}: angular", unit="N m s")
    six = np.array(world.stepper.qvel()[place.dof : place.dof + 6])
    six[:3] += p / item.mass
    own = rot.rotate(rot.conjugate(_turn(world, place)), turning)
    six[3:] += np.linalg.solve(item.inertia, own)
    world.stepper.set_velocity(_body(world, name), six)


def ray(
    world: World,
    axes: Sequence[Array],
    origin: ArrayLike,
    direction: ArrayLike,
    ignore: Collection[str],
) -> Hit | None:
    """The work behind `Simulator.ray`."""
    cast = Ray(origin, direction)
    skipped = checked_names(ignore, world.names)
    qpos = world.stepper.qpos()
    for static in world.made_of.statics.values():
        if static.name not in skipped:
            cast.meet(static.name, static.shape, static.position, static.quaternion)
    for place in world.objects:
        if place.name not in skipped:
            cast.meet(place.name, world.made_of.objects[place.name].shape, *place.pose(qpos))
    links: dict[str, Link] = {}
    for jointed in world.made_of.articulated.values():
        links.update(zip(jointed.link_names, jointed.links, strict=True))
    for link in world.links:
        if link.name not in skipped:
            cast.meet_link(link.name, links[link.name], *link.pose(qpos))
    for person, its in zip(world.people, axes, strict=True):
        if person.name not in skipped:
            cast.meet_person(person.name, person.body, Pose.trusted(*person.pose(qpos, its), its))
    return cast.hit


def rebuilt(
    world: World, scene: Scene, started: bool, held: Mapping[str, Hold] | None = None
) -> World:
    """The same people and what is in both scenes, as they are now, in another scene.

    `held`: name of an object -> how it is held from now on; None: as before.
    """
    if held is None:
        held = {name: hold for name, hold in world.held.items() if name in scene.objects}
    new = build_world(world.bodies, scene, world.settings, held)
    if not started:
        return new
    was, qpos, qvel = world.stepper.qpos(), np.zeros(new.nq), np.zeros(new.nv)
    new.place_objects(qpos, qvel)
    # An object whose hold changes is new to the core: its contacts are found again.
    other = {n for n in scene.objects if world.held.get(n) != held.get(n)}
    bodies = {name: i for i, name in enumerate(world.joined.body_names)}
    bodies = {name: i for name, i in bodies.items() if name.removeprefix("object/") not in other}
    body = [bodies.get(name, -1) for name in new.joined.body_names]
    here, there = _coordinates(new.joined), _coordinates(world.joined)
    for b, old in enumerate(body):
        if old >= 0:
            qpos[here[b]] = was[there[old]]
    let_go = [p for p in world.objects if p.name in other and not isinstance(p, FreeObject)]
    free = {p.name: p for p in new.objects if isinstance(p, FreeObject)}
    let_go = [p for p in let_go if p.name in free]
    for place in let_go:
        position, quat = place.pose(was)
        at = free[place.name].qpos
        qpos[at : at + 3] = position + rot.rotate(quat, place.com)
        qpos[at + 3 : at + 7] = quat
    new.stepper.reset(qpos, qvel, stand=False)  # people are where they are
    shapes = {key: i for i, key in enumerate(world.shape_keys) if key[0] not in other}
    shape = [shapes.get(key, -1) for key in new.shape_keys]
    new.stepper.adopt(
        world.stepper, np.array(body, dtype=np.int32), np.array(shape, dtype=np.int32)
    )
    for place in let_go:
        set_velocity(new, place.name, *velocity(world, place.name))
    return new


def _coordinates(model: Any) -> list[slice]:
    """Where the joints of every body stand in qpos."""
    ends = [*map(int, model.jnt_qposadr), int(model.nq)]
    joints = zip(map(int, model.body_jntadr), map(int, model.body_jntnum), strict=True)
    return [slice(ends[at], ends[at + n]) if n else slice(0, 0) for at, n in joints]


def removable(world: World, name: str) -> None:
    """Raises `InputError` where there is no such object."""
    _found(world, "remove_object", name)


def _pushed(world: World, what: str, name: str) -> tuple[FreeObject, Object]:
    """What can be given a velocity."""
    place, item = _found(world, what, name)
    if isinstance(item, KinematicObject):
        raise InputError(
            f"{what}: {name!r} moves along its trajectory and nothing pushes it; expected an "
            "object of add_object"
        )
    if not isinstance(place, FreeObject):
        raise holding.not_free(world, what, name)
    return place, item


def _found(world: World, what: str, name: str) -> tuple[FreeObject | HeldObject, Object]:
    if not isinstance(name, str):
        raise InputError(f"{what}: {world.unknown_object(name)}")
    for place in world.objects:
        if place.name == name:
            return place, world.made_of.objects[name]
    jointed = world.called.owner.get(name, name)
    if jointed in world.made_of.articulated:
        raise InputError(
            f"{what}: {name!r} is articulated: its joints say where it is (Frame.joints), and "
            "what touches it moves it; expected an object of add_object"
        )
    raise InputError(f"{what}: {world.unknown_object(name)}")


def _turn(world: World, place: FreeObject) -> Array:
    return np.array(world.stepper.qpos()[place.qpos + 3 : place.qpos + 7])


def _body(world: World, name: str) -> int:
    return int(world.joined.body(f"object/{name}").id)

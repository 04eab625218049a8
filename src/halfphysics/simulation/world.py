"""From people and a scene to the native stepper: what MuJoCo compiles, the core reads once.

MuJoCo turns the trees of bodies into arrays of masses, inertias and joints; the geometry goes to
the core directly, in float64.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.baselines.modes import FORCED
from halfphysics.body.mjcf_person import addresses, principal
from halfphysics.body.strength import limits_of
from halfphysics.errors import InputError
from halfphysics.geometry.colliders import convex_collider
from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.skeleton import JOINT_NAMES, LEFT_HAND_JOINTS, N_JOINTS, RIGHT_HAND_JOINTS
from halfphysics.scene import articulated as jointed
from halfphysics.simulation import holding
from halfphysics.simulation.fingerprint import fingerprint
from halfphysics.simulation.mesh_trees import mesh_tree
from halfphysics.simulation.person_shapes import add_person_movers

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.holding import Hold

Array = NDArray[np.float64]

#: (1 + lambda) times the armature of a finger joint [kg m^2] (METHOD: "Solving it").
FINGER_INERTIA = 1e-3
#: Solving is exact to about 1e-6: what may come as near as that is inside sometimes, and a part
#: that is inside a mesh is not held by it any more [m].
LEAST_CLEARANCE = 2e-5


@dataclass(frozen=True)
class Person:
    """Where one person's numbers stand in the model's coordinates."""

    name: str
    body: Body
    root: int  # body id
    qpos: int  # first coordinate
    count: int  # number of coordinates
    joint_qpos: NDArray[np.int64]  # first coordinate of every joint's quaternion (55,)

    def coordinates(self, translation: Array, rotations: Array, axes: Array) -> Array:
        """Coordinates (T, count) of SMPL-X poses: (T, 3) and (T, 55, 3)."""
        q = np.zeros((len(translation), self.count))
        q[:, :3] = translation + axes @ self.body.rest_joints[0]
        q[:, self._quats - self.qpos] = rot.exp(rotations)
        return q

    def pose(self, qpos: Array, axes: Array) -> tuple[Array, Array]:
        """SMPL-X translation (..., 3) and rotations (..., 55, 3) of model coordinates (..., nq)."""
        translation = qpos[..., self.qpos : self.qpos + 3] - axes @ self.body.rest_joints[0]
        # take() lays the frames out one after the other, whatever their number: the same bits.
        return translation, rot.log(np.take(qpos, self._quats, axis=-1))

    @cached_property
    def balls(self) -> NDArray[np.int64]:
        """Joint indices (55,) in the model's order: as the core counts a person's joints."""
        return np.argsort(self.joint_qpos)

    @cached_property
    def _quats(self) -> NDArray[np.int64]:
        """Coordinates of every joint's quaternion (55, 4)."""
        return self.joint_qpos[:, None] + np.arange(4)


@dataclass(frozen=True)
class Thing:
    """Where one object's numbers stand. Its model frame is at the centre of mass."""

    name: str
    com: Array
    qpos: int
    dof: int

    def pose(self, qpos: Array) -> tuple[Array, Array]:
        """Position (..., 3) and quaternion (..., 4) of the object's own frame."""
        quat = qpos[..., self.qpos + 3 : self.qpos + 7]
        position = qpos[..., self.qpos : self.qpos + 3] - rot.rotate(quat, self.com)
        return position, quat


class World:
    """People and a scene, compiled for the core.

    Attributes:
        names: What contacts refer to: statics, objects, people, in this order.
        people, things: Their places in the coordinates.
        stepper: The native stepper.
        stiffness: Firmness of every joint by the settings (55,).
        mover_name, mover_part: Per native shape: index into `names`, joint index or -1.
        nq, nv: Numbers of coordinates and velocities.
        held: Who holds what: those things have no coordinates of their own.
        signature: Differs where people or things do, whoever holds them.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        scene: Scene,
        settings: Settings,
        held: Mapping[str, Hold] | None = None,
    ) -> None:
        from halfphysics import _native

        self.bodies = tuple(bodies)
        self.scene = scene
        self.settings = settings
        self.held: Mapping[str, Hold] = dict(held or {})
        many = len(self.bodies) > 1
        people = [f"person{i}" if many else "person" for i in range(len(self.bodies))]
        things = scene.articulated.values()
        links = {n: thing.name for thing in things for n in thing.link_names}
        self.names: tuple[str, ...] = (*scene.statics, *scene.objects, *links, *people)
        # What an articulated object's links are called in a scene.
        self._owner = links
        if len(set(self.names)) < len(self.names):
            raise InputError(
                f"scene: a static or object is named like a person ({', '.join(people)}); rename it"
            )
        model = self._compile(people)
        self.nq, self.nv = int(model.nq), int(model.nv)
        self.signature = f"{self.names} {fingerprint(self.bodies, scene)}"
        self.stepper = _native.Stepper()
        self.stepper.set_model(*model_arrays(model))
        self.stepper.set_joint_forces(*joint_arrays(model))
        self._name_people(model, people)
        self._add_movers(model)
        self._add_statics()
        self._set_pairings()
        set_settings(self.stepper, settings, scene.gravity)
        self.stepper.set_forced(FORCED.get(settings.mode, 0))
        self._add_given()
        self.stepper.finish([p.root for p in self.people])
        self._set_strength()
        if settings.self_contact:
            self._set_self_pairs()

    def _compile(self, people: list[str]) -> Any:
        import mujoco

        from halfphysics.body.mjcf_person import add_person
        from halfphysics.scene.trajectories import Moving

        spec = mujoco.MjSpec()
        self.stiffness = stiffness_array(self.settings.stiffness, "Settings.stiffness")
        armature = armature_of(self.stiffness)
        for name, body in zip(people, self.bodies, strict=True):
            add_person(spec, body.variant, prefix=f"{name}/", armature=armature, geoms=False)
        for thing in self.scene.objects.values():
            # No name of a thing has a slash; MuJoCo keeps "world" for itself.
            name = f"object/{thing.name}"
            if thing.name in self.held:
                b = holding.add_body(spec, name, people, self.held[thing.name])
            else:
                b = spec.worldbody.add_body(name=name, pos=thing.position)
                b.add_freejoint()
            given = isinstance(thing, Moving)  # what its mass is nobody asks
            b.mass, b.ipos = 1.0 if given else thing.mass, [0.0, 0.0, 0.0]  # else ipos becomes pos
            b.inertia, b.iquat = principal(np.eye(3) if given else thing.inertia)
            b.explicitinertial = True
        for articulated in self.scene.articulated.values():
            jointed.add_bodies(spec, articulated)
        return spec.compile()

    def _name_people(self, model: Any, people: list[str]) -> None:
        found = []
        for name, body in zip(people, self.bodies, strict=True):
            at = addresses(model, f"{name}/")
            count = 7 + 4 * (N_JOINTS - 1)
            found.append(Person(name, body, int(at.body[0]), at.root_position, count, at.quat))
        self.people = tuple(found)
        things: list[Thing | holding.HeldThing] = []
        for thing in self.scene.objects.values():
            if thing.name in self.held:
                hold = self.held[thing.name]
                holder = self.people[hold.person]
                things.append(holding.HeldThing(thing.name, np.array(thing.com), holder, hold))
                continue
            joint = model.body_jntadr[model.body(f"object/{thing.name}").id]
            things.append(
                Thing(
                    thing.name,
                    np.array(thing.com),
                    int(model.jnt_qposadr[joint]),
                    int(model.jnt_dofadr[joint]),
                )
            )
        self.things = tuple(things)
        found_places = [jointed.places(model, t) for t in self.scene.articulated.values()]
        self.links = tuple(link for links, _ in found_places for link in links)
        self.joints = tuple(joint for _, joints in found_places for joint in joints)
        self.model = model

    def _add_movers(self, model: Any) -> None:
        name_of = {name: i for i, name in enumerate(self.names)}
        names: list[int] = []
        parts: list[int] = []
        self._told = self.told_of(self.scene)
        for index, person in enumerate(self.people):
            mine = add_person_movers(
                self.stepper,
                model,
                person.body,
                self.settings,
                prefix=f"{person.name}/",
                index=index,
                name=partial(self._entry, name_of[person.name]),
            )
            names += [name_of[person.name]] * len(mine)
            parts += mine
        for thing in self.scene.objects.values():
            body, cut = model.body(f"object/{thing.name}").id, thing.decomposition
            for piece in thing.pieces:
                collider = convex_collider(piece).moved(np.eye(3), -np.array(thing.com))
                self.stepper.add_mover(body, name_of[thing.name], -1, -1, *collider.arrays)
                if cut is not None:
                    self.stepper.set_slack(1e-3 * cut.outside_mm)
                names.append(name_of[thing.name])
                parts.append(-1)
        for articulated in self.scene.articulated.values():
            for i, link in enumerate(articulated.links):
                body = model.body(f"articulated/{articulated.name}/{i}").id
                index = name_of[articulated.link_names[i]]
                for geom in () if link.fixed else link.geoms:
                    self.stepper.add_mover(body, index, -1, -1, *geom.collider().arrays)
                    names.append(index)
                    parts.append(-1)
        self.mover_name = np.array(names, dtype=np.int64)
        self.mover_part = np.array(parts, dtype=np.int64)

    @staticmethod
    def told_of(scene: Scene) -> list[str]:
        """Parts of which a scene says something: their entries come after the names."""
        pairs = [(a, b) for a, b, _ in scene.friction_pairs] + [*scene.ignored_pairs]
        return sorted({end for pair in pairs for end in pair if end.startswith("person/")})

    def put(self, scene: Scene, settings: Settings, model_changed: bool) -> None:
        """Another scene of the same shapes; `world_cache` has seen to the model."""
        self.scene, self.settings = scene, settings
        if model_changed:
            self.stepper.set_model(*model_arrays(self.model))
        self._set_pairings()
        set_settings(self.stepper, settings, scene.gravity)
        self.signature = f"{self.names} {fingerprint(self.bodies, scene)}"

    def _entry(self, name: int, joint: int) -> int:
        """Where the pairings have a part of a person."""
        part = f"person/{JOINT_NAMES[joint]}"
        return len(self.names) + self._told.index(part) if part in self._told else name

    def _add_statics(self) -> None:
        from halfphysics.geometry.shapes import Mesh, Plane

        static_name = []
        for index, static in enumerate(self.scene.statics.values()):
            rotation = rot.to_matrix(static.quaternion)
            position = np.asarray(static.position, dtype=np.float64)
            shape = static.shape
            static_name.append(index)
            if isinstance(shape, Plane):
                normal = rotation @ np.asarray(shape.normal, dtype=np.float64)
                self.stepper.add_half_space(index, normal, shape.offset + float(normal @ position))
            elif isinstance(shape, Mesh):
                self.stepper.add_mesh(index, mesh_tree(static, rotation, position))
            else:
                collider = convex_collider(shape).moved(rotation, position)
                self.stepper.add_hull(index, *collider.arrays)
        place = {link.name: link for link in self.links}
        for thing in self.scene.articulated.values():
            for link, name in zip(thing.links, thing.link_names, strict=True):
                if not link.fixed:
                    continue
                # What no joint moves stands.
                position, quaternion = place[name].pose(np.zeros(self.nq))
                rotation = rot.to_matrix(quaternion)
                for geom in link.geoms:
                    c = geom.collider().moved(rotation, position)
                    index = self.names.index(name)
                    self.stepper.add_hull(index, *c.arrays)
                    static_name.append(index)
        self.static_name = np.array(static_name, dtype=np.int64)

    def _add_given(self) -> None:
        """The things that move as told, or not at all yet."""
        from halfphysics.scene.trajectories import Moving

        for thing in self.scene.objects.values():
            body = self.model.body(f"object/{thing.name}").id
            if isinstance(thing, Moving):
                self.stepper.add_trajectory(
                    body, thing.fps, thing.loop, thing.positions, thing.quaternions
                )
            elif thing.start == "asleep" and thing.name not in self.held:
                self.stepper.start_asleep(body)

    def _set_pairings(self) -> None:
        from halfphysics.scene.trajectories import Moving

        n = len(self.names) + len(self._told)
        people = {p.name for p in self.people}
        friction, restitution, ignore = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
        # What nothing pushes meets nothing that nothing pushes.
        unmoved = {n for n, o in self.scene.objects.items() if isinstance(o, Moving)}
        given = unmoved | ({"person", *self._told} if self.settings.mode in FORCED else set())
        unmoved |= set(self.scene.statics)
        owner = self._owner
        known = ["person" if name in people else owner.get(name, name) for name in self.names]
        known += self._told
        for i, a in enumerate(known):
            for j, b in enumerate(known):
                if a == b and a != "person" and a not in self._told:
                    ignore[i, j] = i != j  # links of one articulated object
                    continue  # a thing does not meet itself
                friction[i, j] = self.scene.friction_of(a, b)
                restitution[i, j] = self.scene.restitution_of(a, b)
                both = {a, b}
                ignore[i, j] = self.scene.ignores(a, b) or both <= unmoved or both <= given
        self.stepper.set_pairings(friction, restitution, ignore)

    def _set_strength(self) -> None:
        if self.settings.strength is None:
            return
        for index, person in enumerate(self.people):
            force, torque = limits_of(self.settings.strength, person.body)
            limits = np.concatenate([[force], torque[person.balls]])
            self.stepper.set_strength(index, limits)

    def _set_self_pairs(self) -> None:
        from halfphysics.simulation.self_contact import self_pairs

        of_person = [self_pairs(self, p, self.names.index(p.name)) for p in self.people]
        pairs = np.concatenate([np.zeros((0, 2), dtype=np.int64), *of_person])
        self.stepper.set_self_pairs(pairs.astype(np.float64))

    # -- state -----------------------------------------------------------------------------

    def start(self, poses: Sequence[Pose]) -> tuple[Array, Array]:
        """Coordinates (nq,) and velocities (nv,) with people at `poses`, objects at their start."""
        qpos, qvel = np.zeros(self.nq), np.zeros(self.nv)
        for person, pose in zip(self.people, poses, strict=True):
            q = person.coordinates(pose.translation[None], pose.rotations[None], pose.axes)
            qpos[person.qpos : person.qpos + person.count] = q[0]
        self.place_things(qpos, qvel)
        return qpos, qvel

    def place_things(self, qpos: Array, qvel: Array) -> None:
        """Puts the objects where they start, into coordinates (nq,) and velocities (nv,)."""
        for place, thing in zip(self.things, self.scene.objects.values(), strict=True):
            if isinstance(place, holding.HeldThing):
                continue
            quat = rot.normalize(thing.quaternion)
            arm = rot.rotate(quat, place.com)
            qpos[place.qpos : place.qpos + 3] = thing.position + arm
            qpos[place.qpos + 3 : place.qpos + 7] = quat
            spin = np.asarray(thing.angular_velocity, dtype=np.float64)
            qvel[place.dof : place.dof + 3] = thing.velocity + np.cross(spin, arm)
            qvel[place.dof + 3 : place.dof + 6] = rot.rotate(rot.conjugate(quat), spin)
        for articulated in self.scene.articulated.values():
            jointed.start(self.model, articulated, qpos, qvel)

    def firmness(self, stiffness: Array) -> Array:
        """Firmness (..., people, 55) as the stepper takes it (..., balls)."""
        each = [stiffness[..., i, person.balls] for i, person in enumerate(self.people)]
        return np.ascontiguousarray(np.concatenate(each or [np.zeros(0)], axis=-1))

    def firmness_of(self, balls: Array) -> Array:
        """The reverse of `firmness`: (people, 55)."""
        return self.torques(np.repeat(balls[:, None], 3, axis=1))[..., 0]

    def torques(self, balls: Array) -> Array:
        """Torques (..., people, 55, 3) [N m] of what the stepper gives (..., balls, 3)."""
        out = np.empty((*balls.shape[:-2], len(self.people), N_JOINTS, 3))
        for i, person in enumerate(self.people):
            out[..., i, person.balls, :] = balls[..., i * N_JOINTS : (i + 1) * N_JOINTS, :]
        return out

    @property
    def tracked(self) -> tuple[Thing | holding.HeldThing | jointed.LinkPlace, ...]:
        """All that has a pose of its own in results, in the order of `names`."""
        return (*self.things, *self.links)

    def targets(self, poses: Sequence[Pose]) -> Array:
        """What the stepper's frame() takes: all people's coordinates, one after the other."""
        return np.concatenate(
            [
                person.coordinates(pose.translation[None], pose.rotations[None], pose.axes)[0]
                for person, pose in zip(self.people, poses, strict=True)
            ]
            or [np.zeros(0)]
        )

    def motion_coordinates(self, motions: Sequence[Motion]) -> Array:
        """Targets (T, .) of whole motions of one length."""
        return np.concatenate(
            [
                person.coordinates(m.translation, m.rotations, m.axes)
                for person, m in zip(self.people, motions, strict=True)
            ],
            axis=1,
        )


def armature_of(stiffness: Array) -> Array:
    """Armature of every joint (55,) [kg m^2] at a firmness (55,): fingers have one."""
    armature = np.zeros(N_JOINTS)
    fingers = list(LEFT_HAND_JOINTS + RIGHT_HAND_JOINTS)
    armature[fingers] = FINGER_INERTIA / (1.0 + stiffness[fingers])
    return armature


def set_settings(stepper: Any, settings: Settings, gravity: Array) -> None:
    """Give the stepper its settings and gravity (3,) [m/s^2]."""
    s = settings
    stepper.set_settings(
        0.0 if s.mode == "torque" else s.drive_time or 0.0,
        s.recovery_rate,
        s.root == "recover",
        s.root_speed,
        max(s.clearance, LEAST_CLEARANCE),
        s.clearance_range,
        s.depenetration_speed,
        s.tolerance,
        s.max_sweeps,
        np.array(gravity),
    )
    stepper.set_ablations(
        s.internal_forces,
        s.joint_damping,
        s.torque_frequency if s.mode == "torque" else 0.0,
        s.torque_damping,
    )


def joint_arrays(model: Any) -> tuple[Any, ...]:
    """The arrays of an MjModel that the core's set_joint_forces() takes, in its order."""

    def doubles(x: Any) -> Array:
        return np.ascontiguousarray(x, dtype=np.float64)

    return (
        *map(doubles, (model.dof_damping, model.jnt_stiffness, model.qpos_spring)),
        np.ascontiguousarray(model.jnt_limited, dtype=np.int32),
        doubles(model.jnt_range).reshape(-1, 2),
    )


def model_arrays(model: Any) -> tuple[Any, ...]:
    """The arrays of an MjModel that the core's set_model() takes, in its order."""

    def ints(x: Any) -> NDArray[np.int32]:
        return np.ascontiguousarray(x, dtype=np.int32)

    def doubles(x: Any) -> Array:
        return np.ascontiguousarray(x, dtype=np.float64)

    return (
        *map(ints, (model.body_parentid, model.body_jntadr, model.body_jntnum)),
        *map(ints, (model.body_dofadr, model.body_dofnum)),
        *map(doubles, (model.body_pos, model.body_quat, model.body_ipos, model.body_iquat)),
        *map(doubles, (model.body_mass, model.body_inertia)),
        *map(ints, (model.jnt_type, model.jnt_qposadr, model.jnt_dofadr, model.jnt_bodyid)),
        *map(doubles, (model.jnt_pos, model.jnt_axis, model.qpos0, model.dof_armature)),
    )

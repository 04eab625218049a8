"""Many worlds of one scene side by side: started, stepped and looked at in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics import _native
from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.moment import Figure, Moment, standing_still, tracks
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation import holding, live_edits
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.coordinates import FreeObject
from halfphysics.simulation.core_rows import ContactRows, contact_rows

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Placed = tuple[ArrayLike, ArrayLike]


#: Groups of a person, to be the last of `Plan.groups`: of two that fit the first counts.
PERSON: Mapping[str, tuple[str, ...]] = {
    "feet": ("person/*_ankle", "person/*_foot"),
    "person": ("person/*",),
}


def room() -> Scene:
    """A floor."""
    scene = Scene()
    scene.add_static("floor", Plane())
    return scene


def add_walls(scene: Scene, size: tuple[float, float, float], y: float) -> None:
    """Two walls on the floor, `left_wall` and `right_wall`, with their middles at y and -y [m]."""
    for name, side in (("left_wall", y), ("right_wall", -y)):
        scene.add_static(name, Box(size), position=(0.0, side, 0.5 * size[2]))


#: The arrays of `Worlds`: what is seen of them, and what was told.
_SEEN = ("poses", "motors", "impulses", "_rests", "_fresh")


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What is in every world, and what of it is looked at.

    Attributes:
        scene: Statics, objects, and robots as articulated objects.
        bodies: Of the people.
        motors: "ROBOT/JOINT" -> the most that the motor exerts [N m or N]. The joint's stiffness
            and damping in the robot's file are the motor's gains.
        watched: Whose poses are wanted: an object's name, "ROBOT/LINK", "person/JOINT".
        groups: Name of a group -> patterns of names (as above, and of statics) that belong to it;
            the first group that fits counts. Contacts are summed by group.
    """

    scene: Scene
    bodies: tuple[Body, ...]
    motors: Mapping[str, float] = field(default_factory=dict)
    watched: tuple[str, ...] = ()
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


class Worlds:
    """N worlds of one plan.

    Attributes:
        poses: Position [m] and quaternion of what is watched, (N, watched, 7).
        motors: Coordinates [rad or m] and velocities of the motors, (N, 2, motors).
        impulses: Of the second group's bodies on the first's in the last frame (N, G, G, 4) [N s]:
            the sum in the world, and the sum of lengths.

    Args:
        plan: What is in them.
        count: N.
        dt: Length of a frame [s].
        settings: Of the simulations; None: the defaults.
        threads: Number of threads that step them; no number depends on it.

    Raises:
        InputError: A motor, or a name that is watched, that the scene does not have.
    """

    def __init__(
        self,
        plan: Plan,
        count: int,
        *,
        dt: float,
        settings: Settings | None = None,
        threads: int = 1,
    ) -> None:
        self.plan, self.count, self.dt, self._threads = plan, count, dt, threads
        self.settings = Settings() if settings is None else settings
        self._substeps = self.settings.substeps_for(dt)
        self._first = [build_world(plan.bodies, plan.scene, self.settings) for _ in range(count)]
        self._now = list(self._first)
        watched, motors, groups = len(plan.watched), len(plan.motors), len(plan.groups)
        self._group = {name: i for i, name in enumerate(plan.groups)}
        self._seen = {name: i for i, name in enumerate(plan.watched)}
        self._labels: dict[str, int] = {}
        self._fleet = _native.Fleet(count, threads, bodies=watched, motors=motors, groups=groups)
        self.poses = np.zeros((count, watched, 7))
        self.motors = np.zeros((count, 2, motors))
        self.impulses = np.zeros((count, groups, groups, 4))
        self._rests, self._fresh = np.zeros((count, motors)), np.ones(count, dtype=bool)
        #: Of copied worlds, until they move: the contacts of the frame before they were copied.
        self._before: dict[int, ContactRows] = {}
        for i in range(count):
            self._put(i)

    @property
    def people(self) -> int:
        """Number of people in every world."""
        return len(self.plan.bodies)

    def coordinates(self, poses: Sequence[Pose]) -> Array:
        """The row of `targets` for poses, one per person, (K,)."""
        return self._first[0].targets(poses)

    def joint_places(self, person: int = 0) -> NDArray[np.int64]:
        """Where every joint's quaternion stands in a row of `targets` (55,); the root's position
        (3,) stands before that of the first joint."""
        each = self._first[0].people
        before = sum(p.count for p in each[:person])
        return np.asarray(each[person].joint_qpos) - each[person].qpos + before

    def start(
        self,
        i: int,
        poses: Sequence[Pose],
        joints: Mapping[str, float] | None = None,
        objects: Mapping[str, Placed] | None = None,
    ) -> None:
        """Begin world `i` again.

        Args:
            i: Index of the world.
            poses: Of the people, one each.
            joints: "ROBOT/JOINT" -> where it starts, if not where the scene has it.
            objects: Name -> position (3,) [m] and quaternion (4,), likewise.
        """
        world = self._first[i]
        if self._now[i] is not world:
            self._now[i] = world
            self._put(i)
        qpos, qvel = world.start(poses)
        places = {place.name: place for place in world.joints}
        for name, value in (joints or {}).items():
            qpos[places[name].qpos] = value
        free = {place.name: place for place in world.objects if isinstance(place, FreeObject)}
        for name, (position, quaternion) in (objects or {}).items():
            at, quat = free[name], rot.normalize(quaternion)
            qpos[at.qpos : at.qpos + 3] = np.asarray(position) + rot.rotate(quat, at.com)
            qpos[at.qpos + 3 : at.qpos + 7] = quat
        world.stepper.reset(qpos, qvel)
        self._fresh[i] = True
        self._before.pop(i, None)
        usual = np.tile(world.stiffness, (len(poses), 1))
        world.stepper.set_stiffness(world.stiffness_to_core(usual))
        self._look(i)

    def step(self, targets: Array, rests: Array, active: Flags | None = None) -> None:
        """One frame of all worlds.

        Args:
            targets: Of the people, as `coordinates` has them (N, K).
            rests: Where the motors are told to go (N, motors) [rad or m].
            active: Which worlds move (N,); None: all. Of the others nothing changes.
        """
        every = np.ones(self.count, dtype=bool) if active is None else active
        rates = np.where(self._fresh[:, None], 0.0, (rests - self._rests) / self.dt)
        self._frame(every, targets, rests, rates, self._substeps)
        self._rests = np.where(every[:, None], rests, self._rests)
        self._fresh = self._fresh & ~every
        self._before = {i: rows for i, rows in self._before.items() if not every[i]}

    def attach(self, i: int, name: str, part: str, person: int = 0) -> None:
        """Tie an object to a part of a person where it is now (`Simulator.attach`), until the
        world starts again."""
        world = self._now[i]
        held = holding.with_held(world, name, part, person)
        self._now[i] = live_edits.rebuilt(world, world.made_of, True, held)
        self._put(i)

    def holds(self, i: int, name: str) -> bool:
        """Whether a person of world `i` holds an object."""
        return name in self._now[i].held

    def place(self, name: str) -> Array:
        """Poses (N, 7) of one that is watched."""
        return self.poses[:, self._seen[name]]

    def force(self, on: str, by: str) -> Array:
        """Mean contact force (N, 3) in the last frame on one group by another [N]."""
        out: Array = self.impulses[:, self._group[on], self._group[by], :3] / self.dt
        return out

    def load(self, on: str, by: str) -> Array:
        """Sum of the magnitudes of those forces (N,) [N]: what presses from both sides counts."""
        out: Array = self.impulses[:, self._group[on], self._group[by], 3] / self.dt
        return out

    def touched(self, group: str) -> NDArray[np.bool_]:
        """Whether anything of a group has been pushed in the last frame (N,)."""
        load = self.impulses[:, self._group[group], :, 3]
        touched: Flags = np.any(load > 0.0, axis=1)
        return touched

    @property
    def names(self) -> tuple[str, ...]:
        """What `contacts` refer to."""
        return self._first[0].names

    def contacts(self, i: int) -> ContactRows:
        """The contacts of world `i` in its last frame."""
        world = self._now[i]
        if i in self._before:
            return self._before[i]
        return contact_rows(world, world.stepper.touches())[0]

    def person_pose(self, i: int, person: int = 0) -> Pose:
        """The simulated pose of a person of world `i`."""
        world, axes = self._now[i], np.eye(3)
        return Pose.trusted(*world.people[person].pose(world.stepper.qpos(), axes), axes)

    def moment(self, i: int) -> Moment:
        """Everything of world `i` as it is now, for pictures."""
        world = self._now[i]
        qpos = world.stepper.qpos()
        people = tuple(
            Figure(body, standing_still(self.person_pose(i, k)))
            for k, body in enumerate(world.bodies)
        )
        poses = {place.name: place.pose(qpos) for place in world.tracked}
        return Moment(people=people, scene=world.made_of, objects=tracks(poses))

    def __getstate__(self) -> dict[str, Any]:
        """For copies and other processes: what the worlds are made of, and their states."""
        return {
            "made": (self.plan, self.count, self.dt, self.settings, self._threads),
            "held": [dict(world.held) for world in self._now],
            "states": [world.stepper.save().tobytes() for world in self._now],
            "contacts": [self.contacts(i) for i in range(self.count)],
            "seen": {name: getattr(self, name) for name in _SEEN},
        }

    def __setstate__(self, given: dict[str, Any]) -> None:
        plan, count, dt, settings, threads = given["made"]
        Worlds.__init__(self, plan, count, dt=dt, settings=settings, threads=threads)
        for i, (held, state) in enumerate(zip(given["held"], given["states"], strict=True)):
            if held:
                self._now[i] = build_world(plan.bodies, plan.scene, self.settings, held)
                self._put(i)
            self._now[i].stepper.load(np.frombuffer(state))
        self._before = dict(enumerate(given["contacts"]))
        vars(self).update(given["seen"])

    # -- inside ----------------------------------------------------------------------------

    def _frame(
        self, active: Flags, targets: Array, rests: Array, rates: Array, substeps: int
    ) -> None:
        self._fleet.frame(
            active=np.ascontiguousarray(active, dtype=np.int32),
            targets=np.ascontiguousarray(targets),
            rests=np.ascontiguousarray(rests),
            rates=np.ascontiguousarray(rates),
            dt=self.dt,
            substeps=substeps,
            poses=self.poses.reshape(self.count, -1),
            states=self.motors.reshape(self.count, -1),
            impulses=self.impulses.reshape(self.count, -1),
        )

    def _look(self, i: int) -> None:
        """Fill in what is seen of world `i`, which does not move."""
        active = np.zeros(self.count, dtype=bool)
        active[i] = True
        targets = np.zeros((self.count, sum(p.count for p in self._first[0].people)))
        self._frame(active, targets, self._rests, self._rests, 0)

    def _put(self, i: int) -> None:
        """Give the core the world that is now the `i`-th."""
        world = self._now[i]
        names = [_body_of(world, name) for name in self.plan.watched]
        motors = [_joint_of(world, name) for name in self.plan.motors]
        labels = [
            name if part < 0 else f"{name}/{JOINT_NAMES[part]}"
            for name, part, _ in world.shape_keys
        ]
        static = [world.names[name] for name in world.static_name]
        self._fleet.put(
            i,
            world.stepper,
            bodies=np.array(names, dtype=np.int32),
            motors=np.array(motors, dtype=np.int32),
            effort=np.array(list(self.plan.motors.values()), dtype=np.float64),
            shape_group=self._groups(labels),
            static_group=self._groups(static),
        )

    def _groups(self, labels: Sequence[str]) -> NDArray[np.int32]:
        """The group of every label, -1: none."""
        return np.array([self._group_of(label) for label in labels], dtype=np.int32)

    def _group_of(self, label: str) -> int:
        if label not in self._labels:
            groups = enumerate(self.plan.groups.values())
            fits = (g for g, ps in groups if any(fnmatchcase(label, p) for p in ps))
            self._labels[label] = next(fits, -1)
        return self._labels[label]


def _body_of(world: World, name: str) -> int:
    """The core's body of a watched name."""
    owner, _, rest = name.partition("/")
    for person in world.people:
        if person.name == owner and rest in JOINT_INDEX:
            return int(person.bodies[JOINT_INDEX[rest]])
    if name in world.made_of.objects:
        return int(world.joined.body(f"object/{name}").id)
    item = world.made_of.articulated.get(owner)
    if item is not None and name in item.link_names:
        index = item.link_names.index(name)
        return int(world.joined.body(f"articulated/{owner}/{index}").id)
    raise InputError(
        f"watched: found {name!r}, expected an object, 'ROBOT/LINK' or 'person/JOINT'. There are: "
        f"{', '.join(world.names)}"
    )


def _joint_of(world: World, name: str) -> int:
    """The core's joint of a motor."""
    owner, _, rest = name.partition("/")
    item = world.made_of.articulated.get(owner)
    for i, link in enumerate(item.links if item is not None else ()):
        for k, joint in enumerate(link.joints):
            if joint.name == rest:
                return int(world.joined.joint(f"articulated/{owner}/{i}/{k}").id)
    known = ", ".join(place.name for place in world.joints)
    raise InputError(f"motors: found {name!r}, expected a joint of a robot. There are: {known}")

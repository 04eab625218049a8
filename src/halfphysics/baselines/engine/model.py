"""People and a scene, compiled for MuJoCo, and what the compiled model's numbers stand for."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.baselines.engine.scenery import add_scene
from halfphysics.body.mjcf_person import add_person, add_person_mocap
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.results.result import ObjectTrack
from halfphysics.scene import articulated as jointed
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.simulation.coordinates import Person

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Bits of `contype` that are left for telling people apart.
_MOST_PEOPLE = 30

_NAMED = 5  # this many names are given


class EngineModel:
    """A world's people and scene as a MuJoCo model; its contacts are read by `touches`.

    Attributes:
        model: The `mujoco.MjModel`.
        names: As those of the world.
        people: Their places in the model's coordinates; of mocap people only names and bodies.
        mocap: Mocap ids of the people's parts (people, 55); empty where they are trees of joints.
        moving: (mocap id, thing) of everything on a given trajectory.
        static_name, shape_name: Of every geom the index into `names` (ngeom,).
        shape_part: Of every geom the joint's index (ngeom,), -1 where it is no person's.
        rank: Of every geom 0 for a person, 1 for an item that moves, 2 for a static (ngeom,).
    """

    def __init__(self, world: World, timestep: float, *, mocap: bool) -> None:
        import mujoco

        scene = world.scene
        if len(world.bodies) > _MOST_PEOPLE:
            raise InputError(
                f"found {len(world.bodies)} people, expected at most {_MOST_PEOPLE} in MuJoCo"
            )
        spec = mujoco.MjSpec()
        prefixes = [f"{person.name}/" for person in world.people]
        for i, (prefix, body) in enumerate(zip(prefixes, world.bodies, strict=True)):
            # One bit for items, one per person; a person meets those that were added before.
            mine, theirs = 1 | 2 << i, sum(2 << j for j in range(i))
            add = add_person_mocap if mocap else add_person
            add(spec, body.variant, prefix, contype=mine, conaffinity=theirs)
        # Nothing answers to mocap bodies but what can move: no need to cut a room for them.
        objects = scene.objects.values()
        answers = bool(scene.articulated) or not all(
            isinstance(o, KinematicObject) for o in objects
        )
        owner = add_scene(spec, scene, people=prefixes) if answers or not mocap else {}
        _warn_of_unheeded(scene)
        spec.option.gravity = scene.gravity
        spec.option.timestep = timestep
        # The sparse factor of MuJoCo 4.0.0's Newton solver is wrong; the numbers are the same.
        spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.model = spec.compile()
        self.names = world.names
        self._scene = scene
        self._places = [jointed.places(self.model, t) for t in scene.articulated.values()]
        self._name_people(world, prefixes, mocap)
        self._name_geoms(owner, prefixes)
        self.moving = tuple(
            (int(self.model.body(f"object/{item.name}").mocapid[0]), item)
            for item in objects
            if owner and isinstance(item, KinematicObject)
        )

    def _name_people(self, world: World, prefixes: Sequence[str], mocap: bool) -> None:
        model = self.model
        if mocap:
            self.people = world.people
            ids = [[model.body(p + name).mocapid[0] for name in JOINT_INDEX] for p in prefixes]
            self.mocap = np.array(ids, dtype=np.int64).reshape(-1, N_JOINTS)
            return
        self.mocap = np.zeros((0, N_JOINTS), dtype=np.int64)
        found = []
        for person, prefix in zip(world.people, prefixes, strict=True):
            found.append(Person.of(model, prefix, person.name, person.body))
        self.people = tuple(found)

    def _name_geoms(self, owner: dict[str, str], prefixes: Sequence[str]) -> None:
        model, names = self.model, self.names
        index = {name: i for i, name in enumerate(names)}
        first_person = len(names) - len(self.people)
        self.shape_name = np.full(model.ngeom, -1, dtype=np.int64)
        self.shape_part = np.full(model.ngeom, -1, dtype=np.int64)
        self.rank = np.zeros(model.ngeom, dtype=np.int64)
        for geom in range(model.ngeom):
            name = model.geom(geom).name
            if name in owner:
                body = model.geom_bodyid[geom]
                stands = model.body_weldid[body] == 0 and model.body_mocapid[body] < 0
                self.shape_name[geom] = index[owner[name]]
                self.rank[geom] = 2 if stands else 1
                continue
            prefix, joint = name.rsplit("/", 1)
            self.shape_name[geom] = first_person + prefixes.index(f"{prefix}/")
            self.shape_part[geom] = JOINT_INDEX[joint]
        self.static_name = self.shape_name

    def start(self) -> tuple[Array, Array]:
        """Coordinates (nq,) and velocities (nv,) at the start; the people's are not set."""
        model = self.model
        qpos, qvel = np.array(model.qpos0), np.zeros(model.nv)
        for item in self._scene.objects.values():
            if isinstance(item, KinematicObject):
                continue
            joint = model.body(f"object/{item.name}").jntadr[0]
            dof, quat = int(model.jnt_dofadr[joint]), rot.normalize(item.quaternion)
            qvel[dof : dof + 3] = item.velocity
            qvel[dof + 3 : dof + 6] = rot.rotate(rot.conjugate(quat), item.angular_velocity)
        for whole in self._scene.articulated.values():
            jointed.start(model, whole, qpos, qvel)
        return qpos, qvel

    def tracks(self, qpos: Array, times: Array) -> dict[str, ObjectTrack]:
        """Objects and links at coordinates (T, nq) and times (T,) [s]."""
        tracks = {}
        for name, item in self._scene.objects.items():
            if isinstance(item, KinematicObject):
                position, quaternion = item.at(times)
            else:
                joint = self.model.body(f"object/{name}").jntadr[0]
                at = int(self.model.jnt_qposadr[joint])
                position, quaternion = qpos[:, at : at + 3], qpos[:, at + 3 : at + 7]
            tracks[name] = ObjectTrack(position=position, quaternion=quaternion)
        for links, _ in self._places:
            for link in links:
                position, quaternion = link.pose(qpos)
                tracks[link.name] = ObjectTrack(position=position, quaternion=quaternion)
        return tracks

    def joints(self, qpos: Array) -> dict[str, Array]:
        """Values of the joints of articulated objects at coordinates (T, nq)."""
        return {joint.name: joint.values(qpos) for _, joints in self._places for joint in joints}


def _warn_of_unheeded(scene: Scene) -> None:
    """One warning of each kind of property that MuJoCo's defaults do not know."""
    items: list[Any] = [*scene.statics.values(), *scene.objects.values()]
    items += scene.articulated.values()
    bouncy = [item.name for item in items if item.restitution > 0.0]
    asleep = [item.name for item in scene.objects.values() if item.start == "asleep"]
    for names, what in (
        (bouncy, "restitution is not heeded: MuJoCo's contact knows none"),
        (asleep, "starts awake: nothing is asleep in MuJoCo until it is touched"),
    ):
        if names:
            more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
            warnings.warn(
                f"{', '.join(map(repr, names[:_NAMED]))}{more}: {what}",
                HalfPhysicsWarning,
                stacklevel=7,  # the line that called `simulate`
            )

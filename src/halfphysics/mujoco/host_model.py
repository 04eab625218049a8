"""The core's model of a MuJoCo world and people in it: what can touch what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.motion.joint_groups import stiffness_array
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.mujoco import geoms
from halfphysics.mujoco.host_masses import gravity_of
from halfphysics.scene.items import PERSON_FRICTION
from halfphysics.settings import Settings
from halfphysics.simulation.compiled_model import armature_of, model_arrays
from halfphysics.simulation.coordinates import Person
from halfphysics.simulation.core_settings import set_footing, set_limits, set_settings
from halfphysics.simulation.joined_model import join_beside
from halfphysics.simulation.person_shapes import add_person_shapes
from halfphysics.simulation.self_contact import set_self_pairs

if TYPE_CHECKING:
    from halfphysics.mujoco.attach import Human

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Before the names of the people's bodies in the core's model, beside their mirrors in MuJoCo's.
SIMULATED = "simulated/"


@dataclass(frozen=True, kw_only=True, eq=False)
class HostModel:
    """A core that holds a MuJoCo world and its people.

    Attributes:
        stepper: The core.
        people: Where the people stand in its coordinates.
        names: Names to which contacts refer: the world's geoms, then the people.
        shape_name, shape_part: Of every shape its name's index and its joint, -1: none.
        static_name: Of every piece of static geometry its name's index.
        shape_geom, static_geom: The same as geoms of the MuJoCo model, -1: none.
        mirrors: Bodies of the core's people and their mocap rows in MuJoCo (n, 2).
        bodies: Ids in MuJoCo of the core's bodies 1 to n, which people's come after (n,).
        masses: Of the core's bodies [kg].
    """

    stepper: Any
    people: tuple[Person, ...]
    names: tuple[str, ...]
    shape_name: Ints
    shape_part: Ints
    static_name: Ints
    shape_geom: Ints
    static_geom: Ints
    mirrors: NDArray[np.int32]
    bodies: NDArray[np.int32]
    masses: Array


def host_model(model: Any, humans: Sequence[Human], settings: Settings) -> HostModel:
    """Put a compiled `mujoco.MjModel` and the people in it into a core.

    Raises:
        InputError: A model without these people, geoms that cannot be touched, or two geoms of
            one name.
    """
    from halfphysics import _native

    mirrors = [_mirrors(model, human) for human in humans]
    armature = armature_of(stiffness_array(settings.stiffness, "Settings.stiffness"))
    bodies = _world_bodies(model, humans)
    joint = join_beside(model, bodies, {SIMULATED + h.prefix: h.body for h in humans}, armature)
    people = tuple(
        Person.of(joint, SIMULATED + h.prefix, h.prefix.rstrip("/") or "human", h.body)
        for h in humans
    )
    stepper = _native.Stepper()
    stepper.set_model(**model_arrays(joint))
    shapes = _Shapes(stepper, model, bodies, people)
    for index, (human, person) in enumerate(zip(humans, people, strict=True)):
        shapes.add_person(joint, index, human, person, settings)
    shapes.add_geoms()
    shapes.set_pairings(len(people))
    set_settings(stepper, settings, gravity_of(model))
    stepper.finish([person.root for person in people])
    set_limits(stepper, settings, people)
    set_footing(stepper, settings, people)
    table = shapes.arrays()
    if settings.self_contact:
        first = len(shapes.geoms)
        parts = [
            np.where(table["shape_name"] == first + i, table["shape_part"], -1)
            for i in range(len(people))
        ]
        set_self_pairs(stepper, joint, people, parts)
    own = np.concatenate([person.bodies for person in people])
    return HostModel(
        stepper=stepper,
        people=people,
        names=shapes.names,
        masses=np.array(joint.body_mass),
        mirrors=np.stack([own, np.concatenate(mirrors)], axis=1).astype(np.int32),
        bodies=bodies.astype(np.int32),
        **table,
    )


def _mirrors(model: Any, human: Human) -> Ints:
    """The mocap rows of a person's parts (55,)."""
    try:
        ids = [model.body(human.prefix + name).id for name in JOINT_NAMES]
    except KeyError as error:
        raise InputError(
            f"bind: the model has no person with prefix {human.prefix!r}; was it compiled from "
            "the spec that attach was given?"
        ) from error
    rows = np.asarray(model.body_mocapid)[ids]
    if (rows < 0).any():
        raise InputError(
            f"bind: the bodies named {human.prefix}... are no mocap bodies, so attach did not "
            "add them; expected the model of the spec that attach was given"
        )
    return rows.astype(np.int64)


def _world_bodies(model: Any, humans: Sequence[Human]) -> Ints:
    """All bodies but the world's and the people's mirrors, which the core has no use for."""
    mirrors = {model.body(human.prefix + name).id for human in humans for name in JOINT_NAMES}
    parents = {int(p) for p in np.asarray(model.body_parentid)}
    ids = [b for b in range(1, model.nbody) if b not in mirrors or b in parents]
    return np.array(ids, dtype=np.int64)


class _Shapes:
    """The shapes of a world and its people, as they are handed to a core."""

    def __init__(self, stepper: Any, model: Any, bodies: Ints, people: Sequence[Person]) -> None:
        self._stepper, self._model = stepper, model
        self._number = {int(body): i + 1 for i, body in enumerate(bodies)}
        self.geoms = [g for g in range(model.ngeom) if geoms.collides(model, g)]
        people_names = [person.name for person in people]
        self.names = (*(geoms.geom_name(model, g) for g in self.geoms), *people_names)
        if len(set(self.names)) < len(self.names):
            raise InputError(
                f"bind: two geoms of one name, or one named {' or '.join(map(repr, people_names))}"
            )
        self._shapes: list[tuple[int, int, int]] = []  # name, part, geom
        self._statics: list[tuple[int, int]] = []  # name, geom

    def arrays(self) -> dict[str, Ints]:
        """The columns of `HostModel`."""
        shapes = np.array(self._shapes, dtype=np.int64).reshape(-1, 3)
        statics = np.array(self._statics, dtype=np.int64).reshape(-1, 2)
        return {
            "shape_name": shapes[:, 0],
            "shape_part": shapes[:, 1],
            "shape_geom": shapes[:, 2],
            "static_name": statics[:, 0],
            "static_geom": statics[:, 1],
        }

    def add_person(
        self, joint: Any, index: int, human: Human, person: Person, settings: Settings
    ) -> None:
        """The person's skin or rigid parts; their geoms in MuJoCo are those of the parts."""
        name = len(self.geoms) + index
        parts = add_person_shapes(
            self._stepper,
            joint,
            person.body,
            settings,
            prefix=SIMULATED + human.prefix,
            index=index,
            row=lambda _: name,
        )
        mirror = [self._model.body(human.prefix + part).id for part in JOINT_NAMES]
        geom = [
            int(self._model.body_geomadr[b]) if self._model.body_geomnum[b] else -1 for b in mirror
        ]
        self._shapes += [(name, part, geom[part]) for part in parts]

    def add_geoms(self) -> None:
        """All geoms that collide: fixed ones as static geometry, others as shapes of bodies."""
        model = self._model
        rotations, positions = geoms.fixed_poses(model)
        for name, g in enumerate(self.geoms):
            body = int(model.geom_bodyid[g])
            if model.body_mocapid[model.body_rootid[body]] >= 0:
                raise InputError(
                    f"bind: geom '{self.names[name]}' is on a mocap body, which nothing can "
                    "touch; give the body joints, or set contype and conaffinity to 0"
                )
            if model.body_weldid[body] == 0:
                self._add_static(name, g, rotations[g], positions[g])
                continue
            rotation, position = geoms.pose_in_body(model, g)
            collider = geoms.geom_collider(model, g).moved(rotation, position)
            self._stepper.add_shape(self._number[body], name, -1, -1, *collider.arrays)
            self._shapes.append((name, -1, g))

    def _add_static(self, name: int, geom: int, rotation: Array, position: Array) -> None:
        from halfphysics import _native

        self._statics.append((name, geom))
        kind = geoms.geom_kind(self._model, geom)
        if kind == "plane":
            normal = np.ascontiguousarray(rotation[:, 2])
            self._stepper.add_half_space(name, normal, float(normal @ position))
        elif kind in ("mesh", "hfield"):
            vertices, faces = geoms.mesh_triangles(self._model, geom)
            world = np.ascontiguousarray(vertices @ rotation.T + position)
            self._stepper.add_mesh(name, _native.MeshTree(world, faces))
        else:
            collider = geoms.geom_collider(self._model, geom).moved(rotation, position)
            self._stepper.add_hull(name, *collider.arrays)

    def set_pairings(self, people: int) -> None:
        """People touch everything, each other too; all other pairs are left to MuJoCo."""
        n = len(self.names)
        own = np.append(self._model.geom_friction[self.geoms, 0], [PERSON_FRICTION] * people)
        friction = np.minimum.outer(own, np.minimum(own, PERSON_FRICTION))
        ignore = np.ones((n, n))
        ignore[n - people :] = ignore[:, n - people :] = 0.0
        self._stepper.set_pairings(np.minimum(friction, friction.T), np.zeros((n, n)), ignore)

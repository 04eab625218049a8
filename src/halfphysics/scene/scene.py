"""A scene: static geometry, objects, articulated objects, and the properties of their pairs.

World z-up, metres, kilograms, seconds; quaternions wxyz.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.arrays import as_array
from halfphysics.base.copying import ReadOnly
from halfphysics.base.in_notebook import InNotebook
from halfphysics.base.validation import number, vector
from halfphysics.geometry.convex_decomposition import THRESHOLD
from halfphysics.geometry.shape_base import Shape
from halfphysics.scene.items import (
    OBJECT_FRICTION,
    PERSON_FRICTION,
    STATIC_FRICTION,
    Object,
    Static,
    checked_layer,
    checked_material,
    checked_name,
    checked_pose,
    checked_shape,
)
from halfphysics.scene.material_pairs import MaterialPairs, checked_pair, of_person
from halfphysics.scene.mesh_doubts import warn_of_doubts
from halfphysics.scene.object_builder import PieceOptions, build_kinematic, build_object
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.scene.articulated import Articulated
    from halfphysics.scene.rays import Hit
    from halfphysics.scene.soft import Soft

Array = NDArray[np.float64]


class Scene(InNotebook, ReadOnly):
    """Statics, objects, articulated objects, gravity, and friction and exclusions of pairs.

    gravity: acceleration downward (-z) [m/s^2], or its vector (3,).
    """

    def __init__(self, gravity: float | ArrayLike = 9.81) -> None:
        try:
            is_vector = as_array(gravity).ndim > 0
        except (TypeError, ValueError):
            is_vector = True  # lists of no numbers, which the check says
        if is_vector:
            self._gravity = vector(gravity, "Scene: gravity", unit="m/s^2")
        else:
            down = number(gravity, "Scene: gravity (downward; a vector points anywhere)", least=0.0)
            self._gravity = vector([0.0, 0.0, 0.0 - down], "Scene: gravity")
        self._statics: dict[str, Static] = {}
        self._objects: dict[str, Object] = {}
        self._articulated: dict[str, Articulated] = {}
        self._pairs = MaterialPairs()

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall (3,) [m/s^2]; by default (0, 0, -9.81)."""
        return self._gravity

    @property
    def statics(self) -> Mapping[str, Static]:
        """Static geometry by name, in the order added (read-only)."""
        return MappingProxyType(self._statics)

    @property
    def objects(self) -> Mapping[str, Object]:
        """Free and kinematic objects by name, in the order added (read-only)."""
        return MappingProxyType(self._objects)

    @property
    def articulated(self) -> Mapping[str, Articulated]:
        """Articulated objects by name, in the order added (read-only)."""
        return MappingProxyType(self._articulated)

    def __repr__(self) -> str:
        jointed = f", articulated={list(self._articulated)}" if self._articulated else ""
        return f"Scene(statics={list(self._statics)}, objects={list(self._objects)}{jointed})"

    def add_static(
        self,
        name: str,
        shape: Shape | str | os.PathLike[str] | Any,
        *,
        scale: float = 1.0,
        position: ArrayLike = (0.0, 0.0, 0.0),
        quaternion: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        up: str | None = None,
        friction: float = STATIC_FRICTION,
        restitution: float = 0.0,
        soft: Soft | str | Mapping[str, Any] | None = None,
    ) -> Static:
        """Add static geometry.

        Args:
            name: New in this scene.
            shape: A shape, the path of a mesh file, a `trimesh.Trimesh` or `trimesh.Scene`.
            scale: Metres per unit of a mesh.
            position, quaternion: Pose of its frame in the world (3,) [m], (4,).
            up: Axis of a mesh that points up, "y" or "z"; None: y for glTF files, else z.
            friction: Coulomb coefficient; a pair has the smaller of the two.
            restitution: 0 to 1; a pair has the larger of the two.
            soft: A layer that gives way, `halfphysics.Soft`, or a material's name, such as "sofa"
                (docs/soft.md). The shape is then its unloaded surface. None: hard.

        Raises:
            InputError: An impossible value. FileError: A mesh file that cannot be used.

        Warns:
            HalfPhysicsWarning: A mesh seems to be in another unit than `scale` says, or to have
                another axis up where `up` is None.
        """
        what = checked_name(self, name, "static")
        pose = checked_pose(what, position, quaternion)
        material = checked_material(what, friction, restitution)
        made, source = checked_shape(what, shape, scale, up)
        warn_of_doubts(what, made, pose, source, scale, up)
        layer = checked_layer(what, soft, made)
        static = Static(name=name, shape=made, source=source, soft=layer, **pose, **material)
        self._statics[name] = static
        return static

    def add_object(
        self,
        name: str,
        shape: Shape | str | os.PathLike[str] | Any,
        *,
        mass: float | None = None,
        density: float | None = None,
        friction: float = OBJECT_FRICTION,
        restitution: float = 0.0,
        com: ArrayLike | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        quaternion: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        scale: float = 1.0,
        up: str | None = None,
        start: str = "awake",
        pieces: str | Sequence[Any] = "auto",
        threshold: float = THRESHOLD,
        max_pieces: int | None = None,
        soft: Soft | str | Mapping[str, Any] | None = None,
    ) -> Object:
        """Add a rigid body that moves by contact and gravity.

        Args:
            name: New in this scene.
            shape: A shape that has a volume, the path of a mesh file, or a trimesh. A mesh that
                is not convex collides as convex pieces, whose error is in `decomposition`.
            mass, density: Exactly one of them [kg], [kg/m^3]; a mesh that is not closed needs a
                mass.
            friction, restitution: As for statics.
            com: Centre of mass (3,) in the object's frame [m]; None: that of uniform density.
                The inertia about it remains that of uniform density.
            position, quaternion: Pose of its frame in the world at the start.
            velocity, angular_velocity: Of its origin [m/s], [rad/s], in the world, at the start.
            scale, up: As for statics.
            start: "asleep": it is held in place, supported or not, until a person or another
                moving body touches it (or a sleeping object on top of it); then it is awake for
                good.
            pieces: Collision geometry of a mesh. "auto": the mesh if it is convex, else pieces by
                coacd (cached). "hull": its convex hull. Or a sequence of convex meshes, in the
                object's frame [m].
            threshold: Largest distance by which pieces should stick out of the mesh [m].
            max_pieces: Largest number of pieces; None: as many as the threshold requires.
            soft: A layer that gives way, as for statics: a cushion, a ball.

            Warns (`HalfPhysicsWarning`) if pieces deviate by more than 5 mm, if coacd is needed and
            not installed (the hull is used), and if a mesh is not closed.

        Raises:
            InputError: An impossible value. FileError: A mesh file that cannot be used.
        """
        item = build_object(
            checked_name(self, name, "object"),
            shape,
            PieceOptions(pieces=pieces, threshold=threshold, max_pieces=max_pieces),
            name=name,
            mass=mass,
            density=density,
            friction=friction,
            restitution=restitution,
            com=com,
            position=position,
            quaternion=quaternion,
            velocity=velocity,
            angular_velocity=angular_velocity,
            scale=scale,
            up=up,
            start=start,
            soft=soft,
        )
        self._keep(item)
        return item

    def add_moving(
        self,
        name: str,
        shape: Shape | str | os.PathLike[str] | Any,
        positions: ArrayLike,
        quaternions: ArrayLike | None = None,
        *,
        fps: float,
        friction: float = STATIC_FRICTION,
        restitution: float = 0.0,
        loop: bool = False,
        scale: float = 1.0,
        up: str | None = None,
        soft: Soft | str | Mapping[str, Any] | None = None,
    ) -> KinematicObject:
        """Add a kinematic object: it moves along a given trajectory and pushes other bodies.

        It has the velocity of its trajectory and, in contacts, infinite mass; it passes through
        statics and other kinematic objects. If no step is possible, because a person is wedged
        between it and static geometry, it waits and continues its trajectory that much later
        (`Result.lost_time`).

        Args:
            name: New in this scene.
            shape: As for objects.
            positions, quaternions: Poses of its frame in the world, (K, 3) [m] and (K, 4),
                interpolated linearly and by SLERP; None: it does not rotate.
            fps: Poses per second, independent of the motion's frame rate. The first pose is that at
                the start.
            friction, restitution: As for statics.
            loop: The first pose follows the last one, 1/fps later; else it stays at the last pose.
            scale, up, soft: As for statics.

        Raises:
            InputError: An impossible value. FileError: A mesh file that cannot be used.
        """
        item = build_kinematic(
            checked_name(self, name, "kinematic object"),
            shape,
            positions,
            quaternions,
            name=name,
            fps=fps,
            friction=friction,
            restitution=restitution,
            loop=loop,
            scale=scale,
            up=up,
            soft=soft,
        )
        self._keep(item)
        return item

    def add_articulated(
        self,
        name: str,
        source: str | os.PathLike[str] | Any,
        *,
        position: ArrayLike = (0.0, 0.0, 0.0),
        quaternion: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        friction: float = OBJECT_FRICTION,
        restitution: float = 0.0,
        joints: Mapping[str, Any] | None = None,
        velocities: Mapping[str, Any] | None = None,
        mass: float | None = None,
    ) -> Articulated:
        """Add links and joints from MJCF or URDF: a door, a drawer, a laptop.

        Joints keep their ranges, damping, springs and armature. Links of one articulated object
        do not collide with each other; meshes collide as their convex hulls; geoms whose contype
        and conaffinity are 0 are only visible. Actuators, tendons, equalities and friction losses
        are ignored, with a `HalfPhysicsWarning` each.

        Args:
            name: New in this scene. Results name its links "NAME/LINK", its joints "NAME/JOINT".
            source: The path of a .xml or .urdf file, MJCF or URDF text, or a `mujoco.MjSpec`.
            position, quaternion: Pose of its world frame in ours.
            friction, restitution: Of all its links; as for statics.
            joints: Start values of joints: name -> value [rad or m], or (4,) of a ball joint.
            velocities: Start velocities: name -> [rad/s or m/s], or (3,) of a ball joint.
            mass: Of all links that move [kg]: their masses and inertias are scaled evenly to it.
                None: as in the model.

        Raises:
            InputError: A model that cannot be used, an unknown joint, a start beyond its range.
            FileError: A file that is not there.
        """
        from halfphysics.scene.mjcf_import import load_articulated

        what = checked_name(self, name, "articulated")
        pose = checked_pose(what, position, quaternion)
        material = checked_material(what, friction, restitution)
        if mass is not None:
            mass = number(mass, f"{what}: mass", above=0.0, unit="kg")
        item = load_articulated(
            name, source, joints=joints, velocities=velocities, **pose, **material
        ).weighing(mass)
        self._articulated[name] = item
        return item

    def friction(self, a: str, b: str, mu: float) -> None:
        """Coulomb friction `mu` between two items, instead of the smaller of their own.

        `a`, `b`: names of this scene, or "person" for every part of every person, or one part of
        every person by its joint, "person/left_foot" (`JOINT_NAMES`), which has precedence over
        "person". Raises `InputError` for an unknown name and for a negative mu.
        """
        pair = self._pair("friction", a, b)
        mu = number(mu, f"friction between {a!r} and {b!r}", least=0.0)
        self._pairs.set_friction(pair, mu)

    def ignore(self, a: str, b: str) -> None:
        """Let two items pass through each other; names as in `friction`."""
        self._pairs.ignore(self._pair("ignore", a, b))

    def friction_of(self, a: str, b: str) -> float:
        """Coulomb friction between two items (names as in `friction`)."""
        self._pair("friction_of", a, b)
        items = self._items()
        return self._pairs.friction(
            a, b, lambda n: PERSON_FRICTION if of_person(n) else float(items[n].friction)
        )

    def restitution_of(self, a: str, b: str) -> float:
        """Restitution between two items: the larger of the two (a person has 0)."""
        self._pair("restitution_of", a, b)
        items = self._items()
        return max(0.0 if of_person(n) else items[n].restitution for n in (a, b))

    def ignores(self, a: str, b: str) -> bool:
        """Whether two items pass through each other (names as in `friction`)."""
        self._pair("ignores", a, b)
        return self._pairs.ignores(a, b)

    def ray(
        self, origin: ArrayLike, direction: ArrayLike, *, ignore: Collection[str] = ()
    ) -> Hit | None:
        """First hit of a ray from `origin` (3,) [m] along `direction` (3,); None: no hit.

        Statics, objects and links (at their start poses) are hit at the surfaces that collide; a
        ray that starts inside a solid hits its surface from inside. `ignore`: names of items to
        pass through. `Simulator.ray` does the same in a running simulation, with its people.

        Raises:
            InputError: No vector, a direction of no length, an unknown name.
        """
        from halfphysics.scene.rays import scene_ray

        return scene_ray(self, origin, direction, ignore)

    @property
    def friction_pairs(self) -> tuple[tuple[str, str, float], ...]:
        """Arguments of `friction`: (a, b, mu), names sorted."""
        return self._pairs.friction_pairs

    @property
    def ignored_pairs(self) -> tuple[tuple[str, str], ...]:
        """Arguments of `ignore`: (a, b), names sorted."""
        return self._pairs.ignored_pairs

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Scene:
        """Scene from a YAML or JSON file; see docs/scene-files.md.

        Raises:
            FileError: The file or a mesh that it names is missing or wrong; the message names the
                line and a remedy.
        """
        from halfphysics.scene.scene_file import load_scene

        return load_scene(path)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a scene file (.yaml, .yml or .json); mesh files are named relative to it.

        Meshes that came from no file are written in full. Raises `InputError` for another suffix
        and `FileError` if the file cannot be written, or would be longer than `load` reads.
        """
        from halfphysics.scene.scene_writer import save_scene

        save_scene(self, path)

    def _copied(self, without: str | None = None) -> Scene:
        """A new scene of the same items and pairs, but for the object or static `without`."""
        scene = Scene(self._gravity)
        scene._statics = {n: s for n, s in self._statics.items() if n != without}
        scene._objects = {n: o for n, o in self._objects.items() if n != without}
        scene._articulated = dict(self._articulated)
        scene._pairs = self._pairs.copied(without)
        return scene

    def _with(
        self,
        items: Mapping[str, Static | Object | Articulated],
        friction: Mapping[tuple[str, str], float],
    ) -> Scene:
        """A new scene in which `items` replace those of their names, with `friction` of pairs."""
        scene = self._copied()
        groups: tuple[dict[str, Any], ...] = (scene._statics, scene._objects, scene._articulated)
        for group in groups:
            group.update({name: items[name] for name in group if name in items})
        for (a, b), mu in friction.items():
            scene.friction(a, b, mu)
        return scene

    def _items(self) -> dict[str, Any]:
        """All items by name: statics, objects, articulated objects."""
        return {**self._statics, **self._objects, **self._articulated}

    def _keep(self, item: Object) -> None:
        """Add an object; kinematic ones come last: the order in files and results."""
        self._objects[item.name] = item
        if not isinstance(item, KinematicObject):
            for name in [n for n, o in self._objects.items() if isinstance(o, KinematicObject)]:
                self._objects[name] = self._objects.pop(name)

    def _pair(self, what: str, a: str, b: str) -> frozenset[str]:
        return checked_pair(what, a, b, self._items())

"""A scene as MuJoCo bodies and geoms: primitives as they are, meshes as convex pieces."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.baselines.engine.geoms import add_geom, add_points
from halfphysics.body.mjcf_person import principal
from halfphysics.errors import HalfPhysicsWarning, InputError, MissingDependencyError
from halfphysics.geometry.convex_decomposition import USUAL, decompose
from halfphysics.geometry.shapes import Mesh
from halfphysics.geometry.solid_cutting import MEND
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene import articulated as jointed
from halfphysics.scene.material_pairs import PERSON
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.scene.items import Static
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: MuJoCo's own rolling and torsional friction.
_SPIN, _ROLL = 0.005, 0.0001
_ZERO, _IDENTITY = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])


def add_scene(
    spec: Any,
    scene: Scene,
    hulls: Mapping[str, Sequence[Array]] | None = None,
    people: Sequence[str] = ("",),
) -> dict[str, str]:
    """Add a scene to a `mujoco.MjSpec` that has its people already.

    Every pair has the friction that the scene says. By itself MuJoCo would take the larger of
    two: an item has the friction that it has with a person, the more slippery of two the higher
    priority, and what that leaves wrong becomes an explicit pair. All else of contact is
    MuJoCo's default; it knows no restitution.

    Args:
        spec: The `mujoco.MjSpec`.
        scene: Statics and objects.
        hulls: Name of a static mesh -> points (n, 3) of its convex pieces [m], in its own frame;
            others are cut as objects are (`halfphysics.geometry.convex_decomposition`).
        people: What the people's bodies and geoms are called before the names of joints.

    Returns:
        Name of each geom -> name of its static, object or link in results.

    Warns:
        HalfPhysicsWarning: How static meshes that are not convex touch.

    Raises:
        InputError: A static mesh that cannot be cut, or something soft.
    """
    items: list[Any] = [*scene.statics.values(), *scene.objects.values()]
    for item in items:
        if item.soft is not None:
            raise InputError(
                f"{item.name!r} is soft; this baseline runs in another engine, which has hard "
                "things only. Leave out soft, or simulate with halfphysics.Settings"
            )
    made = _Scenery(spec, scene, people)
    for static in scene.statics.values():
        made.add_static(static, None if hulls is None else hulls.get(static.name))
    for item in scene.objects.values():
        made.add_object(item)
    for whole in scene.articulated.values():
        made.add_articulated(whole)
    made.add_pairs()
    made.add_excludes()
    return made.owner


class _Scenery:
    """The scene as far as it is added."""

    def __init__(self, spec: Any, scene: Scene, people: Sequence[str]) -> None:
        self.owner: dict[str, str] = {}
        self._spec, self._scene, self._people = spec, scene, people
        # Of an item of the scene: its geoms and bodies.
        self._geoms: dict[str, list[str]] = {}
        self._bodies: dict[str, list[str]] = {}
        names = [*scene.statics, *scene.objects, *scene.articulated]
        self._friction = {n: scene.friction_of(PERSON, n) for n in names}
        falling = sorted(set(self._friction.values()), reverse=True)
        # People have priority 0.
        self._priority = {n: 1 + falling.index(mu) for n, mu in self._friction.items()}

    def add_static(self, static: Static, hulls: Sequence[Array] | None) -> None:
        name, shape = static.name, static.shape
        ignored = any(name in pair for pair in self._scene.ignored_pairs)
        body, called = self._spec.worldbody, "world"
        if ignored:  # pairs that do not touch are pairs of bodies
            called = f"static/{name}"
            body = self._spec.worldbody.add_body(name=called)
        self._bodies[name] = [called]
        place = static.position, static.quaternion
        if not isinstance(shape, Mesh):
            self._add(body, f"static/{name}/0", name, shape, *place)
            return
        for i, points in enumerate(_pieces(name, shape) if hulls is None else hulls):
            self._add(body, f"static/{name}/{i}", name, points, *place)

    def add_object(self, item: Any) -> None:
        called = f"object/{item.name}"
        body = self._spec.worldbody.add_body(name=called, pos=item.position, quat=item.quaternion)
        self._bodies[item.name] = [called]
        if isinstance(item, KinematicObject):
            body.mocap = True
        else:
            body.add_freejoint()
            body.mass, body.ipos = item.mass, item.com
            body.inertia, body.iquat = principal(item.inertia)
            body.explicitinertial = True
        for i, piece in enumerate(item.pieces):
            self._add(body, f"{called}/{i}", item.name, piece, _ZERO, _IDENTITY)

    def add_articulated(self, whole: jointed.Articulated) -> None:
        jointed.add_bodies(self._spec, whole)
        called = [f"articulated/{whole.name}/{i}" for i in range(len(whole.links))]
        self._bodies[whole.name] = called
        for body, link, name in zip(called, whole.links, whole.link_names, strict=True):
            for k, geom in enumerate(link.geoms):
                place = geom.position, geom.quaternion
                self._add(
                    self._spec.body(body), f"{body}/geom{k}", name, geom.shape, *place, whole.name
                )
        for a, b in combinations(called, 2):
            self._spec.add_exclude(bodyname1=a, bodyname2=b)

    def _add(
        self,
        body: Any,
        geom: str,
        name: str,
        shape: Any,
        position: Array,
        quaternion: Array,
        of: str | None = None,
    ) -> None:
        of = name if of is None else of
        add = add_points if isinstance(shape, np.ndarray) else add_geom
        material = {
            "friction": [self._friction[of], _SPIN, _ROLL],
            "priority": self._priority[of],
        }
        add(self._spec, body, geom, shape, position, quaternion, **material)
        self.owner[geom] = name
        self._geoms.setdefault(of, []).append(geom)

    def add_pairs(self) -> None:
        """Explicit pairs where priorities do not give the friction that the scene says."""
        scene = self._scene
        for a, b in combinations(self._geoms, 2):
            mu = scene.friction_of(a, b)
            unmoved = a in scene.statics and b in scene.statics
            if mu != min(self._friction[a], self._friction[b]) and not unmoved:
                self._add_pair(a, b, mu)
        told = {end for a, b, _ in scene.friction_pairs for end in (a, b)}
        for part in sorted(end for end in told if end.startswith(f"{PERSON}/")):
            joint = part.removeprefix(f"{PERSON}/")
            self._geoms[part] = [
                prefix + joint for prefix in self._people if self._spec.geom(prefix + joint)
            ]
            for item in self._friction:
                if scene.friction_of(part, item) != self._friction[item]:
                    self._add_pair(part, item, scene.friction_of(part, item))

    def _add_pair(self, a: str, b: str, mu: float) -> None:
        if self._scene.ignores(a, b):
            return
        for first in self._geoms[a]:
            for second in self._geoms.get(b, ()):
                self._spec.add_pair(
                    geomname1=first, geomname2=second, friction=[mu, mu, _SPIN, _ROLL, _ROLL]
                )

    def add_excludes(self) -> None:
        """Pairs of bodies that pass through each other."""
        bodies = dict(self._bodies)
        for joint in JOINT_NAMES:
            bodies[f"{PERSON}/{joint}"] = [prefix + joint for prefix in self._people]
        bodies[PERSON] = [prefix + joint for prefix in self._people for joint in JOINT_NAMES]
        for a, b in self._scene.ignored_pairs:
            for first in bodies[a]:
                for second in bodies[b]:
                    # Pairs of one group with itself come twice.
                    if a != b or first < second:
                        self._spec.add_exclude(bodyname1=first, bodyname2=second)


def _pieces(name: str, mesh: Mesh) -> list[Array]:
    """Points of the convex pieces that stand for a static mesh."""
    if mesh.is_convex:
        return [mesh.hull.vertices]
    try:
        made = decompose(mesh, USUAL)
    except MissingDependencyError:
        raise InputError(
            f"static {name!r}: its mesh is not convex, MuJoCo knows convex solids only, and "
            f"cutting it into pieces needs coacd: {MEND}, or add it in convex pieces"
        ) from None
    except InputError as error:
        raise InputError(
            f"static {name!r}: MuJoCo knows convex solids only, and its mesh is not made of any: "
            f"{error}. Add it as a Plane or as boxes, or use another baseline"
        ) from None
    warnings.warn(
        f"static {name!r}: MuJoCo knows convex solids only: the mesh touches there in convex "
        f"pieces, {len(made.pieces)} of them, which are up to {made.outside_mm:.1f} mm outside of "
        f"it and leave up to {made.inside_mm:.1f} mm of it bare",
        HalfPhysicsWarning,
        stacklevel=9,  # the line that called `simulate`
    )
    return [piece.vertices for piece in made.pieces]

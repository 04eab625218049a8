"""Random soft scenes: layers on planes, boxes, meshes, objects; people and things thrown at them.

A case is a seed and a number; the same case is the same scene, always. Everything starts outside
the visible surfaces: what would start inside is left out.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import AS_IT_IS, Settings
from halfphysics.simulation.simulator import Simulator
from support.fuzz_cases import Person, body_of, motion_of
from support.judges.clear_judge import Judge
from support.judges.coal_scene import Watch
from support.references.mesh_queries import winding_reference
from support.soft.frames import Seen, hard
from support.throws import POSES

KINDS = ("person", "things", "person and things", "things")
#: Stiffness [Pa/m] over six decades, thickness [m], masses [kg], speeds [m/s].
STIFFNESS, THICKNESS, MASSES, FASTEST = (1e3, 1e9), (0.005, 0.3), (0.01, 1000.0), 20.0
#: Frame rates and substeps a frame.
STEPS = (
    *((30.0, n) for n in (1, 2, 4, 8, 16)),
    *((60.0, n) for n in (1, 2, 4, 8)),
    *((120.0, n) for n in (1, 2, 4)),
)
#: A frame lies at most this share of the smallest size below the surface on each side.
MOST_SHARE = 0.45
#: Frames of a case of things alone; seconds that a thrown person stays after its way.
FRAMES = 40
#: Everything starts at least this far apart [m]; it is over twice the clearance.
ROOM = 0.003


@dataclass(frozen=True)
class Case:
    """One run: number `index` of a seed."""

    seed: int
    index: int

    @property
    def kind(self) -> str:
        return KINDS[self.index % len(KINDS)]

    @property
    def id(self) -> str:
        return f"{self.kind.replace(' ', '_')}-{self.seed}-{self.index}"


@dataclass
class Setup:
    """A case ready to run: the simulator, its people's motions, the scene of hard frames."""

    case: Case
    simulator: Simulator
    motions: list[Motion] = field(default_factory=list)
    frames: int = FRAMES
    fps: float = 30.0

    def poses(self, t):
        return [motion[t] for motion in self.motions]


def between(rng, limits):
    """A number between two limits, every decade as likely."""
    return float(10.0 ** rng.uniform(*np.log10(limits)))


def drawn_layer(rng, least_size):
    """A layer for a thing of this smallest size [m]."""
    most = min(THICKNESS[1], MOST_SHARE * least_size)
    stiffness = between(rng, STIFFNESS)
    damping = stiffness * float(rng.choice([0.0, 1e-3, 1e-2, 0.1]))
    law = str(rng.choice(["linear", "foam"]))
    return hp.Soft(
        thickness=between(rng, (THICKNESS[0], max(most, 1.01 * THICKNESS[0]))),
        stiffness=stiffness,
        damping=damping,
        law=law,
    )


def bulge(rng, size):
    """A closed block with a bulging top, faces of some centimetres."""
    import trimesh

    block = trimesh.creation.box(size)
    for _ in range(int(rng.integers(2, 4))):
        block = block.subdivide()
    vertices = block.vertices.copy()
    top = vertices[:, 2] > 0.0
    share = 1.0 - (2.0 * vertices[:, 0] / size[0]) ** 2
    vertices[top, 2] += 0.2 * size[2] * share[top]
    return trimesh.Trimesh(vertices, block.faces, process=False)


def drawn_shape(rng, kinds, sizes):
    """A shape and its smallest size [m]."""
    import trimesh

    kind = str(rng.choice(kinds))
    a, b, c = (between(rng, sizes) for _ in range(3))
    if kind == "plane":
        return Plane(), 1.0
    if kind == "sphere":
        return Sphere(0.5 * a), a
    if kind == "capsule":
        return Capsule(0.5 * a, b), a
    if kind == "cylinder":
        return Cylinder(0.5 * a, b), min(a, b)
    if kind == "bulge":
        return bulge(rng, (a, b, c)), min(a, b, c)
    if kind == "hull":
        points = a / 3.0 * rng.normal(size=(8, 3))
        mesh = trimesh.convex.convex_hull(points)
        return mesh, float(mesh.extents.min()) / 3.0
    return Box((a, b, c)), min(a, b, c)


def statics(rng, scene, around):
    """Up to three statics near a point (3,), most of them soft; a soft floor in two of three."""
    if rng.random() < 0.67:
        layer = drawn_layer(rng, 1.0)
        scene.add_static("floor", Plane(), position=(0, 0, around[2] - 1.0), soft=layer)
    for i in range(int(rng.integers(1, 4))):
        shape, least = drawn_shape(rng, ("box", "box", "bulge", "sphere", "capsule", "cylinder"),
                                   (0.05, 1.2))  # fmt: skip
        soft = rng.random() < 0.8 and MOST_SHARE * least > THICKNESS[0]
        scene.add_static(
            f"static{i}",
            shape,
            position=around + rng.uniform(-0.7, 0.7, size=3),
            quaternion=rng.normal(size=4),
            friction=float(rng.choice([0.0, 0.5, 1.0])),
            soft=drawn_layer(rng, least) if soft else None,
        )


def things(rng, scene, around):
    """Up to four free things, some soft, thrown somewhere."""
    for i in range(int(rng.integers(1, 5))):
        shape, least = drawn_shape(
            rng, ("box", "sphere", "capsule", "cylinder", "hull"), (0.03, 0.4)
        )
        soft = rng.random() < 0.4 and MOST_SHARE * least > THICKNESS[0]
        place = around + rng.uniform(-0.8, 0.8, size=3) + [0.0, 0.0, 0.5]
        # Most are thrown at what stands there.
        direction = rng.normal(size=3) - [0.0, 0.0, 0.7]
        if rng.random() < 0.7:
            direction = around + 0.3 * rng.normal(size=3) - place
        scene.add_object(
            f"thing{i}",
            shape,
            mass=between(rng, MASSES),
            friction=float(rng.choice([0.0, 0.5, 1.0])),
            position=place,
            quaternion=rng.normal(size=4),
            velocity=rng.uniform(0.0, FASTEST) * direction / np.linalg.norm(direction),
            angular_velocity=rng.normal(size=3) * 5.0,
            soft=drawn_layer(rng, least) if soft else None,
        )


def thrown(rng, fps, substeps):
    """A person thrown in a random direction; at the end of its way it stays."""
    person = Person(
        pose=str(rng.choice(POSES)),
        speed=between(rng, (0.5, FASTEST)),
        wild=float(rng.uniform(0.0, 1.0)),
        spin=float(rng.uniform(-6.0, 6.0)),
        seed=int(rng.integers(2**16)),
    )
    motion = motion_of(person, int(fps), substeps)
    way = np.array([1.0, 0.0, 0.0]) if rng.random() < 0.5 else rng.normal(size=3) - [0, 0, 1.0]
    path = np.outer(motion.translation[:, 0], way / np.linalg.norm(way))
    return motion.with_frames(path, motion.rotations), way / np.linalg.norm(way)


def settings_of(rng, substeps, people):
    changes = {}
    if people:
        drive = rng.choice([0.02, 0.02, None])
        changes = {
            "stiffness": float(rng.choice([0.0, 1.0, 10.0])),
            "drive_time": drive,
            **({"soft_skin": True} if rng.random() < 0.3 else {}),
            **(AS_IT_IS if drive is None or rng.random() < 0.5 else {}),
        }
    return Settings(substeps=substeps, record="substeps", **changes)


def set_up(case) -> Setup:
    """The run of a case; nothing starts inside a surface."""
    rng = np.random.default_rng((case.seed, case.index))
    fps, substeps = STEPS[int(rng.integers(len(STEPS)))]
    motions, bodies, scene = [], [], Scene()
    around = np.zeros(3)
    if "person" in case.kind:
        motion, way = thrown(rng, fps, substeps)
        motions, bodies, around = [motion], [body_of(())], 1.1 * way
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        statics(rng, scene, around)
        if "things" in case.kind:
            things(rng, scene, around)
        settings = settings_of(rng, substeps, bool(motions))
        simulator = Simulator(scene, body=bodies, settings=settings, fps=fps)
        scene = clear(simulator, scene, motions)
        simulator = Simulator(scene, body=bodies, settings=settings, fps=fps)
    frames = len(motions[0]) - 1 if motions else FRAMES
    return Setup(case, simulator, motions, frames, fps)


def clear(simulator, scene, motions):
    """The scene without what overlaps the people, or something else that moves, at the start."""
    seen = Seen(simulator, hard(scene, frames=False))
    start = simulator.world.start([m[0] for m in motions])[0]
    out, judge = set(), Judge(seen) if motions else None
    for name, static in seen.world.scene.statics.items():
        if judge is not None and judge.gap_to(static, start) < ROOM:
            out.add(name)
    for gap, one, other in Watch(seen).gaps(start, statics="things"):
        if gap < ROOM and one not in out and other not in out:
            out.add(one if one in scene.objects else other)
    # Coal's meshes are hollow: what lies inside one whole is clear of its surface.
    for static in scene.statics.values():
        if not isinstance(static.shape, Plane):
            out.update(n for n, o in scene.objects.items() if holds(static, o.position))
    return without(scene, out)


def holds(item, point):
    """Is a point (3,) inside a static?"""
    vertices, faces = item.shape.triangles()
    local = rot.to_matrix(item.quaternion).T @ (np.asarray(point) - item.position)
    return bool(winding_reference(local[None], vertices, faces)[0] > 0.5)


def without(scene, names):
    """The scene without these items."""
    kept = Scene(gravity=scene.gravity)
    for name, s in scene.statics.items():
        if name not in names:
            place = {"position": s.position, "quaternion": s.quaternion}
            kept.add_static(name, s.shape, friction=s.friction, soft=s.soft, **place)
    for name, o in scene.objects.items():
        if name not in names:
            kept.add_object(
                name,
                o.shape,
                mass=o.mass,
                friction=o.friction,
                position=o.position,
                quaternion=o.quaternion,
                velocity=o.velocity,
                angular_velocity=o.angular_velocity,
                soft=o.soft,
            )
    return kept

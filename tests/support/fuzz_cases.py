"""Random people, motions, obstacles, objects and settings: drawing the cases and building them.

A `Case` is plain numbers; its repr is the code that makes it again. Every case starts clear: when
it is built, obstacles that would overlap a person are moved ahead until they do not, and objects
that would overlap any item are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from hypothesis import strategies as st

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.fuzzing import SECONDS
from support.judges.clear_judge import Judge
from support.judges.coal_scene import Watch
from support.people import FACING_X
from support.throws import POSES, stair

#: Static obstacles. Sheets, plates, soup, stairs and slabs are triangles.
STATICS = (
    "plane",
    "box",
    "sphere",
    "capsule",
    "cylinder",
    "plate",
    "sheet",
    "slab",
    "soup",
    "stair",
)
#: Free objects.
THINGS = ("box", "sphere", "capsule", "cylinder", "hull")
#: Objects start at least this far from every item [m]: twice the clearance.
ROOM = 0.002
#: An obstacle that overlaps a person is moved ahead in steps of this, at most this often [m].
AHEAD, TRIES = 0.1, 25
#: Most substeps of a case, at any speed and frame rate.
MOST_SUBSTEPS = 320


@dataclass(frozen=True)
class Form:
    """A shape at a place. `size` [m] as far as the kind needs it, `seed` for ragged shapes."""

    kind: str
    size: tuple[float, float, float]
    at: tuple[float, float, float]
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    seed: int = 0
    friction: float = 1.0
    restitution: float = 0.0


@dataclass(frozen=True)
class Thing:
    """A moving form: mass [kg], velocity [m/s] and spin [rad/s]."""

    form: Form
    mass: float
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Person:
    """A person who goes along a direction at `speed` [m/s]; joints move `wild` times as usual.

    `seed` chooses how the joints move; `spin` [rad/s] turns the whole about the vertical.
    """

    betas: tuple[float, ...] = ()
    pose: str = "tpose"
    speed: float = 1.0
    wild: float = 0.0
    spin: float = 0.0
    seed: int = 0


@dataclass(frozen=True)
class Case:
    """One run. Frame rate [1/s], substeps a frame, the relevant settings, people and items.

    `contact`: the surface that is kept clear, and judged.
    """

    people: tuple[Person, ...] = ()
    statics: tuple[Form, ...] = ()
    things: tuple[Thing, ...] = ()
    fps: int = 30
    substeps: int = 8
    stiffness: float = 1.0
    drive_time: float | None = 0.02
    root: str = "stay"
    clearance: float = 0.001
    gravity: float = 9.81
    contact: str = "skin"


# -- drawing -----------------------------------------------------------------------------------


def _number(low, high):
    return st.floats(low, high, allow_subnormal=False)


def _vector(low, high):
    return st.tuples(*(_number(a, b) for a, b in zip(low, high, strict=True)))


def _forms(kinds, low, high, sizes, restitutions=(0.0,)):
    return st.builds(
        Form,
        kind=st.sampled_from(kinds),
        size=_vector(*np.transpose([sizes] * 3)),
        at=_vector(low, high),
        turn=_vector([-np.pi] * 3, [np.pi] * 3),
        seed=st.integers(0, 2**16),
        friction=st.sampled_from([0.0, 0.3, 1.0]),
        restitution=st.sampled_from(restitutions),
    )


def things(low, high, most, fast=10.0, restitutions=(0.0,)):
    """Up to `most` objects between two corners (3,) [m]."""
    one = st.builds(
        Thing,
        form=_forms(THINGS, low, high, (0.03, 0.3), restitutions),
        mass=st.sampled_from([0.01, 0.3, 3.0, 100.0]),
        velocity=_vector([-fast] * 3, [fast] * 3),
        spin=_vector([-10.0] * 3, [10.0] * 3),
    )
    return st.lists(one, max_size=most).map(tuple)


#: A body takes longer to make than a run: people have these shapes, other shapes per campaign.
SHAPES = (
    (),
    *(
        tuple(map(float, row))
        for row in np.random.default_rng(None if SECONDS else 0).uniform(
            -2.5, 2.5, size=(11 if SECONDS else 3, 10)
        )
    ),
)

PEOPLE = st.builds(
    Person,
    betas=st.sampled_from(SHAPES),
    pose=st.sampled_from(POSES),
    speed=st.one_of(_number(0.3, 5.0), _number(5.0, 20.0)),
    wild=_number(0.0, 1.0),
    spin=_number(-6.0, 6.0),
    seed=st.integers(0, 2**16),
)

#: Frame rate and substeps a frame: h from 1/30 to 1/480 s.
RATES = st.sampled_from(
    [(30, 1), (30, 4), (30, 8), (30, 16), (60, 1), (60, 4), (60, 8), (120, 1), (120, 4)]
)


@st.composite
def cases(draw, people=(1, 2), statics=(1, 3), most_things=3):
    """Cases with so many people and statics (least, most) and up to so many objects."""
    fps, substeps = draw(RATES)
    ahead = _forms(STATICS, (0.3, -0.8, -1.2), (1.8, 0.8, 0.8), (0.01, 1.0))
    return Case(
        people=draw(st.lists(PEOPLE, min_size=people[0], max_size=people[1]).map(tuple)),
        statics=draw(st.lists(ahead, min_size=statics[0], max_size=statics[1]).map(tuple)),
        things=draw(things((-0.5, -1.0, -1.0), (2.0, 1.0, 1.0), most_things)),
        fps=fps,
        substeps=substeps,
        stiffness=draw(st.sampled_from([1.0, 0.0, 0.1, 10.0])),
        drive_time=draw(st.sampled_from([0.02, None, 0.1])),
        root=draw(st.sampled_from(["stay", "recover"])),
        clearance=draw(st.sampled_from([0.001, 1e-4, 0.005])),
        gravity=draw(st.sampled_from([9.81, 0.0])),
        contact=draw(st.sampled_from(["skin", "skin", "skin", "parts"])),
    )


# -- building ----------------------------------------------------------------------------------


@lru_cache(maxsize=12)
def body_of(betas):
    """The default body of that shape."""
    who = Body.default(betas=np.array([*betas, *[0.0] * (10 - len(betas))]))
    who.variant  # noqa: B018  computed once
    return who


def shape_of(form):
    """A shape or a mesh of the form's kind."""
    import trimesh

    a, b, c = form.size
    rng = np.random.default_rng(form.seed)
    if form.kind == "plane":
        return Plane()
    if form.kind == "box":
        return Box(form.size)
    if form.kind == "sphere":
        return Sphere(0.5 * a)
    if form.kind == "capsule":
        return Capsule(0.5 * a, b)
    if form.kind == "cylinder":
        return Cylinder(0.5 * a, b)
    if form.kind == "hull":
        return trimesh.convex.convex_hull(a / 3.0 * rng.normal(size=(4 + form.seed % 12, 3)))
    if form.kind == "plate":
        return trimesh.creation.box((0.01, 4.0 * b, 4.0 * c))
    if form.kind == "slab":
        return trimesh.creation.box(form.size)
    if form.kind == "stair":
        return stair()
    if form.kind == "sheet":
        corners = np.array([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]]) * [0.0, 2 * b, 2 * c]
        sheet = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
        for _ in range(form.seed % 4):
            sheet = sheet.subdivide()
        return sheet
    n = 5 + form.seed % 40
    corners = rng.uniform(-0.5, 0.5, size=(n, 1, 3)) + 0.1 * rng.normal(size=(n, 3, 3))
    return trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * n).reshape(n, 3), process=False)


def motion_of(person, fps, substeps, index=0):
    """A motion from the origin along +x; of a second person from x = 2.4 m back towards the first.

    It goes 1.6 m at its speed and then stays for a tenth of a second; at least four frames.
    """
    seconds = 1.6 / person.speed + 0.1
    frames = int(np.clip(np.ceil(seconds * fps), 4, MOST_SUBSTEPS // substeps)) + 1
    t = np.arange(frames) / fps
    rng = np.random.default_rng(person.seed)
    phase = rng.uniform(0.0, 2 * np.pi, size=(55, 1)) + 2 * np.pi * np.outer(
        rng.uniform(0.5, 2.5, size=55), t
    )
    swing = person.wild * rng.normal(size=(55, 3)) * np.where(np.arange(55) < 22, 1.0, 0.2)[:, None]
    rotations = swing[None] * np.sin(phase).T[:, :, None]
    if person.pose == "curled":
        from support.throws import curled

        rotations = rotations + curled()
    axis = np.array([0.0, 0.0, 1.0])
    if person.pose == "tumbling":
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
    facing = rot.multiply(rot.exp([0.0, 0.0, np.pi * index]), rot.exp(FACING_X))
    turns = rot.multiply(rot.exp(np.outer(person.spin * t, axis)), facing)
    rotations[:, 0] = rot.log(turns)
    path = np.outer(np.minimum(person.speed * t, 1.6), [1.0 - 2.0 * index, 0.0, 0.0])
    return Motion(path + np.array([2.4 * index, 0.0, 0.0]), rotations, fps)


@dataclass
class Run:
    """A case ready to run: its simulator and motions of one length, all clear at the start."""

    case: Case
    simulator: Simulator
    motions: list[Motion]

    def poses(self, t):
        return [motion[t] for motion in self.motions]

    @property
    def length(self):
        return len(self.motions[0]) if self.motions else 45


def settings_of(case):
    return Settings(
        contact=case.contact,
        substeps=case.substeps,
        stiffness=case.stiffness,
        drive_time=case.drive_time,
        root=case.root,
        clearance=case.clearance,
        record="substeps",
    )


def build(case, floor=False):
    """The run of a case, every start clear by `ROOM`."""
    people = list(case.people)
    while True:
        motions = [motion_of(p, case.fps, case.substeps, i) for i, p in enumerate(people)]
        length = min((len(m) for m in motions), default=0)
        motions = [m[:length] for m in motions]
        bodies = [body_of(p.betas) for p in people]
        scene = _scene(case, floor, *_clear(case, bodies, motions, floor))
        simulator = Simulator(scene, body=bodies, settings=settings_of(case), fps=case.fps)
        run = Run(case, simulator, motions)
        if len(people) < 2 or Watch(simulator).gap(start_of(run), statics="none")[0] > ROOM:
            return run
        people.pop()  # their starts overlap


def start_of(run):
    """Coordinates (nq,) at the start."""
    return run.simulator.world.start(run.poses(0))[0]


def _scene(case, floor, statics, movers):
    scene = Scene(gravity=case.gravity)
    if floor:
        scene.add_static("floor", Plane())
        scene.add_static("wall", Box((0.01, 99.0, 99.0)), position=(1.2, 0.0, 0.0))
    for i, shift in statics.items():
        form = case.statics[i]
        scene.add_static(f"static{i}", shape_of(form), **_place(form, shift))
    for i, thing in enumerate(case.things):
        if i in movers:
            scene.add_object(
                f"thing{i}",
                shape_of(thing.form),
                mass=thing.mass,
                velocity=thing.velocity,
                angular_velocity=thing.spin,
                **_place(thing.form),
            )
    return scene


def _place(form, shift=0.0):
    turn = form.turn
    if form.kind == "plane":  # a floor or a wall more or less, not a ceiling
        turn = (0.3 * turn[0], 0.3 * turn[1] - 0.5, 0.0)
    return {
        "position": np.add(form.at, (shift, 0.0, 0.0)),
        "quaternion": rot.exp(np.array(turn)),
        "friction": form.friction,
        "restitution": form.restitution,
    }


def _clear(case, bodies, motions, floor):
    """The distance each obstacle is moved ahead, and which objects are clear at the start."""
    statics, movers = {}, set()
    people = Simulator(Scene(), body=bodies, settings=settings_of(case), fps=case.fps)
    judge, start = Judge(people), people.world.start([m[0] for m in motions])[0]
    for i in range(len(case.statics)):
        for k in range(TRIES):
            scene = _scene(case, False, {i: k * AHEAD}, set())
            if judge.gap_to(scene.statics[f"static{i}"], start) > ROOM:
                statics[i] = k * AHEAD
                break
    if not case.things:
        return statics, movers
    everything = range(len(case.things))
    scene = _scene(case, floor, statics, everything)
    simulator = Simulator(scene, body=bodies, settings=settings_of(case), fps=case.fps)
    start = simulator.world.start([m[0] for m in motions])[0]
    tight = [{a, b} for d, a, b in Watch(simulator).gaps(start, statics="things") if d <= ROOM]
    out = {f"thing{i}" for i in everything}
    for i in everything:  # in order, each clear of those already placed
        if not any(f"thing{i}" in pair and not (pair - {f"thing{i}"}) & out for pair in tight):
            movers.add(i)
            out.discard(f"thing{i}")
    return statics, movers

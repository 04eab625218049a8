"""Random people, walls and things: nothing passes through, checked by coal at every substep.

`HALFPHYSICS_FUZZ=N` runs N cases of each kind instead of a few.
"""

from __future__ import annotations

import os

import numpy as np
import pytest
from coal_scene import Watch
from people import FACING_X, t_pose, violent

from halfphysics import rotations as rot
from halfphysics.body import Body
from halfphysics.motion import Motion
from halfphysics.scene import Scene
from halfphysics.settings import Settings
from halfphysics.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.simulator import Simulator

#: Clear starts stay clear; coal's own distances are good to this [m].
COAL = 1e-6
#: Momentum is a sum of floating-point numbers, relative to its largest.
ROUNDING = 1e-10
STATICS = ("plane", "box", "sphere", "capsule", "cylinder", "sheet", "slab", "soup")


def cases(few):
    return range(int(os.environ.get("HALFPHYSICS_FUZZ", few)))


@pytest.fixture(scope="module")
def body():
    return Body.default()


def settings_of(rng, **changes):
    drive = rng.choice([None, 0.02])
    return Settings(
        stiffness=float(rng.choice([0.0, 1.0, 10.0])),
        drive_time=None if drive is None else float(drive),
        **changes,
    )


def flailing(rng, speed, way, fps):
    """Walks `way` [m] along +x at `speed` [m/s], turning and moving all joints."""
    t = np.arange(max(3, round(way / speed * fps))) / fps
    wild = rng.choice([0.0, 0.3, 1.0])
    phase = rng.uniform(0.0, 2 * np.pi, size=(55, 1)) + 2 * np.pi * np.outer(
        rng.uniform(0.5, 2.0, size=55), t
    )
    rotations = wild * rng.normal(size=(1, 55, 3)) * np.sin(phase).T[:, :, None]
    rotations[:, 22:] *= 0.2
    spin = rot.exp(np.outer(3.0 * wild * rng.normal() * t, [0.0, 0.0, 1.0]))
    rotations[:, 0] = rot.log(rot.multiply(spin, rot.exp(FACING_X)))
    return Motion(np.outer(speed * t, [1.0, 0.0, 0.0]), rotations, fps)


def obstacle(kind, rng):
    """One static about 1.3 m ahead of the origin."""
    import trimesh

    scene = Scene()
    at = {"position": (1.3, 0.2 * rng.normal(), rng.uniform(-0.5, 0.5))}
    turned = {"quaternion": rot.normalize(rng.normal(size=4)), **at}
    if kind == "plane":
        normal = np.array([-1.0, 0.0, 0.0]) + 0.3 * rng.normal(size=3)
        scene.add_static("it", Plane(tuple(normal / np.linalg.norm(normal))), **at)
    elif kind == "box":
        scene.add_static("it", Box(tuple(rng.choice([0.01, 0.3, 1.0], size=3))), **turned)
    elif kind == "sphere":
        scene.add_static("it", Sphere(float(rng.choice([0.02, 0.2, 0.5]))), **at)
    elif kind == "capsule":
        scene.add_static("it", Capsule(float(rng.choice([0.005, 0.1])), 1.5), **turned)
    elif kind == "cylinder":
        scene.add_static("it", Cylinder(float(rng.choice([0.005, 0.1, 0.3])), 1.0), **turned)
    elif kind == "sheet":
        corners = [[0, -2, -2], [0, 2, -2], [0, 2, 2], [0, -2, 2]]
        sheet = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
        for _ in range(rng.integers(0, 4)):
            sheet = sheet.subdivide()
        tilt = rot.exp(0.5 * rng.normal(size=3))
        scene.add_static("it", sheet, position=(1.5, 0.0, 0.0), quaternion=tilt)
    elif kind == "slab":
        turn = rot.exp([0.0, 0.0, rng.uniform(0.0, 6.0)])
        slab = trimesh.creation.box(rng.choice([0.05, 0.3, 1.0], size=3))
        scene.add_static("it", slab, quaternion=turn, **at)
    else:
        n = int(rng.integers(5, 40))
        corners = rng.uniform([1.0, -0.8, -1.0], [2.0, 0.8, 0.8], size=(n, 1, 3))
        corners = (corners + 0.1 * rng.normal(size=(n, 3, 3))).reshape(-1, 3)
        soup = trimesh.Trimesh(corners, np.arange(3 * n).reshape(n, 3), process=False)
        scene.add_static("it", soup)
    return scene


def run(simulator, motion):
    frames = [simulator.reset(motion[0])]
    frames += [simulator.step(motion[t]) for t in range(1, len(motion))]
    for frame in frames:
        assert np.isfinite(frame.substeps).all()
        along = np.einsum("ij,ij->i", frame.contacts.impulse, frame.contacts.normal)
        assert (along >= 0.0).all()
    return frames


def check_clear(simulator, motion, frames):
    watch = Watch(simulator)
    start, _ = watch.gap(simulator.world.start([motion[0]])[0])
    if start <= 0.0:
        return False
    gap, pair, frame, substep = watch.smallest_gap(frames, every=3)
    assert gap >= -COAL, f"{pair} overlap by {-gap:.6f} m in substep {substep} of frame {frame}"
    return True


@pytest.mark.parametrize("kind", STATICS)
def test_a_person_goes_through_nothing(body, kind):
    checked = 0
    for case in cases(2):
        rng = np.random.default_rng([STATICS.index(kind), case])
        fps = float(rng.choice([30, 60]))
        motion = flailing(rng, float(rng.choice([1.5, 3.0, 5.0])), 1.8, fps)
        settings = settings_of(rng, substeps=8, record="substeps")
        scene = obstacle(kind, rng)
        simulator = Simulator(scene, body=body, settings=settings, fps=fps)
        checked += check_clear(simulator, motion, run(simulator, motion))
    assert checked > 0


@pytest.mark.parametrize(
    "name",
    ["kaykit_prototype/Primitive_Floor", "kaykit_prototype/Wall_Doorway", "kaykit_furniture/couch"],
)
def test_a_person_goes_through_no_furniture(shared_data, body, name):
    checked = 0
    for case in cases(2):
        rng = np.random.default_rng([17, case])
        motion = flailing(rng, 3.0, 2.2, 30.0)
        scene = Scene()
        turn = rot.exp([0.0, 0.0, rng.uniform(0.0, 6.0)])
        at = (1.9, 0.2 * rng.normal(), rng.uniform(-1.2, -0.3))
        path = shared_data / "meshes" / f"{name}.obj"
        scene.add_static("it", path, scale=0.7, up="y", position=at, quaternion=turn)
        settings = settings_of(rng, substeps=8, record="substeps")
        simulator = Simulator(scene, body=body, settings=settings, fps=30)
        checked += check_clear(simulator, motion, run(simulator, motion))
    assert checked > 0


def thing(rng):
    import trimesh

    size = rng.uniform(0.03, 0.2)
    return (
        Box(tuple(rng.uniform(0.03, 0.3, size=3))),
        Sphere(size),
        Capsule(size / 2, 2 * size),
        Cylinder(size, float(rng.uniform(0.03, 0.3))),
        trimesh.convex.convex_hull(0.1 * rng.normal(size=(12, 3))),
    )[rng.integers(0, 5)]


def thrown(rng, restitution):
    scene = Scene(gravity=float(rng.choice([0.0, 9.81])))
    scene.add_static("floor", Plane(), restitution=restitution)
    scene.add_static("wall", Box((0.01, 99.0, 99.0)), position=(1.2, 0.0, 0.0))
    friction = float(rng.choice([0.0, 0.3, 0.8]))
    for i in range(rng.integers(1, 6)):
        scene.add_object(
            f"thing{i}",
            thing(rng),
            mass=float(10 ** rng.uniform(-2.0, 2.0)),
            friction=friction,
            restitution=restitution,
            position=rng.uniform([-1.0, -0.4, 0.4], [-0.3, 0.4, 2.2]) - [0.8 * i, 0.0, 0.0],
            quaternion=rot.normalize(rng.normal(size=4)),
            velocity=(rng.uniform(0.0, 10.0), rng.normal(), rng.normal()),
            angular_velocity=rng.choice([0.0, 5.0]) * rng.normal(size=3),
        )
    return scene


@pytest.mark.parametrize("person", [False, True])
def test_things_go_through_nothing_and_keep_the_books(body, person):
    """Every change of a thing's momentum is in the contacts, or gravity's."""
    checked = 0
    for case in cases(6):
        rng = np.random.default_rng([101 + person, case])
        scene = thrown(rng, float(rng.choice([0.0, 0.5])))
        standing = t_pose(np.tile([0.3, 0.0, 0.0], (45, 1))).grounded(body, 0.002)
        settings = settings_of(rng, record="substeps")
        simulator = Simulator(scene, body=[body] if person else [], settings=settings, fps=30)
        stepper, world = simulator.world.stepper, simulator.world
        poses = [[standing[t]] if person else [] for t in range(45)]
        frames = [simulator.reset(poses[0])]
        for pose in poses[1:]:
            before = stepper.qvel()
            frames.append(simulator.step(pose))
            c, after = frames[-1].contacts, stepper.qvel()
            assert (np.einsum("ij,ij->i", c.impulse, c.normal) >= 0.0).all()
            for place in world.things:
                mass, index = scene.objects[place.name].mass, simulator.names.index(place.name)
                rows = slice(place.dof, place.dof + 3)
                gained = mass * (after[rows] - before[rows] - scene.gravity / 30)
                pushed = c.impulse[c.subject == index].sum(axis=0)
                pushed = pushed - c.impulse[c.other == index].sum(axis=0)
                size = mass * np.abs(before[rows]).max() + np.abs(c.impulse).sum() + mass
                assert np.abs(gained - pushed).max() <= ROUNDING * size
        watch = Watch(simulator)
        start, _ = watch.gap(world.start(poses[0])[0])
        if start > 0.0:
            checked += 1
            gap, pair, *_ = watch.smallest_gap(frames, every=2)
            assert gap >= -COAL, pair
        for place in world.things:
            x = np.concatenate([f.substeps[:, place.qpos : place.qpos + 3] for f in frames[1:]])
            assert x[:, 0].max() < 1.2  # this side of the wall
            assert x[:, 2].min() > 0.0  # and of the floor
    assert checked > 0


def test_free_motion_is_exact_whatever_it_does(body):
    """Any turns, half turns included, any size of rotation vectors, a kilometre away."""
    for case in cases(40):
        rng = np.random.default_rng([7, case])
        fps = float(rng.choice([24.0, 29.97, 30.0, 60.0, 100.0, 120.0]))
        if case % 4 == 0:
            motion = violent(10, fps=30.0, seed=case)
        else:
            axes = rng.normal(size=(55, 3))
            axes /= np.linalg.norm(axes, axis=1, keepdims=True)
            turn = rot.exp((np.pi + rng.choice([0.0, 1e-15, -1e-12, 1e-7])) * axes)
            quats = [rot.exp(rng.normal(size=(55, 3)))]
            for _ in range(9):
                quats.append(rot.multiply(quats[-1], turn))
            vectors = rot.log(np.array(quats))
            length = np.linalg.norm(vectors, axis=2, keepdims=True)
            vectors *= 1.0 + 2 * np.pi * rng.integers(-3, 4, size=length.shape) / length
            path = 0.1 * rng.normal(size=(10, 3)) + rng.choice([0.0, 1000.0]) * rng.normal(size=3)
            motion = Motion(path, vectors, fps)
        settings = settings_of(rng, substeps=int(rng.choice([1, 4, 8])))
        simulator = Simulator(body=body, settings=settings, fps=motion.fps)
        simulator.reset(motion[0])
        for t in range(1, len(motion)):
            pose = simulator.step(motion[t]).pose
            error = np.abs(body.joints(pose) - body.joints(motion[t])).max()
            assert error <= 1e-9  # [m]; the goal in free motion is 1e-6 mm

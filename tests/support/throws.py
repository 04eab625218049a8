"""People thrown at obstacles: motions and obstacles for the tests against tunnelling."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.judges.clear_judge import Judge
from support.people import FACING_X

POSES = ("tpose", "curled", "tumbling", "flailing")
OBSTACLES = (
    "plate",
    "sheet",
    "pole",
    "mesh_pole",
    "corner",
    "mesh_corner",
    "stair",
    "rods",
)
#: The first pose is this far from the obstacle [m]; then the root goes this way [m] and stays.
ROOM, WAY, STAY = 0.1, 1.4, 0.1


def curled():
    """Knees to the chest, arms around them, head down."""
    turns = {
        "left_hip": (-1.9, 0.0, 0.0),
        "left_knee": (2.1, 0.0, 0.0),
        "spine1": (0.4, 0.0, 0.0),
        "spine2": (0.4, 0.0, 0.0),
        "spine3": (0.3, 0.0, 0.0),
        "neck": (0.5, 0.0, 0.0),
        "left_shoulder": (0.0, -0.9, -0.9),
        "left_elbow": (0.0, -1.6, 0.0),
    }
    rotations = np.zeros((55, 3))
    for name, turn in turns.items():
        rotations[JOINT_NAMES.index(name)] = turn
        if name.startswith("left"):  # mirrored
            other = JOINT_NAMES.index(name.replace("left", "right"))
            rotations[other] = np.array(turn) * (1.0, -1.0, -1.0)
    return rotations


def thrown(pose, speed, fps, rng):
    """A motion whose root goes `WAY` along +x at `speed` [m/s] from the origin, then stays."""
    t = np.arange(int(np.ceil((WAY / speed + STAY) * fps)) + 2) / fps
    rotations = np.zeros((len(t), 55, 3))
    if pose == "curled" or (pose == "tumbling" and rng.random() < 0.5):
        rotations[:] = curled()
    if pose == "flailing":
        phase = rng.uniform(0.0, 2 * np.pi, size=(55, 1)) + 2 * np.pi * np.outer(
            rng.uniform(0.5, 2.5, size=55), t
        )
        swing = rng.normal(size=(55, 3)) * np.where(np.arange(55) < 22, 0.6, 0.2)[:, None]
        rotations = swing[None] * np.sin(phase).T[:, :, None]
    facing = rot.multiply(
        rot.exp([0.0, 0.0, rng.choice([0.0, np.pi / 2, rng.uniform(-np.pi, np.pi)])]),
        rot.exp(FACING_X),
    )
    spin = np.zeros(3)
    if pose == "tumbling":
        axis = rng.normal(size=3)
        spin = rng.uniform(3.0, 12.0) * axis / np.linalg.norm(axis)
    elif pose == "flailing":
        spin = np.array([0.0, 0.0, 2.0 * rng.normal()])
    rotations[:, 0] = rot.log(rot.multiply(rot.exp(t[:, None] * spin), facing))
    path = np.outer(np.minimum(speed * t, WAY), [1.0, 0.0, 0.0])
    return Motion(path, rotations, fps)


def _mesh(vertices, faces):
    import trimesh

    return trimesh.Trimesh(vertices, faces, process=False)


def stair(steps=8, rise=0.17, tread=0.28, width=2.4):
    """A closed stair that rises along +x, the first edge at the origin."""
    profile = [(0.0, 0.0)]
    for k in range(steps):
        profile += [(k * tread, (k + 1) * rise), ((k + 1) * tread, (k + 1) * rise)]
    n = len(profile)
    x, z = np.array(profile).T
    y = 0.5 * width
    vertices = np.concatenate(
        [np.stack([x, np.full(n, side), z], axis=1) for side in (-y, y)]
        + [[[steps * tread, -y, 0.0], [steps * tread, y, 0.0]]]
    )
    faces = []
    for k in range(n - 1):
        faces += [[k, k + n, k + 1], [k + 1, k + n, k + n + 1]]
    for k in range(1, n - 2, 2):  # the sides: under every tread
        a, b = 2 * n, 2 * n + 1
        faces += [[k, k + 1, a], [k + n, b, k + n + 1]]
    return _mesh(vertices, faces)


def _rods(width=2.4, apart=0.05, thick=0.001):
    """A grid of rods in the y-z plane about the origin, eight-sided, one layer behind the other."""
    import trimesh

    places = np.arange(-0.5 * width, 0.5 * width + 1e-9, apart)
    upright = trimesh.creation.cylinder(0.5 * thick, height=width, sections=8)
    rods = []
    for place in places:
        rods.append(upright.copy().apply_translation([0.0, place, 0.0]))
        lying = upright.copy().apply_transform(
            trimesh.transformations.rotation_matrix(np.pi / 2, [1.0, 0.0, 0.0])
        )
        rods.append(lying.apply_translation([thick, 0.0, place]))
    return trimesh.util.concatenate(rods)


def obstacle(kind, aim, ground, rng):
    """A scene with one static "it" at x = 0, where `aim` (y, z) of a body comes along.

    ground: height of the body's lowest point [m].
    """
    import trimesh

    scene = Scene()
    lean = rot.exp(0.3 * rng.normal(size=3))
    where = np.array([0.0, *aim])
    at = {"position": where}
    if kind == "plate":
        scene.add_static("it", Box((0.01, 4.0, 4.0)), quaternion=lean, **at)
    elif kind == "sheet":
        corners = [[0, -2, -2], [0, 2, -2], [0, 2, 2], [0, -2, 2]]
        sheet = _mesh(corners, [[0, 1, 2], [0, 2, 3]])
        for _ in range(rng.integers(0, 4)):
            sheet = sheet.subdivide()
        scene.add_static("it", sheet, quaternion=lean, **at)
    elif kind in ("pole", "mesh_pole"):
        # Upright, lying or leaning.
        turn = rot.exp(rng.choice([0.0, 1.0]) * np.array([rng.choice([0.3, np.pi / 2]), 0.0, 0.2]))
        if kind == "pole":
            shape = Cylinder(0.01, 4.0)
        else:
            shape = trimesh.creation.cylinder(0.01, height=4.0, sections=16)
        scene.add_static("it", shape, position=where, quaternion=turn)
    elif kind in ("corner", "mesh_corner"):
        size = (1.0, 1.0, 0.04)
        shape = Box(size) if kind == "corner" else trimesh.creation.box(size)
        turn = rot.exp([0.0, 0.0, np.pi / 4])
        where[0] = np.sqrt(0.5)
        scene.add_static("it", shape, position=where, quaternion=turn)
    elif kind == "stair":
        where[2] = ground - 0.15 * rng.random()
        scene.add_static("it", stair(), position=where)
    elif kind == "rods":
        scene.add_static("it", _rods(), quaternion=lean, **at)
    else:
        raise ValueError(kind)
    return scene


def throw(pose, kind, speed, fps, body, rng):
    """Motion and scene: the body's first pose is `ROOM` before the obstacle.

    The obstacle aims at one point of the skin, so that no throw in a fixed pose misses.
    The hulls of the skin and the rigid parts are clear of it at the start, both.
    """
    motion = thrown(pose, speed, fps, rng)
    first = body.vertices(motion, frames=[0])[0]
    aim = first[rng.integers(0, len(first)), 1:]
    scene = obstacle(kind, aim, first[:, 2].min(), rng)
    judge = Judge(Simulator(Scene(), body=body, fps=fps), contact="both")
    shift = np.array([-ROOM - first[:, 0].max(), 0.0, 0.0])
    while True:  # back, until leaning obstacles and protruding parts are clear
        start = motion[:2].with_frames(motion[:2].translation + shift, motion[:2].rotations)
        pose = judge.world.start([start[0]])[0]
        if all(judge.surely_off(static, pose) for static in scene.statics.values()):
            return motion.with_frames(motion.translation + shift, motion.rotations), scene
        shift[0] -= 0.05

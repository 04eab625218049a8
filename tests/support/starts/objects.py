"""Objects that start overlapping a static, each other or a person, by 1 to 3 cm."""

from __future__ import annotations

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from support.as_it_is import as_it_is
from support.judges.coal_scene import coal_shape
from support.starts.cases import SECONDS, Case, Start, body, hulls
from support.starts.meshes import box_mesh, finely
from support.starts.poses import POSES, wave
from support.starts.solids import REQUEST, box, ground

KINDS = ("thing_floor", "thing_wall", "thing_thing", "thing_hand", "thing_leg")
#: Depths [m].
DEPTHS = (0.01, 0.03)


def _pushed(posed, shape, at, out, deep):
    """The place of a shape that touches a person at `at`, for that depth in one of the hulls."""
    geometry = coal_shape(shape, solid=True)

    def depth(way):
        place = coal.Transform3s(np.eye(3), at - way * out)
        found = []
        for h in range(len(posed.points)):
            mine, turn, x = posed.shape(h, 0)
            result = coal.DistanceResult()
            there = coal.Transform3s(turn, x)
            found.append(-coal.distance(geometry, place, mine, there, REQUEST, result))
        return max(found)

    low, high = -0.2, 0.0
    while depth(high) < deep:
        high += 0.01
    for _ in range(20):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if depth(middle) < deep else (low, middle)
    return at - high * out


def build(case: Case, contact: str, data=None) -> Start:
    """A person stands and waves; one or two objects overlap an item."""
    rng = case.rng()
    u = rng.uniform
    deep = u(*DEPTHS)
    rotations = POSES["reach" if case.kind == "thing_hand" else "stand"](rng)
    two = Motion(np.zeros((2, 3)), np.stack([rotations] * 2), 30.0)
    lift = 0.005 - body().vertices(two, frames=0)[:, 2].min()
    two = two.with_frames(two.translation + np.array([0.0, 0.0, lift]), two.rotations)
    posed = hulls(contact).at(two)
    scene = Scene()
    form = str(rng.choice(["primitives", "meshes"]))
    solids = [ground()]
    if form == "meshes":
        slab = box_mesh((-5.0, -5.0, -0.3), (5.0, 5.0, 0.0))
        scene.add_static("floor", finely(slab, rng.integers(0, 5)))
    else:
        scene.add_static("floor", Plane())
    held = set()
    mass = float(np.exp(u(np.log(0.2), np.log(30.0))))
    half = u(0.05, 0.2, size=3)
    yaw = rot.exp([0.0, 0.0, u(-np.pi, np.pi)])
    where = np.array([1.2, 0.0, 0.0]) + 0.2 * rng.normal(size=3) * (1, 1, 0)
    if case.kind == "thing_floor":
        # Flat, on an edge or a ball, as deep as it is.
        shape = [Box(tuple(2 * half)), Sphere(half[0]), Cylinder(half[0], 2 * half[2])][
            rng.integers(3)
        ]
        turn = yaw if rng.random() < 0.5 else rot.multiply(yaw, rot.exp(u(-0.5, 0.5, size=3)))
        corners = shape.triangles()[0] @ rot.to_matrix(turn).T
        at = where + np.array([0.0, 0.0, -deep - corners[:, 2].min()])
        scene.add_object("thing", shape, mass=mass, position=at, quaternion=turn)
    elif case.kind == "thing_wall":
        front = where[0] + half[0] - deep
        wall = box("wall", (front, -2.0, 0.0), (front + 0.3, 2.0, 2.0))
        solids.append(wall)
        if form == "meshes":
            mesh = finely(box_mesh(-wall.half, wall.half), rng.integers(0, 4))
            scene.add_static("wall", mesh, position=wall.centre)
        else:
            scene.add_static("wall", Box(tuple(2 * wall.half)), position=wall.centre)
        scene.add_object("thing", Box(tuple(2 * half)), mass=mass,
                         position=(where[0], where[1], half[2] + 0.001))  # fmt: skip
    elif case.kind == "thing_thing":
        other = u(0.05, 0.2, size=3)
        first = np.array([where[0], where[1], half[2] + 0.001])
        if rng.random() < 0.5:  # side by side
            second = first + np.array(
                [half[0] + other[0] - deep, u(-0.05, 0.05), other[2] - half[2]]
            )
        else:
            second = first + np.array([*u(-0.02, 0.02, size=2), half[2] + other[2] - deep])
        scene.add_object("thing", Box(tuple(2 * half)), mass=mass, position=first)
        scene.add_object("other", Box(tuple(2 * other)), density=400.0, position=second)
    else:
        if case.kind == "thing_hand":
            arms = ("left", "right")
            ahead = [posed.joints[0, JOINT_INDEX[f"{a}_wrist"], 0] for a in arms]
            joint = JOINT_INDEX[f"{arms[int(np.argmax(ahead))]}_wrist"]
            small = u(0.03, 0.06)
            shape = [Sphere(small), Capsule(0.7 * small, 0.1), Box((2 * small,) * 3)][
                rng.integers(3)
            ]
            out = np.array([u(-0.3, 0.3), u(-0.3, 0.3), rng.choice([-1.0, 1.0])])
            mass = min(mass, 2.0)
        else:
            joint = JOINT_INDEX[rng.choice(["left_knee", "right_knee"])]
            shape, out = Box(tuple(2 * half)), np.array([1.0, u(-0.3, 0.3), 0.0])
        out /= np.linalg.norm(out)
        held = {joint}
        hand = case.kind == "thing_hand"
        mine = np.concatenate(
            [p[0] for p, j in zip(posed.points, posed.hulls.joint, strict=True)
             if j == joint or not hand]
        )  # fmt: skip
        mine = mine[hand | (mine[:, 2] < 2 * half[2])]
        touch = mine[(mine @ out).argmax()]
        at = touch - (shape.triangles()[0] @ out).min() * out
        if case.kind == "thing_leg":
            at[2] = half[2] + 0.001
        at = _pushed(posed, shape, at, out, deep)
        scene.add_object("thing", shape, mass=mass, position=at)
    frames = int(SECONDS * 30.0) + 1
    turns = wave(np.tile(rotations, (frames, 1, 1)), held, rng)
    return Start(
        motion=Motion(np.tile(two.translation[0], (frames, 1)), turns, 30.0),
        scene=scene,
        settings=as_it_is(record="substeps"),
        solids=solids,
        form=form,
        target="wave",
        depth=deep,
        held=False,
        objects=tuple(scene.objects),
    )

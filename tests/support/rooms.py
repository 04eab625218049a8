"""Furnished rooms of real meshes around a motion: obstacles in its way, and furniture around it.

The same seed gives the same room. The first pose is clear of every item (by `coal`, hulls of the
skin and rigid parts): overlapping items are moved away from it, no farther than needed.
"""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.judges.clear_judge import NEAR, Judge

#: The meshes are in units of about 0.7 m.
SCALE = 0.7
#: Obstacles in a motion's way: file, height of its origin [m].
PIECES = (
    ("kaykit_furniture/couch", 0.0),
    ("kaykit_furniture/armchair", 0.0),
    ("kaykit_furniture/table_low", 0.0),
    ("kaykit_furniture/table_medium_long", 0.0),
    ("kaykit_furniture/chair_A", 0.0),
    ("kaykit_furniture/cabinet_medium", 0.0),
    ("kaykit_furniture/bed_single_A", 0.0),
    ("kaykit_furniture/shelf_A_big", 1.2),
    ("kaykit_prototype/Box_A", 0.0),
    ("kaykit_prototype/Barrel_A", 0.35),
    ("kaykit_prototype/Door_A", 0.0),
    ("kaykit_restaurant/pot_A", 0.0),
)
WALLS = ("kaykit_prototype/Primitive_Wall", "kaykit_prototype/Wall_Doorway")
FLOOR = "kaykit_prototype/Primitive_Floor"
TILE = 2.8  # width of a floor tile and of a wall [m]
TILE_TOP = 0.7


def furnished(motion, body, folder, seed, pieces=6):
    """A room around `motion`: tiles of floor with their top at z = 0, four walls, furniture.

    Args:
        motion: Its feet on z = 0 or above. Walls come as near as 0.3 m to its pelvis, pieces
            stand where a pelvis, hand or foot of it passes.
        body: The body of the motion.
        folder: Holds `kaykit_furniture` and the like.
        seed: Selects pieces and places.
        pieces: Number of pieces.
    """
    rng = np.random.default_rng(seed)
    joints = body.joints(motion)
    judge = Judge(Simulator(Scene(), body=body, fps=motion.fps), contact="both")
    first = judge.world.start([motion[0]])[0]
    scene = Scene()

    def put(name, file, position, yaw, away):
        """Add it, moved along `away` until the first pose is clear."""
        position = np.array(position, dtype=float)
        turn = rot.exp([0.0, 0.0, yaw])
        path = folder / f"{file}.obj"
        while True:
            static = Scene().add_static(name, _mesh(path), position=position, quaternion=turn)
            if judge.gap_to(static, first) >= 0.5 * NEAR:
                break
            position = position + 0.02 * np.asarray(away)
        scene.add_static(name, path, scale=SCALE, up="y", position=position, quaternion=turn)

    low, high = joints[:, 0, :2].min(axis=0), joints[:, 0, :2].max(axis=0)
    middle = 0.5 * (low + high)
    count = np.ceil((high - low + 2.4) / TILE).astype(int)
    for a in range(count[0]):
        for b in range(count[1]):
            at = middle + TILE * (np.array([a, b]) - 0.5 * (count - 1))
            # Fresh from the file the floor stands at the height of its top.
            put(f"floor{a}{b}", FLOOR, (*at, -TILE_TOP), 0.0, (0.0, 0.0, -0.1))
    sides = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
    for k, side in enumerate(np.array(sides)):
        edge = np.where(side > 0, high, np.where(side < 0, low, middle))
        at = edge + side * (0.35 + rng.uniform(0.3, 1.0))
        put(f"wall{k}", rng.choice(WALLS), (*at, 0.0), np.arctan2(side[1], side[0]) + np.pi / 2,
            (*side, 0.0))  # fmt: skip
    for k in rng.choice(len(PIECES), size=pieces, replace=False):
        file, height = PIECES[k]
        frame = rng.integers(1, len(motion))
        target = joints[frame, rng.choice([0, 7, 8, 10, 11, 20, 21]), :2] + 0.2 * rng.normal(size=2)
        away = target - joints[0, 0, :2]
        away = away / max(np.linalg.norm(away), 1e-9)
        put(file.split("/")[1], file, (*target, height), rng.uniform(0.0, 2 * np.pi), (*away, 0.0))
    return scene


@cache
def _mesh(path):
    """The shape of a piece, read once however often it is moved."""
    return load_mesh(path, scale=SCALE, up="y")[0]


def merged(scene, triangles):
    """The scene with all its meshes as one static "room" of about as many `triangles`.

    The largest triangles are cut in four until there are enough: the same surface.
    """
    import trimesh

    vertices, faces, others = [], [], []
    for s in scene.statics.values():
        if not isinstance(s.shape, Mesh):
            others.append(s)
            continue
        faces.append(np.asarray(s.shape.faces) + sum(map(len, vertices)))
        vertices.append(s.shape.vertices @ rot.to_matrix(s.quaternion).T + s.position)
    v, f = np.concatenate(vertices), np.concatenate(faces)
    while len(f) + 3 <= triangles:
        a, b, c = (v[f[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        cut = min(max(1, len(f) // 2), (triangles - len(f)) // 3)
        v, f = trimesh.remesh.subdivide(v, f, face_index=np.argsort(-area, kind="stable")[:cut])
    out = Scene(gravity=scene.gravity)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        out.add_static("room", Mesh(v, f))
    for s in others:
        out.add_static(s.name, s.shape, position=s.position, quaternion=s.quaternion)
    return out

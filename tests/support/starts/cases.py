"""Starts in penetration: people 1 to 10 cm deep in floors, furniture and walls, and their motions.

A case is a kind and a seed; everything else is drawn from the two. Furniture is a few boxes
(`starts_solids.Solid`, as the judge measures), given to the simulator as boxes, as a mesh
each, as one connected mesh, or as a piece of one whole-room mesh.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from support.as_it_is import as_it_is
from support.starts.furniture import STRAIGHT, furniture_for
from support.starts.groups import groups_at
from support.starts.meshes import box_mesh, finely, furniture, sheet_mesh, union_mesh
from support.starts.poses import POSES, path_of, wave
from support.starts.solids import Hulls, Solid, ground

#: Per kind: the pose, the direction of the push, and the depth [m].
KINDS = {
    "floor": ("stand", (0.0, 0.0, -1.0), (0.01, 0.10)),
    "sofa_side": ("stand", (1.0, 0.0, 0.0), (0.01, 0.10)),
    "sofa_seat": ("sit", (0.0, 0.0, -1.0), (0.01, 0.10)),
    "root": ("sit_or_lie", (0.0, 0.0, -1.0), (0.08, 0.10)),
    "shelf": ("reach", (1.0, 0.0, 0.0), (0.01, 0.10)),
    "wall_arm": ("reach", (1.0, 0.0, 0.0), (0.01, 0.10)),
    "wall_leg": ("step", (1.0, 0.0, 0.0), (0.01, 0.10)),
    "wall_torso": ("bend", (1.0, 0.0, 0.0), (0.01, 0.10)),
    "table_hip": ("stand", (1.0, 0.0, 0.0), (0.01, 0.10)),
    "table_hand": ("lean", (0.0, 0.0, -1.0), (0.01, 0.10)),
    "table_torso": ("bend", (0.0, 0.0, -1.0), (0.01, 0.10)),
}
FORMS = ("primitives", "meshes", "merged", "room")
TARGETS = ("still", "wave", "limb", "walk", "clip")
#: Shares of the targets; real clips stand, so they are for two kinds only.
SHARES = ((0.3, 0.25, 0.15, 0.3, 0.0), (0.2, 0.15, 0.15, 0.15, 0.35))
#: Frame rates and substeps: the default three times in four.
STEPS = ((30.0, None),) * 6 + ((60.0, None), (120.0, 2))
SECONDS = 1.4
#: Wanted and built depth differ by at most this [m].
BUILT = 3e-4


@dataclass(frozen=True)
class Case:
    kind: str
    seed: int

    @property
    def id(self):
        return f"{self.kind}-{self.seed}"

    @staticmethod
    def of(text):
        kind, seed = text.rsplit("-", 1)
        return Case(kind, int(seed))

    def rng(self):
        return np.random.default_rng(zlib.crc32(self.id.encode()))


@dataclass(frozen=True, eq=False)
class Start:
    """A case, built.

    Attributes:
        motion: Starts inside. scene, settings: Its world and options.
        solids: The static geometry, convex and in the world; without the rest of a whole room.
        form, target, depth: Its kind; depth of the deepest group [m].
        held: Whether the motion stays inside (the target is still).
        objects: Names of objects that start overlapping.
    """

    motion: Motion
    scene: Scene
    settings: Settings
    solids: list[Solid]
    form: str
    target: str
    depth: float
    held: bool
    objects: tuple[str, ...] = field(default=())


def build(case, contact, data=None):
    """The case at its start: `contact` is the measured surface, "parts" or "skin"."""
    rng = case.rng()
    for _ in range(20):
        found = _try(case, contact, data, rng)
        if found is not None:
            return found
    raise RuntimeError(f"{case.id}: nothing to start from was found")


@cache
def body():
    return Body.default()


@cache
def hulls(contact):
    return Hulls(body(), contact)


def _try(case, contact, data, rng):
    pose, way, (low, high) = KINDS[case.kind]
    want = rng.uniform(low, high)
    form = rng.choice(FORMS)
    rotations = POSES[pose](rng)
    clips = data is not None and case.kind in ("floor", "sofa_side")
    target = rng.choice(TARGETS, p=SHARES[clips])
    clip = None
    if target == "clip":
        clip = _clip(data, rng)
        rotations = clip.rotations[0]
    # Upright in its own frame: the root turned to face +x, the lowest point at z = 0.
    first = Motion(np.zeros((2, 3)), np.stack([rotations] * 2), 30.0)
    points = body().vertices(first, frames=0)
    shift = np.array([-points[:, 0].max(), -points[:, 1].mean(), -points[:, 2].min()])
    posed = hulls(contact).at(Motion(np.tile(shift, (2, 1)), first.rotations, 30.0))
    one = case.kind if form in STRAIGHT else ""
    solids = [replace(s, static=one) for s in furniture_for(case.kind, form, posed, rng)]
    at = _push(posed, solids, np.array(way), want)
    if at is None:
        return None
    start = shift + at * np.array(way)
    posed = posed.moved(at * np.array(way))
    if case.kind != "floor":
        # The floor under all furniture; in a third of the cases the feet are in it too.
        lowest = posed.low[0, :, 2].min()
        sunk = rng.uniform(0.01, 0.05) if rng.random() < 0.33 else -rng.uniform(0.002, 0.03)
        solids = [*solids, replace(ground(z=lowest + sunk), static=one)]
    groups = groups_at(posed, 0, solids)
    depth = max((g.depth for g in groups), default=0.0)
    if not 0.5 * low <= depth <= 0.11:
        return None
    motion = _target(target, rotations, start, clip, groups, posed, rng)
    turn = rot.exp([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
    aside = np.array([*rng.uniform(-3.0, 3.0, size=2), 0.0])
    scene = _scene(solids, form, case.kind, turn, aside, rng, data)
    fps, count = STEPS[rng.integers(len(STEPS))]
    settings = as_it_is(
        substeps=count,
        record="substeps",
        root="recover" if rng.random() < 0.25 else "stay",
        drive_time=None if rng.random() < 0.15 else 0.02,
        stiffness=float(rng.choice([0.0, 1.0, 1.0, 1.0, 1.0, 10.0])),
    )
    return Start(
        motion=_turned(motion, turn, aside).resample(fps) if fps != motion.fps
        else _turned(motion, turn, aside),
        scene=scene,
        settings=settings,
        solids=[s.moved(rot.to_matrix(turn), aside) for s in solids],
        form=str(form),
        target=str(target),
        depth=depth,
        held=target in ("still", "wave"),
    )  # fmt: skip


def _push(posed, solids, way, want):
    """Length of the push along `way` until the deepest group is `want` deep; None: never."""

    def depth(at):
        return max((g.depth for g in groups_at(posed.moved(at * way), 0, solids)), default=0.0)

    # From a clear pose on the near side, until the first touch and on.
    at, before = -0.6, -0.6
    while (deep := depth(at)) < want:
        if at > 0.7:
            return None
        before, at = at, at + (0.04 if deep == 0.0 else 0.02)
    for _ in range(20):
        middle = 0.5 * (before + at)
        deep = depth(middle)
        if deep < want:
            before = middle
        else:
            at = middle
        if abs(deep - want) < BUILT:
            return middle
    return at if abs(depth(at) - want) < 0.01 else None


# -- the scene -------------------------------------------------------------------------------


def _scene(solids, form, kind, turn, aside, rng, data):
    """The solids as statics; in a "room" all are one mesh, with walls and more around."""
    scene = Scene()
    where = {"position": aside, "quaternion": turn}
    boxes = [s for s in solids if s.half is not None]
    floors = [s for s in solids if s.half is None]
    if form in STRAIGHT:
        # A plane of the judge is a large slab.
        spans = [(s.centre - np.abs(s.turn) @ s.half, s.centre + np.abs(s.turn) @ s.half)
                 for s in boxes]  # fmt: skip
        for s in floors:
            z = s.centre[2]
            spans.append((np.array([-4.0, -4.0, z - 0.2]), np.array([4.0, 4.0, z])))
            if form == "room":
                spans += [
                    (np.array([-4.2, -4.2, z - 0.2]), np.array([-4.0, 4.2, z + 2.5])),
                    (np.array([4.0, -4.2, z - 0.2]), np.array([4.2, 4.2, z + 2.5])),
                    (np.array([-4.0, 4.0, z - 0.2]), np.array([4.0, 4.2, z + 2.5])),
                    (np.array([-3.9, -3.9, z]), np.array([-3.2, -2.6, z + 0.75])),
                    (np.array([2.5, 2.5, z]), np.array([3.9, 3.1, z + 1.9])),
                ]
        mesh = finely(union_mesh(spans), rng.integers(0, 3) + (2 if form == "room" else 0))
        if form == "room" and data is not None:
            mesh = furniture(mesh, data / "meshes", floors[0].centre[2], rng)
        scene.add_static("room" if form == "room" else kind, mesh, **where)
        return scene
    # Floors and walls come as open sheets too: only the root tells which side is behind them.
    sheet = form == "meshes" and (kind == "floor" or kind.startswith("wall")) and rng.random() < 0.4
    for s in boxes:
        place = {
            "position": rot.rotate(turn, s.centre) + aside,
            "quaternion": rot.multiply(turn, rot.from_matrix(s.turn)),
        }
        if form == "primitives":
            scene.add_static(s.name, Box(tuple(2.0 * s.half)), **place)
        elif sheet:
            mesh = sheet_mesh(2.0, 2.0).apply_transform(_facing(s))
            scene.add_static(s.name, finely(mesh, rng.integers(0, 5)), **where)
        else:
            scene.add_static(s.name, finely(box_mesh(-s.half, s.half), rng.integers(0, 4)), **place)
    for s in floors:
        height = np.array([0.0, 0.0, s.centre[2]])
        if form == "primitives" and rng.random() < 0.5:
            scene.add_static(s.name, Plane(), position=height + aside, quaternion=turn)
        elif form == "primitives":
            scene.add_static(
                s.name, Box((12.0, 12.0, 0.4)), position=height + aside - (0, 0, 0.2),
                quaternion=turn,
            )  # fmt: skip
        else:
            slab = box_mesh((-6.0, -6.0, -0.3), (6.0, 6.0, 0.0))
            slab = sheet_mesh(6.0, 6.0) if sheet else slab
            scene.add_static(s.name, finely(slab, rng.integers(0, 5)),
                             position=height + aside, quaternion=turn)  # fmt: skip
    return scene


def _facing(wall):
    """Takes a sheet in the x-y plane, its normal +z, to the near face of a wall (4, 4)."""
    n = wall.normals[wall.near]
    out = np.eye(4)
    out[:3, :3] = np.stack([wall.turn[:, 2], np.cross(n, wall.turn[:, 2]), n], axis=1)
    out[:3, 3] = wall.centre + wall.half[wall.near // 2] * n
    return out


# -- the reference ---------------------------------------------------------------------------


@cache
def _clips(folder):
    from campaigns.clear import clips

    return list(clips(folder).values())


def _clip(data, rng):
    """A second and a half of a real clip, its first pose facing +x."""
    motions = _clips(data)
    motion = motions[rng.integers(len(motions))].resample(30.0)
    first = rng.integers(0, max(1, len(motion) - 45))
    motion = motion[first : first + 45]
    turns = rot.to_matrix(rot.exp(motion.rotations[0, 0]))
    ahead = turns[:, 2]
    yaw = rot.exp([0.0, 0.0, -np.arctan2(ahead[1], ahead[0])])
    return _turned(motion, yaw, np.zeros(3))


def _target(target, rotations, start, clip, groups, posed, rng):
    frames = int(SECONDS * 30.0) + 1
    if target == "clip":
        path = clip.translation - clip.translation[0] + start
        return clip.with_frames(path, clip.rotations)
    path = np.tile(start, (frames, 1))
    turns = np.tile(rotations, (frames, 1, 1))
    joints = posed.hulls.joint
    held = {int(joints[h]) for g in groups for h in g.hulls}
    if target == "wave":
        turns = wave(turns, held, rng)
    elif target == "limb":
        turns = wave(turns, held, rng, own=True)
    elif target == "walk":
        path = path + path_of(frames, rng)
        turns = wave(turns, held, rng)
    return Motion(path, turns, 30.0)


def _turned(motion, turn, aside):
    """A motion under a rotation about z through the origin, then a shift."""
    rest = body().rest_joints[0]
    root = rot.multiply(turn, rot.exp(motion.rotations[:, 0]))
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.log(root)
    path = rot.rotate(turn, motion.translation + rest) + aside - rest
    return motion.with_frames(path, rotations)

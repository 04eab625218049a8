"""People who sit, lie, crouch, lean and poke: motions that press the skin into furniture.

Each case is two keys (`Key`): a clear one and one inside, with the furniture placed so that the
second is some centimetres inside, for any body. `build` makes motion and scene of it; the
cases are in `posture_cases`, `posture_hands` and `posture_bumps`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS, PARENTS
from halfphysics.scenarios.acting.legs import WORLD_FROM_REST, about
from halfphysics.scene.scene import Scene
from support.judges.skin_obstacles import Primitive
from support.postures.furniture import scene_of

#: Durations of a case: wait, approach, and stay and rub [s].
WAIT, GO, RUB = 0.1, 0.7, 0.5
#: Amplitude of rubbing [m], and its frequency [1/s].
RUBBING, PER_SECOND = 0.012, 1.5
#: The aimed part is this deep inside at the end [m], chosen by the seed.
DEPTHS = (0.03, 0.06)
#: A start is clear by this [m]: more than the clearance.
CLEAR = 0.003
#: Joint differences from the case as written [rad], except for seed 0.
JITTER, FINGER_JITTER = 0.03, 0.15
#: Farthest that a tool is taken from its first touch, to come back, and its shortest step [m].
ROOM, TOUCH = 0.3, 0.002
#: Triangles with longer edges [m] are also checked between their corners.
WIDE = 0.015
_STEPS = 4
_BETWEEN = np.array(
    [
        (i, j, _STEPS - i - j)
        for i in range(_STEPS + 1)
        for j in range(_STEPS + 1 - i)
        if max(i, j, _STEPS - i - j) < _STEPS
    ],
    dtype=float,
) / float(_STEPS)
FINGERS = ("index", "middle", "ring", "pinky")


def leaning(angle):
    """The pelvis of a body that leans ahead by an angle [rad]; -pi/2: on the back."""
    return about(1, angle) @ WORLD_FROM_REST


@dataclass(frozen=True)
class Key:
    """A pose: rotations (55, 3) and the pelvis position (3,)."""

    rotations: np.ndarray
    pelvis: np.ndarray

    def moved(self, *way):
        """The same pose at another place."""
        return Key(self.rotations, self.pelvis + np.asarray(way, float))


@dataclass(frozen=True, eq=False)
class Posture:
    """A built case: motion, scene, and parts of which at least one must press."""

    name: str
    kind: str
    motion: Motion
    scene: Scene
    parts: tuple[str, ...]
    depth: float


@dataclass
class Rig:
    """Pose a body and measure its skin. `turns`: joint -> axis-angle; "both_knee" does both
    sides, the right one mirrored; "curl_left": bending angle of its fingers [rad]."""

    body: object
    depth: float
    seed: int = 0
    _off: np.ndarray = field(init=False)
    _part: np.ndarray = field(init=False)
    _wide: np.ndarray = field(init=False)

    def __post_init__(self):
        rng = np.random.default_rng(self.seed)
        off = rng.normal(size=(N_JOINTS, 3)) * JITTER
        off[25:] *= FINGER_JITTER / JITTER
        off[25:, :2] = 0.0  # fingers bend one way
        self._off = off if self.seed else np.zeros((N_JOINTS, 3))
        self._part = np.argmax(self.body.weights, axis=1)
        faces = np.asarray(self.body.faces)
        corners = np.asarray(self.body.rest_vertices)[faces]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        self._wide = faces[edges.max(axis=1) > WIDE]

    def key(self, root=WORLD_FROM_REST, pelvis=(0.0, 0.0, 1.0), **turns):
        """A pose with the pelvis turned by `root` (3, 3), world from rest."""
        rotations = np.zeros((N_JOINTS, 3))
        for name, turn in turns.items():
            if name.startswith("curl"):
                for side in ("left", "right") if "both" in name else (name.split("_")[1],):
                    _curl(rotations, side, turn)
                continue
            turn = np.asarray(turn, float)
            for side in ("left", "right") if name.startswith("both_") else ("",):
                joint = JOINT_INDEX[name.replace("both", side) if side else name]
                rotations[joint] = turn * ((1.0, -1.0, -1.0) if side == "right" else 1.0)
        quats = rot.multiply(rot.exp(rotations), rot.exp(self._off))
        rotations = rot.log(quats)
        rotations[0] = rot.matrix_to_rotvec(np.asarray(root))
        return Key(rotations, np.asarray(pelvis, float))

    def facing(self, key, joint, matrix):
        """The key with one joint turned so that it has this orientation (3, 3), world from rest."""
        i = JOINT_INDEX[joint]
        above = np.eye(3)
        chain, p = [], int(PARENTS[i])
        while p >= 0:
            chain.append(p)
            p = int(PARENTS[p])
        for p in reversed(chain):
            above = above @ rot.rotvec_to_matrix(key.rotations[p])
        rotations = key.rotations.copy()
        rotations[i] = rot.matrix_to_rotvec(above.T @ matrix)
        return Key(rotations, key.pelvis)

    def motion(self, keys, fps=30.0):
        """A motion whose frames are these keys."""
        path = np.array([k.pelvis for k in keys]) - np.asarray(self.body.rest_joints)[0]
        return Motion(path, np.array([k.rotations for k in keys]), fps)

    def skin(self, key, *parts):
        """Vertices (n, 3) of a pose: all, or those of the named parts by largest weight."""
        vertices = self.body.vertices(self.motion([key, key]), frames=0)
        if not parts:
            return vertices
        names = [p.replace("both", s) for p in parts for s in ("left", "right")]
        return vertices[np.isin(self._part, [JOINT_INDEX[n] for n in names])]

    def reach(self, key, direction, *parts):
        """The point (3,) of these parts that is farthest along a direction."""
        points = self.skin(key, *parts)
        return points[(points @ np.asarray(direction, float)).argmax()]

    def low(self, key, *parts):
        """Height of the lowest point of these parts [m]."""
        return float(self.reach(key, (0.0, 0.0, -1.0), *parts)[2])

    def points(self, key):
        """Vertices, and more points where they are far apart: thin objects fit between them."""
        skin = self.skin(key)
        corners = skin[self._wide]
        return np.concatenate([skin, np.einsum("ka,fai->fki", _BETWEEN, corners).reshape(-1, 3)])

    def joint(self, key, name):
        """The position of a joint (3,)."""
        return self.body.joints(self.motion([key, key]))[0, JOINT_INDEX[name]]

    def advanced(self, key, pieces, direction, depth=None):
        """Pieces moved against `direction`, from afar, until they are `depth` inside the skin.

        The pose moved back along `direction` is then clear: it is the same way. A negative depth
        leaves them as far away.
        """
        depth = self.depth if depth is None else depth
        u = np.asarray(direction, float) / np.linalg.norm(direction)
        skin = self.points(key)

        def inside(way):
            return max(deepest(p.moved(way * u), skin) for p in pieces)

        near = 0.0
        while inside(near) > 0.0:
            near += 0.01
        # Out as far as it is clear, no step longer than the distance, then in to the first touch.
        far = near
        away = -inside(far)
        while far < near + ROOM and away >= 0.0:
            far, last = far + max(away, TOUCH), far
            away = -inside(far)
        far = last if away < 0.0 else far
        away = -inside(far)
        while away > 0.0:
            step = max(away, TOUCH)
            far -= step
            if far < near - 2.0:
                raise ValueError("this tool never meets the body")
            away = -inside(far)
        within, far = far, far + step
        for _ in range(8):
            middle = 0.5 * (within + far)
            within, far = (middle, far) if inside(middle) > 0.0 else (within, middle)
        return [p.moved((far - depth) * u) for p in pieces]


def _curl(rotations, side, angle):
    sign = -1.0 if side == "left" else 1.0
    for finger in FINGERS:
        for k in (1, 2, 3):
            rotations[JOINT_INDEX[f"{side}_{finger}{k}"]] = (0.0, 0.0, sign * angle)
    rotations[JOINT_INDEX[f"{side}_thumb1"]] = (0.35 * angle, 0.0, 0.0)


def deepest(piece, points):
    """How deep the deepest of some points is in a piece [m].

    Under 0: all points are outside, at least that far.
    """
    local = (points - np.asarray(piece.position)) @ rot.to_matrix(np.asarray(piece.quaternion))
    if not isinstance(piece.shape, tuple):
        return -Primitive(piece.shape).smallest(local, np.inf)[0]
    corners = np.asarray(piece.shape[0])[np.asarray(piece.shape[1])]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = np.einsum("fi,fi->f", normals, corners[:, 0])
    beside = local @ normals[0] - offsets[0]
    for normal, offset in zip(normals[1:], offsets[1:], strict=True):
        np.maximum(beside, local @ normal - offset, out=beside)
    return -float(beside.min())


def cleared(rig, start, end, pieces):
    """The first key, moved away from the last until it is clear."""
    away, length = start.pelvis - end.pelvis, 0.01
    step = length * away / max(np.linalg.norm(away), 1e-9)
    points = rig.points(start)
    gaps = [-deepest(p, points) for p in pieces]
    while min(gaps) < CLEAR:
        start, points = start.moved(*step), points + step
        if np.linalg.norm(start.pelvis - end.pelvis) > 1.0 or not away.any():
            raise ValueError("no clear start on the way back from the last key")
        # A point that is far enough stays so: it is not checked again.
        gaps = [g - length for g in gaps]
        gaps = [g if g > CLEAR else -deepest(p, points) for g, p in zip(gaps, pieces, strict=True)]
    return start


def played(rig, start, end, rub, fps, pace):
    """The motion from key to key that then rubs along `rub` (3,), over WAIT + GO + RUB [s]."""
    t = np.arange(round((WAIT + GO / pace + RUB) * fps) + 1) / fps
    x = np.clip((t - WAIT) * pace / GO, 0.0, 1.0)
    s = (x * x * (3.0 - 2.0 * x))[:, None]
    after = np.maximum(t - WAIT - GO / pace, 0.0)
    swing = RUBBING * np.sin(2.0 * np.pi * PER_SECOND * after) * np.minimum(after / 0.1, 1.0)
    pelvis = (
        start.pelvis + s * (end.pelvis - start.pelvis) + swing[:, None] * np.asarray(rub, float)
    )
    a, b = rot.exp(start.rotations), rot.exp(end.rotations)
    turns = rot.log(rot.slerp(a[None], b[None], np.broadcast_to(s, (len(t), N_JOINTS))))
    return Motion(pelvis - np.asarray(rig.body.rest_joints)[0], turns, fps)


def cases():
    """Name -> function of a `Rig`; bumps are called place-tool."""
    from support.postures.bumps import BUMPS
    from support.postures.cases import CASES
    from support.postures.hands import HANDS

    return {**CASES, **HANDS, **BUMPS}


def build(name, body, kind="primitives", fps=30.0, seed=0, depth=None, pace=1.0):
    """One of `cases()` for a body, among furniture of one of `furniture.KINDS`.

    seed: 0 as written; others vary the pose and the depth. pace: factor on the speed.
    """
    low, high = DEPTHS
    share = np.random.default_rng(seed).random() if seed else 0.5
    rig = Rig(body, low + share * (high - low) if depth is None else depth, seed)
    start, end, pieces, parts, rub = cases()[name](rig)
    start = cleared(rig, start, end, pieces)
    motion = played(rig, start, end, rub, fps, pace)
    return Posture(name, kind, motion, scene_of(pieces, kind), parts, rig.depth)

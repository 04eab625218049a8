"""A long walk with sitting, joined from clips, and a furnished room around it."""

from __future__ import annotations

import itertools

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box
from halfphysics.motion.easing import ease
from halfphysics.motion.motion import Motion
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from support.rooms import SCALE

#: Length [s] at which no further clip is joined, and time from one clip to the next [s].
LENGTH, BLEND = 45.0, 0.6
#: Share of the time in whose way furniture stands: after it the person can come back.
BUSY = 0.7
#: Distance of a piece's middle from the path, at least and at most [m]: pieces are 0.6 to 0.9 m
#: wide, a person 0.5, so that all are in the way and none closes it.
BESIDE = (0.35, 0.6)
#: Its distance from the start, the sitting, the end of the path and from other pieces [m]; pieces,
#: and places that are tried for them.
FREE, PIECES, TRIES = 0.9, 5, 400
#: The seat is this far inside the sitting skin [m].
SUNK = 0.03
FURNITURE = ("armchair", "table_low", "chair_A", "cabinet_medium", "table_medium_long")
WALL = 0.1  # thickness [m]


def heading(rotation):
    """Where a pelvis looks (about z) [rad]; rotation (3,)."""
    ahead = rot.rotate(rot.exp(rotation), np.array([0.0, 0.0, 1.0]))
    return float(np.arctan2(ahead[1], ahead[0]))


def placed(motion, body, xy, yaw):
    """The motion with its first pelvis over `xy` (2,), looking along `yaw`; axes of the world."""
    pelvis = motion.translation + motion.axes @ body.rest_joints[0]
    turn = rot.exp([0.0, 0.0, yaw - heading(motion.rotations[0, 0])])
    first = np.array([*pelvis[0, :2], 0.0])
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(rotations[:, 0])))
    root = rot.rotate(turn, pelvis - first) + np.array([*xy, 0.0])
    return Motion(root - body.rest_joints[0], rotations, motion.fps)


def joined(pieces, fps):
    """Motions one after the other, with a turn of every joint from one to the next."""
    count = round(BLEND * fps)
    share = ease(np.arange(1, count) / count)
    translation, rotations = [pieces[0].translation], [pieces[0].rotations]
    for before, after in itertools.pairwise(pieces):
        a, b = before.translation[-1], after.translation[0]
        translation += [a + share[:, None] * (b - a), after.translation]
        start, end = rot.exp(before.rotations[-1]), rot.exp(after.rotations[0])
        turns = [rot.log(rot.slerp(start, end, np.full(len(start), s))) for s in share]
        rotations += [np.array(turns), after.rotations]
    return Motion(np.concatenate(translation), np.concatenate(rotations), fps)


def long_walk(clips, body, seed, fps):
    """Walks with turns, sitting down and other clips between them.

    Args:
        clips: Name -> motion on the floor at `fps`; "asap_squat3" is the sitting.

    Returns:
        The motion, and frames between which it sits [(start, stop)].
    """
    rng = np.random.default_rng(seed)
    others = sorted(name for name in clips if "jump" not in name and name != "asap_squat3")
    pieces, sits, yaw, xy, frames, k = [], [], 0.0, np.zeros(2), 0, 0
    gap = round(BLEND * fps) - 1
    while frames < LENGTH * fps:
        if k % 2 == 0:
            plan = Walk(distance=float(rng.uniform(2.0, 3.0)), speed=float(rng.uniform(0.8, 1.2)))
            piece = walk(body, plan, fps)
        else:
            piece = clips["asap_squat3" if k % 4 == 1 else rng.choice(others)]
        piece = placed(piece, body, xy, yaw)
        if k % 4 == 1:
            sits.append((frames, frames + len(piece)))
        frames += len(piece) + gap
        pieces.append(piece)
        xy = (piece.translation[-1] + body.rest_joints[0])[:2]
        # Turns stay within the room: back toward its middle once far out.
        yaw = heading(piece.rotations[-1, 0]) + rng.uniform(-1.2, 1.2)
        if np.linalg.norm(xy) > 2.0:
            home = np.arctan2(-xy[1], -xy[0])
            yaw = home + rng.uniform(-0.4, 0.4)
        k += 1
    return joined(pieces, fps), sits


def room(motion, sits, body, folder, seed):
    """Floor, walls around the path, seats under the sitting, furniture that the path grazes."""
    rng = np.random.default_rng(seed)
    scene = stage.floor()
    path = (motion.translation + body.rest_joints[0])[:, :2]
    low, high = path.min(axis=0) - 1.5, path.max(axis=0) + 1.5
    middle, size = 0.5 * (low + high), high - low
    for k, side in enumerate(((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))):
        at = middle + 0.5 * np.array(side) * (size + WALL)
        extent = np.where(np.array(side) != 0.0, WALL, size + 2.0 * WALL)
        scene.add_static(f"wall{k}", Box((*extent, 2.4)), position=(*at, 1.2))
    for k, (start, stop) in enumerate(sits):
        seat(scene, f"seat{k}", motion, body, start, stop)
    busy = round(BUSY * len(path))
    pieces = []
    for _ in range(TRIES):
        if len(pieces) == PIECES:
            break
        frame = int(rng.integers(round(0.05 * busy), busy))
        angle = rng.uniform(0.0, 2.0 * np.pi)
        at = path[frame] + rng.uniform(*BESIDE) * np.array([np.cos(angle), np.sin(angle)])
        clear = np.concatenate([path[:1], path[busy:], *(path[a:b] for a, b in sits), *pieces])
        beside = np.linalg.norm(at - path, axis=1).min()
        if beside < BESIDE[0] or np.linalg.norm(at - clear, axis=1).min() < FREE:
            continue
        turn = rot.exp([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
        file = folder / "kaykit_furniture" / f"{rng.choice(FURNITURE)}.obj"
        scene.add_static(
            f"piece{len(pieces)}", file, scale=SCALE, up="y", position=(*at, 0.0), quaternion=turn
        )
        pieces.append(at[None])
    return scene


def seat(scene, name, motion, body, start, stop):
    """A stool under the deepest sitting of some frames, behind the heels, 3 cm too high."""
    pelvis = motion.translation[start:stop] + body.rest_joints[0]
    frame = start + int(pelvis[:, 2].argmin())
    part = body.weights.argmax(axis=1)
    skin = body.vertices(motion, frame)[np.isin(part, (0, 1, 2))]  # pelvis and thighs
    yaw = heading(motion.rotations[frame, 0])
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    lowest = skin[skin[:, 2].argmin()]
    top = lowest[2] + SUNK
    at = lowest[:2] - 0.1 * ahead
    if top > 0.1:
        scene.add_static(
            name, Box((0.3, 0.4, top)), position=(*at, 0.5 * top),
            quaternion=rot.exp([0.0, 0.0, yaw]),
        )  # fmt: skip

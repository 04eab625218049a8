"""Leaning on a wall and reaching into a shelf of a furnished room, given as one mesh."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.bench.clips import body
from halfphysics.bench.pressing import Play, pressed
from halfphysics.bench.record import Options, Record
from halfphysics.bench.room import SHELF_FACE, WALL_FACE, room, sizes
from halfphysics.bench.squatting import eased, squat
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene

#: Initial distance of the arm from the wall, and depth of the shoulder's target behind it [m].
_BEFORE, _PAST = 0.05, 0.15
#: Depth of the hand in the shelf [m]; its height is between two boards.
_INTO = 0.3
_FPS, _SECONDS = 30.0, 2.0


def lean(options: Options) -> Iterator[Record]:
    """Records of wall and shelf, both sizes of the room, both drives."""
    motions = {"wall": on_wall(), "shelf": into_shelf()}
    for triangles in sizes(options):
        made = room(triangles)
        scene = Scene()
        scene.add_static("room", made.mesh)
        for name, motion in motions.items():
            play = Play(
                motion=motion[:30] if options.quick else motion,
                scene=scene,
                hulls={"room": made.hulls},
            )
            for record, _, _ in pressed(
                "lean", f"{name}, {len(made.mesh.faces):,} triangles", play, options
            ):
                yield record


def on_wall() -> Motion:
    """A person beside the wall on the left tips to it and rocks with shoulder and arm on it."""
    t = np.arange(round(_SECONDS * _FPS) + 1) / _FPS
    tip, rock = eased(t, 0.1, 0.6), np.sin(2.0 * np.pi * 0.9 * t) * eased(t, 0.6, 0.4)
    motion = _standing(t)
    rotations = motion.rotations.copy()
    rotations[:, JOINT_INDEX["left_shoulder"], 2] = -1.35
    rotations[:, JOINT_INDEX["right_shoulder"], 2] = 1.25
    rotations[:, JOINT_INDEX["left_elbow"], 1] = -1.3
    rotations[:, JOINT_INDEX["left_shoulder"], 0] = -0.2 * (1.0 + rock)
    hung = motion.with_frames(motion.translation, rotations)
    side = _reach(hung, axis=1)
    path = motion.translation + np.array([0.0, WALL_FACE - _BEFORE - side, 0.0])
    angle = np.arcsin((_BEFORE + _PAST * (1.0 + 0.3 * rock)) / 1.4) * tip
    return _tipped(hung.with_frames(path, rotations), -angle)


def into_shelf() -> Motion:
    """A person with the shelf at the right hand moves the hand about in it."""
    t = np.arange(round(_SECONDS * _FPS) + 1) / _FPS
    go, stir = eased(t, 0.1, 0.6), eased(t, 0.6, 0.3)
    motion = _standing(t)
    rotations = motion.rotations.copy()
    rotations[:, JOINT_INDEX["left_shoulder"], 2] = -1.25
    rotations[:, JOINT_INDEX["right_shoulder"], 2] = 0.12 + 0.25 * np.sin(2 * np.pi * t) * stir
    rotations[:, JOINT_INDEX["right_shoulder"], 1] = 0.3 * np.sin(2 * np.pi * 0.7 * t) * stir
    rotations[:, JOINT_INDEX["right_wrist"], 2] = 0.4 * np.cos(2 * np.pi * 1.5 * t) * stir
    stretched = motion.with_frames(motion.translation, rotations)
    reach = _reach(stretched, axis=1, sign=-1.0)
    path = motion.translation + np.array([0.0, SHELF_FACE + 0.02 + reach, 0.0])
    path[:, 1] -= _INTO * go
    return stretched.with_frames(path, rotations)


def _standing(t: np.ndarray) -> Motion:
    still = np.zeros(len(t))
    return squat(body(), still, still, still, still, _FPS)


def _reach(motion: Motion, axis: int, sign: float = 1.0) -> float:
    """Largest extent of the parts in the first pose along an axis of the world [m]."""
    person = body()
    positions, quaternions = person.joint_frames(motion)
    turns = rot.to_matrix(quaternions[0])
    return max(
        float((sign * (p.vertices @ turns[p.index].T + positions[0, p.index])[:, axis]).max())
        for p in person.variant.parts
        if len(p.vertices)
    )


def _tipped(motion: Motion, angle: np.ndarray) -> Motion:
    """The motion rotated about the x axis through the soles; one side leaves the floor a little."""
    turn = rot.exp(np.stack([angle, 0.0 * angle, 0.0 * angle], axis=1))
    pelvis = motion.translation + body().rest_joints[0]
    foot = pelvis * [1.0, 1.0, 0.0]
    foot[:, 1] += 0.15 * np.sign(-angle)  # about the outer edge of the foot on that side
    moved = foot + rot.rotate(turn, pelvis - foot)
    root = rot.log(rot.multiply(turn, rot.exp(motion.rotations[:, 0])))
    rotations = np.concatenate([root[:, None], motion.rotations[:, 1:]], axis=1)
    return motion.with_frames(moved - body().rest_joints[0], rotations)

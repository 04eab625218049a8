"""What a recording is on a disk, and recordings at other frame rates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.motion.resampling import sample_positions
from halfphysics.results.result import ObjectTrack
from support.carries.recordings import Recording

#: Metres by which what is read may differ from what was recorded: files in double and in single
#: precision.
EXACT, SINGLE = 1e-9, 1e-5


@dataclass(frozen=True)
class Written:
    """A recording on a disk.

    Attributes:
        path: What `load_sequence` is given.
        middle: Where the middle of the thing is in the frame of its mesh file (3,) [m].
        precision: Of positions in the file [m].
    """

    path: Path
    middle: np.ndarray
    precision: float


def at_rate(made: Recording, fps: float) -> Recording:
    """The same recording at another frame rate; its hold is what lies within the old one."""
    old = made.motion.fps
    if fps == old:
        return made
    motion = made.motion.resample(fps)
    at = sample_positions(len(made.motion), old, fps)[: len(motion)]
    low = np.minimum(at.astype(int), len(made.track) - 2)
    part = (at - low)[:, None]
    position, turns = made.track.position, made.track.quaternion
    step = rot.log(rot.multiply(rot.conjugate(turns[low]), turns[low + 1]))
    track = ObjectTrack(
        position=(1.0 - part) * position[low] + part * position[low + 1],
        quaternion=rot.multiply(turns[low], rot.exp(part * step)),
    )
    first, last = made.hold
    hold = (
        int(np.ceil(first * fps / old - 1e-9)),
        min(int(np.floor(last * fps / old + 1e-9)), len(motion) - 1),
    )
    bend = np.interp(at, np.arange(len(made.bend)), made.bend)
    return replace(made, motion=motion, track=track, hold=hold, bend=bend)


def centred(made: Recording) -> tuple[trimesh.Trimesh, np.ndarray]:
    """The thing's mesh about the mean of its vertices, and where its middle is in it (3,) [m]."""
    mesh = made.thing.mesh
    mean = np.array(mesh.vertices.mean(axis=0))
    return trimesh.Trimesh(mesh.vertices - mean, mesh.faces, process=False), -mean


def poses(made: Recording, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (T, 3) [m] and matrices (T, 3, 3) of a mesh in which the middle is elsewhere."""
    matrix = rot.to_matrix(made.track.quaternion)
    return made.track.position - matrix @ middle, matrix


def in_axes(made: Recording, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Translation (T, 3) and rotations (T, 55, 3) in a file's axes; `axes`: world from file.

    The pelvis is at `J0 + translation` in the file's axes as it is in the world's.
    """
    rest = np.asarray(made.body.rest_joints)[0]
    translation = (made.motion.translation + rest) @ axes - rest
    rotations = np.array(made.motion.rotations)
    rotations[:, 0] = rot.matrix_to_rotvec(axes.T @ rot.rotvec_to_matrix(rotations[:, 0]))
    return translation, rotations

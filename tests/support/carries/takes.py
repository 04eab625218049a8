"""Takes: recordings of several people, feet and seats with one thing, in one form.

A `Recording` (recordings.py) has one person whose hands hold. A take has what a data set has of any
number of people, and for the judge what no data set says: which parts hold when.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Box
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence
from support.carries.acting import hand_joints, parts_of
from support.carries.things import Solid

#: Joints whose skin is of a part that holds, by the joint that stands for it.
PARTS = {
    **{f"{s}_wrist": (f"{s}_wrist", *(JOINT_NAMES[j] for j in hand_joints(s))) for s in
       ("left", "right")},
    **{f"{s}_ankle": (f"{s}_ankle", f"{s}_foot") for s in ("left", "right")},
    "pelvis": ("pelvis", "left_hip", "right_hip", "spine1", "spine2", "spine3"),
}  # fmt: skip


@dataclass(frozen=True)
class Hold:
    """A part of a person that holds the thing, from the first to the last frame.

    Attributes:
        person: Index of the person.
        part: "left_wrist", "right_ankle", "pelvis", ...: a key of `PARTS`.
        first, last: Frames.
    """

    person: int
    part: str
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class Take:
    """A recorded thing and the people who move it.

    Attributes:
        id: Tells takes apart.
        kind: What is done: "shared", "push", "seat", "drawer", "left".
        name: Of the thing.
        solids: Its shape.
        mass: [kg]
        bodies, motions: Of the people.
        track: Recorded poses of the thing.
        holds: Who holds it.
        statics: Name -> size (3,), position (3,), quaternion (4,) of boxes.
        frictions: (a, b) -> friction between two names.
        noise: Of the thing against the parts.
    """

    id: str
    kind: str
    name: str
    solids: tuple[Solid, ...]
    mass: float
    bodies: tuple
    motions: tuple
    track: ObjectTrack
    holds: tuple[Hold, ...]
    statics: dict = field(default_factory=dict)
    frictions: dict = field(default_factory=dict)
    noise: str = "none"

    @property
    def span(self) -> tuple[int, int]:
        """First and last frame in which anybody holds it."""
        return min(h.first for h in self.holds), max(h.last for h in self.holds)

    def sequence(self) -> Sequence:
        """As `load_sequence` has it, with the scene that it does not know."""
        scene = stage.floor()
        for name, (size, position, quaternion) in self.statics.items():
            scene.add_static(name, Box(size), position=position, quaternion=quaternion)
        meshes = [solid.mesh for solid in self.solids]
        whole = _together(meshes)
        scene.add_object(
            self.name,
            whole,
            mass=self.mass,
            position=self.track.position[0],
            quaternion=self.track.quaternion[0],
            pieces=[Mesh(m.vertices, m.faces) for m in meshes] if len(meshes) > 1 else "auto",
        )
        for (a, b), mu in self.frictions.items():
            scene.friction(a, b, mu)
        return Sequence(self.motions, scene, self.bodies, recorded={self.name: self.track})

    def distances(self, person, names, frames):
        """Signed distances of the skin of some parts of a person to the recorded thing (T, n)."""
        body = self.bodies[person]
        own = np.flatnonzero(np.isin(parts_of(body), names))
        points = body.vertices(self.motions[person], frames=frames, indices=own)
        quaternion = self.track.quaternion[frames][:, None]
        local = rot.rotate(rot.conjugate(quaternion), points - self.track.position[frames][:, None])
        return distance(self.solids, local)


def distance(solids, points):
    """Signed distances of points (..., 3) in the thing's frame [m]; exact outside."""
    return np.min([solid.distance(points) for solid in solids], axis=0)


def moved(motion, body, turn, shift):
    """A motion turned by `turn` (3, 3) about the world's origin, then shifted by `shift` (3,)."""
    rotations = np.array(motion.rotations)
    pelvis = np.asarray(body.rest_joints)[JOINT_INDEX["pelvis"]]
    root = turn @ rot.rotvec_to_matrix(rotations[:, 0])
    rotations[:, 0] = rot.matrix_to_rotvec(root)
    at = (motion.translation + pelvis) @ turn.T + shift
    return motion.with_frames(at - pelvis, rotations)


def without_fingers(motion):
    """The motion of a data set that records no fingers."""
    rotations = np.array(motion.rotations)
    rotations[:, 25:] = 0.0
    return motion.with_frames(motion.translation, rotations)


def shake(rng, low, high, times):
    """A shift that varies slowly (T,) between `low` and `high` [m]."""
    period, phase = rng.uniform(2.0, 4.0), rng.uniform(0.0, 2.0 * np.pi)
    return low + (high - low) * (0.5 + 0.5 * np.sin(2.0 * np.pi * times / period + phase))


def _together(meshes):
    vertices, faces, count = [], [], 0
    for mesh in meshes:
        vertices.append(mesh.vertices)
        faces.append(mesh.faces + count)
        count += len(mesh.vertices)
    return Mesh(np.concatenate(vertices), np.concatenate(faces))

"""Results made by hand: a box of 1 kg at a person's palm, on any path, with chosen contacts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.results.contacts import Contacts
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings

G, MASS = 9.81, 1.0
COM = np.array([0.01, 0.02, 0.03])
NAMES = ("floor", "table", "box", "person")
WRIST = JOINT_INDEX["right_wrist"]


@dataclass
class Handled:
    """The events: rows of contacts are added frame by frame.

    Attributes:
        fps: Frames per second.
        box: Position of its frame (T, 3) [m].
        walk: Position of the person (T, 3) [m]; None: at the origin.
        spin: How far the box and the person have turned about z (T,) [rad]; None: not at all.
        gravity: Its size [m/s^2].
        people: Number of people; the first is called person, the second person1.
    """

    fps: float
    box: np.ndarray
    walk: np.ndarray | None = None
    spin: np.ndarray | None = None
    gravity: float = G
    people: int = 1
    rows: list[tuple] = field(default_factory=list)

    def push(self, frames, up, side=0.0, part=WRIST, at=(0.0, 0.0, 0.0), person=0):
        """A person bears `up` of its weight, and presses with `side` of it, along x."""
        for frame in frames:
            impulse = np.array([side, 0.0, -up]) * MASS * (self.gravity or G) / self.fps
            self.rows.append((frame, person, part, -1, NAMES.index("box"), at, impulse))

    def rest(self, frames, on="floor", up=1.0):
        """The box lies on a support that bears `up` of its weight."""
        for frame in frames:
            impulse = np.array([0.0, 0.0, up]) * MASS * (self.gravity or G) / self.fps
            self.rows.append(
                (frame, -1, -1, NAMES.index("box"), NAMES.index(on), (0, 0, 0), impulse)
            )

    def result(self, turn=0.0, shift=(0.0, 0.0, 0.0)) -> Result:
        """The result, all of it turned about z by `turn` [rad], then shifted [m]."""
        body, count = Body.default(), len(self.box)
        walk = np.zeros((count, 3)) if self.walk is None else self.walk
        spin = np.zeros(count) if self.spin is None else self.spin
        world = rot.exp([0.0, 0.0, turn])
        own = rot.exp(np.stack([np.zeros(count), np.zeros(count), spin], axis=1))
        # A turning person turns about the middle of the box, together with it.
        middle = self.box if spin.any() else np.zeros(3)
        pelvis = rot.rotate(world, middle + rot.rotate(own, walk - middle))
        rotations = np.zeros((count, N_JOINTS, 3))
        upright = rot.multiply(own, rot.exp([np.pi / 2, 0.0, 0.0]))
        rotations[:, 0] = rot.log(rot.multiply(world, upright))
        motion = Motion(pelvis + shift - body.rest_joints[0], rotations, self.fps)
        names = ("person", "person1")[: self.people]
        people = tuple(
            PersonResult(name=name, motion=motion, reference=motion, body=body) for name in names
        )
        scene = Scene(gravity=self.gravity)
        scene.add_static("floor", Plane())
        scene.add_static("table", Box((1.0, 1.0, 0.1)), position=(5.0, 0.0, 0.5))
        scene.add_object("box", Box((0.2, 0.2, 0.2)), mass=MASS, com=COM)
        rows = sorted(self.rows, key=lambda row: row[0])
        frame = np.array([r[0] for r in rows], dtype=np.int64)
        columns = np.array([r[1:5] for r in rows], dtype=np.int64).reshape(-1, 4).T
        at = np.array([r[5] for r in rows], dtype=float).reshape(-1, 3)
        position = self.box[frame] + rot.rotate(own[frame], at)
        # Contact of a person's hand: from the box, along x, into the palm.
        normal = np.where((columns[0] >= 0)[:, None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
        impulse = np.array([r[6] for r in rows], dtype=float).reshape(-1, 3)
        track = ObjectTrack(
            position=rot.rotate(world, self.box) + shift, quaternion=rot.multiply(world, own)
        )
        return Result(
            people=people,
            objects={"box": track},
            scene=scene,
            names=(*NAMES[:-1], *names),
            contacts=Contacts(
                frame=frame,
                person=columns[0],
                part=columns[1],
                subject=columns[2],
                other=columns[3],
                other_part=np.full(len(rows), -1),
                position=rot.rotate(world, position) + shift,
                normal=rot.rotate(world, rot.rotate(own[frame], normal)),
                impulse=rot.rotate(world, impulse),
            ),
            clearance=np.full(count, np.inf),
            lost_time=np.zeros(count),
            settings=Settings(),
        )

"""Measures of a one-hand grasp: slip in the hand, contact forces, fall.

Positions of the glass are in the frame of the right wrist as simulated (`Result.motion`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.results.result import Result

WRIST = JOINT_INDEX["right_wrist"]


@dataclass(frozen=True, eq=False)
class Grasp:
    """A result in which a right hand grasps the object "glass".

    Attributes:
        time: Of the frames (T,) [s].
        place: Glass in the wrist's frame (T, 3) [m].
        turn: Rotation of the glass in the wrist's frame (T, 4), wxyz.
        world: Glass in the world (T, 3) [m].
        centre: Its centre of mass in the world (T, 3) [m].
        normal: Sum of normal forces of the person on the glass, mean over each frame (T,) [N].
        touched: Whether anything touched the glass during the frame before (T,).
    """

    time: np.ndarray
    place: np.ndarray
    turn: np.ndarray
    world: np.ndarray
    centre: np.ndarray
    normal: np.ndarray
    touched: np.ndarray

    def rows(self, begin: float, end: float) -> np.ndarray:
        """Frames from `begin` to `end` [s], both included."""
        return np.flatnonzero((self.time >= begin - 1e-9) & (self.time <= end + 1e-9))

    def slip(self, begin: float, end: float) -> float:
        """Largest displacement of the glass in the hand since `begin` [mm]."""
        place = self.place[self.rows(begin, end)]
        return float(1e3 * np.linalg.norm(place - place[0], axis=1).max())

    def turned(self, begin: float, end: float) -> float:
        """Largest rotation of the glass in the hand since `begin` [degrees]."""
        turn = self.turn[self.rows(begin, end)]
        cosine = np.abs(turn @ turn[0])
        return float(np.degrees(2.0 * np.arccos(np.clip(cosine, 0.0, 1.0))).max())

    def force(self, begin: float, end: float) -> tuple[float, float, float]:
        """Mean, spread (standard deviation over mean) and peak of the normal forces [N]."""
        force = self.normal[self.rows(begin, end)]
        return float(force.mean()), float(force.std() / force.mean()), float(force.max())

    def jitter(self, begin: float, end: float) -> float:
        """Root mean square of the glass's acceleration in the world [m/s^2]."""
        second = np.diff(self.world[self.rows(begin, end)], 2, axis=0) / self.step**2
        return float(np.sqrt((second**2).sum(axis=1).mean()))

    def creep(self, begin: float, end: float) -> float:
        """Drift of the glass in the hand, from begin to end [mm/s]."""
        place = self.place[self.rows(begin, end)]
        return float(1e3 * np.linalg.norm(place[-1] - place[0]) / (end - begin))

    def freed(self, begin: float) -> float:
        """Time from `begin` until nothing touches the glass [s]; inf if that never happens."""
        free = np.flatnonzero((self.time > begin) & ~self.touched)
        return float(self.time[free[0]] - begin) if len(free) else np.inf

    def fall(self, begin: float) -> np.ndarray:
        """Vertical accelerations of its centre of mass once it is free after `begin` (n,) [m/s^2].

        Up to the first touch after that: the frames themselves in which nothing touches.
        """
        at = int(np.argmin(np.abs(self.time - begin - self.freed(begin))))
        again = np.flatnonzero(self.touched[at:])
        end = at + int(again[0]) if len(again) else len(self.time)
        # Free flight starts at the frame before the first free one.
        return np.diff(self.centre[at - 1 : end, 2], 2) / self.step**2

    @property
    def step(self) -> float:
        """Time between frames [s]."""
        return float(self.time[1] - self.time[0])


def judge(result: Result, body: Body) -> Grasp:
    """Measure a result."""
    fps, frames = result.fps, len(result)
    positions, quaternions = body.joint_frames(result.motion)
    away = rot.conjugate(quaternions[:, WRIST])
    glass = result.objects["glass"]
    contacts = result.contacts
    index = result.names.index("glass")
    held = (contacts.other == index) & (contacts.person >= 0)
    pushes = np.sum(contacts.impulse * contacts.normal, axis=1)
    normal = np.bincount(contacts.frame[held], weights=pushes[held], minlength=frames) * fps
    touched = np.zeros(frames, dtype=bool)
    touched[contacts.frame[(contacts.other == index) | (contacts.subject == index)]] = True
    return Grasp(
        np.arange(frames) / fps,
        rot.rotate(away, glass.position - positions[:, WRIST]),
        rot.multiply(away, glass.quaternion),
        glass.position,
        glass.position + rot.rotate(glass.quaternion, result.scene.objects["glass"].com),
        normal,
        touched,
    )

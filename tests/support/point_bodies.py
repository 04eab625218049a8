"""Motions and bodies made of points, for measures that have closed forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Drift:
    """A motion with translation only: frames (T, 3)."""

    translation: np.ndarray
    fps: float = 30.0

    @property
    def rotations(self) -> np.ndarray:
        return np.zeros((len(self.translation), 55, 3))

    def __len__(self) -> int:
        return len(self.translation)

    def __getitem__(self, frames: slice) -> Drift:
        part = self.translation[frames]
        assert len(part) > 1, "real motions have at least two frames"
        return Drift(part, self.fps)


class Cloud:
    """A body of points (V, 3) that follows the translation; its joints are the first 55."""

    def __init__(self, points: np.ndarray) -> None:
        self.points = points

    def vertices(self, motion: Drift) -> np.ndarray:
        return self.points + motion.translation[:, None]

    def joints(self, motion: Drift) -> np.ndarray:
        return self.vertices(motion)[:, :55]


class Ball(Cloud):
    """A cloud with faces between its points."""

    def __init__(self, points: np.ndarray, faces: np.ndarray) -> None:
        super().__init__(points)
        self.faces = faces


@dataclass
class Track:
    position: np.ndarray
    quaternion: np.ndarray

"""For tests of data sets: synthetic movement, smooth, plausible, all joints bent; quiet reading."""

from __future__ import annotations

import warnings

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.simulation.sequence import Sequence

#: An upright body in files with z up is turned by this about x.
UPRIGHT = {"y": np.zeros(3), "z": np.array([np.pi / 2, 0.0, 0.0])}


def movement(frames: int = 12, seed: int = 0, up: str = "z") -> tuple[np.ndarray, np.ndarray]:
    """Translation (T, 3) and rotations (T, 55, 3) of an upright person with all joints moving.

    At a person's speeds up to 120 frames per second.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None] / 60.0
    phase, size = rng.uniform(0, 2 * np.pi, 165), rng.normal(0, 0.3, 165)
    rotations = (size * np.sin(2 * np.pi * t + phase)).reshape(frames, 55, 3)
    lean = rot.multiply(rot.exp(0.5 * rotations[:, 0]), rot.exp(UPRIGHT[up]))
    rotations[:, 0] = rot.log(lean)
    translation = rng.normal(0, 0.2, 3) + 0.3 * np.sin(t * 2 + rng.uniform(0, 6, 3))
    return translation, rotations


def quiet(path, **options) -> Sequence:
    """The result of `load_sequence`, without its warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hp.HalfPhysicsWarning)
        return hp.load_sequence(path, **options)

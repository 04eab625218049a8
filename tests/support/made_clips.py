"""Small motions of formulas, which several test files measure or mend."""

from __future__ import annotations

import numpy as np

import halfphysics as hp

#: Frames of `walk`.
FRAMES = 40


def walk(seed: int = 0) -> hp.Motion:
    """A person who drifts over the floor with noise in all joints."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, FRAMES)
    rotations = 0.1 * np.sin(2 * np.pi * (t[:, None, None] + rng.random((55, 3))))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    translation = np.stack([0.5 * t, 0.1 * t**2, 0.93 + 0.02 * np.sin(9 * t)], axis=1)
    return hp.Motion(translation, rotations, 30.0)


def standing(frames=40, fps=30.0):
    """Somebody who stands, upright, on the floor, with arms a little out."""
    turns = np.zeros((frames, 55, 3))
    turns[:, 0, 0] = np.pi / 2
    turns[:, 16, 2], turns[:, 17, 2] = -0.8, 0.8
    return hp.Motion(np.zeros((frames, 3)), turns, fps).grounded(hp.Body.default(), 0.003)

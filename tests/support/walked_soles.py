"""Soles of somebody who walks on ground of a given shape, without a body."""

from __future__ import annotations

import numpy as np

from halfphysics.repair.ground_fit import STANDS
from halfphysics.repair.soles import Soles

FPS = 30.0


def walked(rise, *, turns=True, noise=0.002, seconds=8.0, seed=0):
    """Soles of somebody who walks a curve (or a line): each foot rests for 0.6 of 1 s in turn.

    `rise`: heights of the ground [m] at places (n, 2) and times (n,).
    """
    random = np.random.default_rng(seed)
    t = np.arange(round(seconds * FPS)) / FPS
    centre, rests = np.zeros((len(t), 4, 3)), np.zeros((len(t), 4), dtype=bool)
    for patch in range(4):
        phase = t + 0.5 * (patch // 2)
        step = np.floor(phase)
        angle = 0.8 * step if turns else 0.0 * step
        centre[:, patch, 0] = np.cos(angle) if turns else 0.7 * step
        centre[:, patch, 1] = np.sin(angle) if turns else 0.1 * (patch // 2)
        centre[:, patch, 0] += 0.2 * (patch % 2)
        rests[:, patch] = phase - step < 0.6
    gap = rise(centre[..., :2].reshape(-1, 2), np.repeat(t, 4)).reshape(-1, 4)
    gap = gap + STANDS + random.normal(0.0, noise, gap.shape)
    gap = gap + 0.2 * ~rests  # feet in the air say nothing
    centre[..., 2] = gap
    return Soles(centre, gap, gap, rests, FPS)

"""A small AMASS file, right or with a mistake in it."""

from __future__ import annotations

import numpy as np

UPRIGHT = [np.pi / 2, 0.0, 0.0]
FRAMES = 12


def write_motion(path, frames=FRAMES, **changes):
    """A T-pose 2 cm above the floor that drifts along x."""
    poses = np.zeros((frames, 165))
    poses[:, :3] = UPRIGHT
    trans = np.zeros((frames, 3))
    trans[:, 0] = 0.01 * np.arange(frames)
    trans[:, 2] = 0.94
    fields = {
        "trans": trans,
        "poses": poses,
        "betas": np.zeros(10),
        "gender": np.array("neutral"),
        "mocap_frame_rate": np.array(30.0),
    }
    fields |= changes
    np.savez(path, **{key: value for key, value in fields.items() if value is not None})
    return path


NAN = np.zeros((FRAMES, 165))
NAN[3, 5] = np.nan

"""AMASS files of upright people, else random, in the layouts of SMPL-X, SMPL-H and SMPL."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from support.files.layouts import UPRIGHT

WIDTHS = {"smplx": 165, "smplh": 156, "smpl": 72}


def fields(model: str = "smplx", frames: int = 12, seed: int = 0, dtype=np.float64) -> dict:
    """A file of the model's layout with random content, no faster than people."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(0, 0.01, (frames, WIDTHS[model]))
    usual = rng.normal(0, 0.5, WIDTHS[model])
    usual[:3] = UPRIGHT["z"] + 0.1 * usual[:3]
    bent = np.array([3 * 4, 3 * 5, 3 * 18 + 1, 3 * 19 + 1])  # knees and elbows, one way only
    usual[bent] = np.abs(usual[bent]) * [1, 1, -1, 1]
    poses = usual + np.cumsum(steps, axis=0)
    out = {
        "trans": np.cumsum(rng.normal(0, 0.02, (frames, 3)), axis=0).astype(dtype),
        "poses": poses.astype(dtype),
        "betas": rng.normal(0, 1, 16),
        "gender": np.array("female"),
    }
    if model == "smplx":
        p = out["poses"]
        out |= {
            "num_betas": np.array(16),
            "surface_model_type": np.array("smplx"),
            "mocap_frame_rate": np.array(120.0),
            "mocap_time_length": np.array(frames / 120.0),
            "root_orient": p[:, :3],
            "pose_body": p[:, 3:66],
            "pose_jaw": p[:, 66:69],
            "pose_eye": p[:, 69:75],
            "pose_hand": p[:, 75:],
            "markers_latent": rng.normal(0, 1, (41, 3)),
        }
    else:
        out |= {"mocap_framerate": np.array(120.0), "dmpls": rng.normal(0, 1, (frames, 8))}
    return out


def write(path: Path, content: dict) -> Path:
    np.savez(path, **content)
    return path


def same(a: Path, b: Path) -> None:
    with np.load(a) as x, np.load(b) as y:
        assert list(x) == list(y)
        for key in x:
            assert x[key].dtype == y[key].dtype, key
            assert np.array_equal(x[key], y[key]), key

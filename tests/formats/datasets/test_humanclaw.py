"""HumanCLAW: trajectories before and after a simulation."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from support.files import recorded_sets as sets
from support.files.wrong_files import broken_bytes_are_refused, changed, put, refused, spoilt

BODY_ONLY, WHOLE = sets.person(7, tuple(range(22))), sets.person(8)


def written(tmp_path, content):
    path = tmp_path / "trajectory_before.npz"
    np.savez(path, **content)
    return path


@pytest.mark.parametrize(("width", "someone"), [(75, BODY_ONLY), (168, WHOLE)])
def test_before(tmp_path, width, someone):
    motion = hp.Motion.load(written(tmp_path, sets.humanclaw_fields(someone, width)))
    assert (motion.fps, motion.model, motion.gender) == (30.0, "smplx", "neutral")
    assert not motion.betas.any()
    assert sets.off(motion, someone) < sets.SINGLE


def test_after(tmp_path):
    trans, r = sets.in_axes(WHOLE, sets.Y_UP)
    content = {
        "transl": trans,
        "global_orient": r[:, 0],
        "body_pose": r[:, 1:],
        "fps": np.array(30.0),
        "step_starts": np.array([0]),
        "object_names": np.array(["table"]),
    }
    motion = hp.Motion.load(written(tmp_path, content), frames=(1, 6))
    assert sets.off(motion, tuple(a[1:6] for a in WHOLE)) < sets.DOUBLE
    content["body_pose"] = content["body_pose"][:, :21]
    refused(written(tmp_path, content), r"'body_pose'.*\(T, 54, 3\)")


WRONG = [
    ("another width", changed("xb_world_75", lambda a: a[:, :72]), r"\(T, 75\) or \(T, 168\)"),
    ("one row", changed("xb_world_75", lambda a: a[0]), r"\(T, 75\) or"),
    ("one frame", changed("xb_world_75", lambda a: a[:1]), "at least 2"),
    ("NaN", spoilt("xb_world_75", (3, 4), np.nan), "NaN.*frame 3"),
    ("no rate", put("fps", np.array(0.0)), "'fps'"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(tmp_path, spoil, message):
    content = sets.humanclaw_fields(BODY_ONLY)
    spoil(content)
    refused(written(tmp_path, content), message)


def test_broken_bytes(tmp_path):
    broken_bytes_are_refused(written(tmp_path, sets.humanclaw_fields(BODY_ONLY)))

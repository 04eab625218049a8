"""Motion-X files: one array (T, 322), y-up."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.motion.skeleton import BODY_JOINTS, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from support.files.layouts import movement
from support.files.wrong_files import broken_bytes_are_refused, refused

ROUNDING = 1e-12


def rows(frames: int = 12) -> np.ndarray:
    translation, r = movement(frames, up="y")
    rng = np.random.default_rng(1)
    blocks = [
        (r[:, 0], 3),
        (r[:, list(BODY_JOINTS)], 63),
        (r[:, list(LEFT_HAND_JOINTS)], 45),
        (r[:, list(RIGHT_HAND_JOINTS)], 45),
        (r[:, 22], 3),
        (rng.normal(size=(frames, 50)), 50),  # expression
        (rng.normal(size=(frames, 100)), 100),  # face shape
        (translation, 3),
        (np.tile(rng.normal(size=10), (frames, 1)), 10),
    ]
    return np.hstack([block.reshape(frames, width) for block, width in blocks])


def saved(path, array):
    np.save(path, array)
    return path


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_read_and_written(tmp_path, dtype):
    path = saved(tmp_path / "a.npy", rows().astype(dtype))
    motion = hp.Motion.load(path)
    assert (motion.fps, motion.model, len(motion.betas)) == (30.0, "smplx", 10)
    translation, rotations = movement(up="y")
    rotations[:, 23:25] = 0.0  # it has no eyes
    body = hp.Body.default()
    asked = body.vertices(hp.Motion(translation, rotations, 30.0)) @ axes_of("y").T
    tolerance = ROUNDING if dtype == np.float64 else 1e-6
    assert np.abs(body.vertices(motion) - asked).max() < tolerance
    motion.save(tmp_path / "b.npy")
    assert np.abs(np.load(tmp_path / "b.npy") - np.load(path)).max() < ROUNDING
    cut = hp.Motion.load(path, frames=(2, 9))
    assert np.abs(cut.translation - motion.translation[2:9]).max() == 0.0


def spoilt(index, value):
    def spoil(array):
        array[index] = value
        return array

    return spoil


WRONG = {
    "no motion": (lambda a: a[:0], "0 frame"),
    "one frame": (lambda a: a[:1], "1 frame"),
    "NaN": (spoilt((3, 0), np.nan), "NaN.*frame 3"),
    "infinite": (spoilt((4, 310), np.inf), "infinite.*frame 4"),
    "321 columns": (lambda a: a[:, :-1], "no known motion format.*321"),
    "323 columns": (lambda a: np.hstack([a, a[:, :1]]), "no known motion format.*323"),
    "transposed": (lambda a: a.T, "no known motion format"),
    "flat": (lambda a: a.reshape(-1), "no known motion format"),
    "three axes": (lambda a: a[None], "no known motion format"),
    "text": (lambda a: a.astype(str), "expected numbers"),
    "complex": (lambda a: a.astype(complex), "expected numbers"),
    "true and false": (lambda a: a > 0, "expected numbers"),
    "shape that varies": (spoilt((5, 315), 9.0), "betas.*changes"),
    "a jump": (spoilt((6, 309), 1e4), "m/s between frames . and"),
    "objects": (lambda a: np.array([a, None], dtype=object), "no known motion format"),
    "one number": (lambda a: np.array(3.0), "no known motion format"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files(tmp_path, name):
    spoil, message = WRONG[name]
    path = tmp_path / "bad.npy"
    np.save(path, spoil(rows()), allow_pickle=True)
    refused(path, message)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"clip": "a"}, "holds one motion only"),
        ({"fps": -30.0}, "positive"),
        ({"gender": "none"}, "expected one of neutral"),
        ({"hands": "mean"}, "need the body-model file"),
        ({"frames": (5, 5)}, r"found 5:5, but .* has \d+ frames"),
    ],
)
def test_wrong_options(tmp_path, options, message):
    path = saved(tmp_path / "a.npy", rows())
    with pytest.raises(hp.HalfPhysicsError, match=message):
        hp.Motion.load(path, **options)


def test_broken_bytes(tmp_path):
    broken_bytes_are_refused(saved(tmp_path / "a.npy", rows()))


def test_another_axis_up_is_noticed(tmp_path):
    from halfphysics.errors import HalfPhysicsWarning

    array = rows()
    array[:, :3] = movement(up="z")[1][:, 0]
    path = saved(tmp_path / "a.npy", array)
    with pytest.warns(HalfPhysicsWarning, match="say up='z'"):
        hp.Motion.load(path)
    assert np.array_equal(hp.Motion.load(path, up="z").axes, np.eye(3))

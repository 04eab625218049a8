"""Round trips: a corrected motion in every format of the registry that writes.

The same vertices to a micrometre; or the format names its losses, and the rest is the same.
"""

from __future__ import annotations

import re
import warnings
from functools import cache

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, HalfPhysicsWarning
from halfphysics.formats import FORMATS, losses
from halfphysics.motion import skeleton
from support.files.layouts import movement

#: Vertices [m] of a motion that was written and read.
SAME = 1e-6
#: The pelvis [m] of a body whose shape was guessed from its joints.
GUESSED = 1e-4
#: Joints [m] of a motion that was written as their positions and found by inverse kinematics.
MET = 5e-3
#: Joints that a line of `losses` concerns; a line that matches none concerns no joint.
HANDS = (*skeleton.LEFT_HAND_JOINTS, *skeleton.RIGHT_HAND_JOINTS)
GROUPS = {"the fingers": HANDS, "jaw and eyes": skeleton.FACE_JOINTS}

WRITERS = [name for name, format in FORMATS.items() if format.save is not None]


@cache
def corrected(model: str) -> hp.Motion:
    """A motion that was stopped by a wall, with rotations of all joints."""
    translation, rotations = movement(20)
    asked = hp.Motion(
        translation + np.linspace([0, 0, 0], [1.0, 0, 0], 20), rotations, 30.0,
        betas=np.linspace(-0.5, 0.5, 10), gender="female", model=model,
    )  # fmt: skip
    body, scene = hp.Body.default(), hp.Scene()
    reach = body.vertices(asked)[..., 0].max(axis=1)
    assert reach.max() > reach[0] + 0.1
    scene.add_static("wall", hp.Plane((-1.0, 0.0, 0.0), -(reach[0] + 0.02)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)  # betas of another model
        motion = hp.simulate(asked, scene).motion
    assert np.abs(body.vertices(motion) - body.vertices(asked)).max() > 0.05
    return motion


def read(path, motion: hp.Motion, lost: list[str]) -> hp.Motion:
    """The file, read with the option that its message requests."""
    options: dict = {"fps": motion.fps} if any("frame rate" in line for line in lost) else {}
    known = {"hands": "flat", "fps": motion.fps, "model": motion.model, "gender": motion.gender}
    while True:
        try:
            return hp.Motion.load(path, **options)
        except FileError as error:
            asked = [o for o in known if o not in options and f"{o}=" in str(error)]
            if not asked:
                raise
            options[asked[0]] = known[asked[0]]


def without(motion: hp.Motion, lost: list[str]) -> hp.Motion:
    """The motion with the rotations that `lost` names at zero."""
    rotations = motion.rotations.copy()
    for line in lost:
        joints = [j for group, members in GROUPS.items() if group in line for j in members]
        named = re.match(r"rotations of (.*)", line)
        if named:
            joints += [skeleton.JOINT_INDEX[name] for name in named[1].split(", ")]
        rotations[:, joints] = 0.0
    return motion.with_frames(motion.translation, rotations)


def apart(found: np.ndarray, asked: np.ndarray, *, guessed: bool) -> float:
    """How far vertices are from where they should be [m].

    Without the shape, the reader guesses the body, and the pelvis is only as accurate as that
    guess: one small shift of the whole clip.
    """
    shift = (found - asked).mean(axis=(0, 1)) if guessed else np.zeros(3)
    assert np.abs(shift).max() < GUESSED
    return float(np.abs(found - asked - shift).max())


def joints(body: hp.Body, motion: hp.Motion) -> np.ndarray:
    """SMPL's first 22 joints (T, 22, 3), which files of positions have."""
    return body.joints(motion)[:, : len(skeleton.SMPL_JOINTS)]


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
@pytest.mark.parametrize("model", ["smplx", "smplh", "smpl"])
@pytest.mark.parametrize("name", WRITERS)
def test_what_goes_out_comes_back(tmp_path, name, model):
    motion, body = corrected(model), hp.Body.default()
    path = tmp_path / f"a{FORMATS[name].suffixes[0]}"
    motion.save(path, format=name, body=body)
    lost = losses(motion, path, name)
    back = read(path, motion, lost)
    assert back.fps == motion.fps
    assert len(back) == len(motion)
    if any("turns of bones" in line for line in lost):
        assert np.abs(joints(body, back) - joints(body, motion)).max() < MET
        return
    asked = body.vertices(without(motion, lost))
    shape = any("shape" in line for line in lost)
    assert apart(body.vertices(back), asked, guessed=shape) < SAME, lost
    assert shape or np.abs(back.betas[:10] - motion.betas).max() < SAME
    assert shape or not back.betas[10:].any()
    assert any("gender" in line for line in lost) or back.gender == motion.gender
    assert any("model" in line for line in lost) or shape or back.model == motion.model
    # Written again in the format that it was read from: nothing more is lost.
    again = tmp_path / f"b{path.suffix}"
    back.save(again, body=body)
    twice = body.vertices(read(again, motion, lost))
    assert apart(twice, body.vertices(back), guessed=shape) < SAME


def test_every_loss_is_in_words():
    for name in WRITERS:
        for model in ("smplx", "smplh", "smpl"):
            for line in losses(corrected(model), "a", name):
                assert line
                assert "\n" not in line

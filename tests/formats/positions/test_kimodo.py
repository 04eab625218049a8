"""Kimodo's own npz: SMPL-X by rotations, on the bones of its joints; SOMA put on the default body.

The truth of SOMA's is the default body's own skeleton under SOMA's names, and Kimodo's BVH.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats.skeletons.soma import SOMA
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS
from support.files.layouts import movement, quiet
from support.files.position_files import STRANGER, matrices, places
from support.files.soma_files import (
    THIRTY,
    Clip,
    kimodo,
    kimodo_bvh,
    kimodo_fields,
    of_default_body,
)
from support.files.wrong_axes import heights, turned, walker
from support.files.wrong_files import changed, put, refused, spoilt, without

ROUNDING = 1e-5  # metres, of single precision
FRAMES = 24
PELVIS = np.array([0.0, 0.9, 0.0])
EYES = [JOINT_INDEX["left_eye_smplhf"], JOINT_INDEX["right_eye_smplhf"]]


def truth():
    translation, rotations = movement(FRAMES, up="y")
    rotations = np.array(rotations)
    rotations[:, 22:] = 0.0
    return translation + PELVIS, rotations


def fields():
    pelvis, rotations = truth()
    local = matrices(rotations[:, :22]).astype(np.float32)
    return {
        "posed_joints": places(rotations, pelvis, STRANGER).astype(np.float32),
        "local_rot_mats": local,
        "global_rot_mats": local,
        "foot_contacts": np.ones((FRAMES, 4)),
        "smooth_root_pos": pelvis,
        "root_positions": pelvis,
        "global_root_heading": np.ones((FRAMES, 2)),
    }


def written(path, content):
    np.savez(path, **content)
    return path


def test_joints_and_rotations_are_the_files(tmp_path):
    path = written(tmp_path / "a.npz", fields())
    sequence = quiet(path)
    pelvis, rotations = truth()
    expected = places(rotations, pelvis, STRANGER)
    expected = np.stack([expected[..., 0], -expected[..., 2], expected[..., 1]], axis=-1)
    own = sequence.bodies[0].joints(sequence.motion)[:, :22]
    assert np.abs(own - expected).max() < ROUNDING
    assert np.abs(sequence.motion.rotations[:, 1:] - rotations[:, 1:]).max() < 1e-5
    assert sequence.motion.fps == 30.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = hp.Motion.load(path)
    places_of_pelvis = hp.Body.default().joints(motion)[:, 0]
    assert np.abs(places_of_pelvis - expected[:, 0]).max() < ROUNDING


@pytest.mark.parametrize("left_out", ["local_rot_mats", "global_rot_mats"])
def test_either_kind_of_rotations_does(tmp_path, left_out):
    content = fields()
    _, rotations = truth()
    content["global_rot_mats"] = global_of(rotations).astype(np.float32)
    del content[left_out]
    motion = quiet(written(tmp_path / "a.npz", content)).motion
    assert np.abs(motion.rotations[:, 1:] - rotations[:, 1:]).max() < 1e-5


def global_of(rotations):
    """World matrices (T, 22, 3, 3) of SMPL-X's first joints."""
    world = np.array(matrices(rotations[:, :22]))
    for joint in range(1, 22):
        world[:, joint] = world[:, PARENTS[joint]] @ world[:, joint]
    return world


# -- SOMA ---------------------------------------------------------------------------------------


def parameters(fingers=True):
    """Translation and rotations of all joints that SOMA has, eyes at rest; y up."""
    translation, rotations = movement(FRAMES, seed=3, up="y")
    rotations = np.array(rotations)
    rotations[:, EYES] = 0.0
    if not fingers:
        rotations[:, 25:] = 0.0
    return translation + PELVIS, rotations


@pytest.mark.parametrize("kept", [None, THIRTY])
def test_soma_is_the_default_body_where_its_bones_are(tmp_path, kept):
    translation, rotations = parameters(fingers=kept is None)
    path = kimodo(tmp_path / "a.npz", of_default_body(translation, rotations), kept)
    with pytest.warns(HalfPhysicsWarning, match="SOMA skeleton.*the rate .30 fps") as said:
        sequence = hp.load_sequence(path)
    assert len(said) == 1
    motion = sequence.motion
    assert np.abs(motion.rotations[:, 1:] - rotations[:, 1:]).max() < 1e-5
    own = hp.Body.default().joints(motion)
    expected = hp.Body.default().joints(hp.Motion(translation, rotations, 30.0))
    assert np.abs(own - expected @ axes_of("y").T).max() < ROUNDING
    assert motion.fps == 30.0
    invented = set(motion.origin.fields["invented"])
    assert invented == {"betas", "fps"} | ({"hands"} if kept else set())
    part = quiet(path, frames=(4, 12)).motion
    # Bones are medians over the frames read: equal but for single precision.
    assert np.abs(part.rotations - motion.rotations[4:12]).max() < 1e-5


def test_soma_as_npz_and_as_bvh_is_one_motion(tmp_path):
    """Of a stranger's bones, and of somebody on the ground, whose hips are under their offset."""
    translation, rotations = parameters()
    for up, low in ((0.0, False), (-0.8, True)):
        clip = of_default_body(translation + np.array([0.0, up, 0.0]), rotations)
        assert (clip.hips[:, 1].max() < 0.5) == low
        clip = Clip(1.1 * SOMA[77].offsets, clip.hips, clip.local)
        own = quiet(kimodo(tmp_path / "a.npz", clip)).motion
        other = quiet(kimodo_bvh(tmp_path / "a.bvh", clip)).motion
        assert np.abs(own.rotations - other.rotations).max() < 1e-5
        assert np.abs(own.translation - other.translation).max() < ROUNDING
        assert own.fps == pytest.approx(other.fps)


def test_the_rate_of_the_file_or_of_the_caller(tmp_path):
    content = kimodo_fields(of_default_body(*parameters()))
    content["fps"] = np.array(25)
    path = written(tmp_path / "a.npz", content)
    motion = quiet(path).motion
    assert motion.fps == 25.0
    assert "fps" not in motion.origin.fields["invented"]
    assert quiet(path, fps=50.0).motion.fps == 50.0


def of_walker(motion, up="y"):
    moved = turned(motion, up)
    return of_default_body(moved.translation, moved.rotations)


def told(path):
    """The motion and all that was said of it."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        motion = hp.Motion.load(path)
    return motion, " | ".join(str(each.message) for each in said)


def test_soma_turned_and_mirrored_is_told(tmp_path):
    truth = heights(walker())
    upright = quiet(kimodo(tmp_path / "a.npz", of_walker(walker()))).motion
    assert np.abs(heights(upright) - truth).max() < ROUNDING
    for up in ("z", "-y"):
        path = kimodo(tmp_path / "b.npz", of_walker(walker(), up))
        motion, text = told(path)
        assert f"read with {up} up" in text
        assert np.abs(heights(motion) - truth).max() < ROUNDING
    flipped = kimodo_fields(of_walker(walker()))
    flip = np.diag([-1.0, 1.0, 1.0]).astype(np.float32)
    flipped["posed_joints"] = flipped["posed_joints"] @ flip
    flipped["local_rot_mats"] = flip @ flipped["local_rot_mats"] @ flip
    motion, text = told(written(tmp_path / "c.npz", flipped))
    assert "mirror image, x negated" in text
    assert np.abs(motion.rotations - upright.rotations).max() < 1e-5
    assert np.abs(motion.translation - upright.translation).max() < ROUNDING


SOMA_FAULTS = [
    (changed("posed_joints", lambda a: a[:, :76]), r"'posed_joints'.*76.*\(T, 77, 3\)"),
    (changed("posed_joints", lambda a: a[:, :34]), "robot Unitree G1.*SOMA or SMPL-X model"),
    (changed("posed_joints", lambda a: a[:, :30]), "'local_rot_mats'.*expected"),
    (changed("posed_joints", lambda a: a[:, ::-1]), "'posed_joints'.*disagree"),
    (changed("posed_joints", lambda a: a[None]), "'posed_joints'.*expected"),
    (changed("posed_joints", lambda a: a[:9]), "different length"),
    (changed("posed_joints", lambda a: a.astype(str)), "'posed_joints'.*expected"),
    (changed("local_rot_mats", lambda a: np.swapaxes(a, -1, -2)), "'posed_joints'.*disagree"),
    (changed("local_rot_mats", lambda a: a[..., :2]), "'local_rot_mats'.*expected"),
    (changed("local_rot_mats", lambda a: 1.1 * a), "no rotations"),
    (spoilt("local_rot_mats", (3, 1, 1, 1), np.inf), "'local_rot_mats'.*infinite.*frame 3"),
    (lambda f: f.update({key: f[key][:1] for key in f}), "'posed_joints'.*1 frames.*at least 2"),
    (lambda f: f.update({key: f[key][:0] for key in f}), "'posed_joints'.*0 frames.*at least 2"),
    (put("fps", np.array(-30)), "'fps'.*expected"),
    (put("fps", np.array([30, 30])), "'fps'.*expected"),
]


@pytest.mark.parametrize(("spoil", "message"), SOMA_FAULTS)
def test_wrong_files_of_soma(tmp_path, spoil, message):
    content = kimodo_fields(of_default_body(*parameters()))
    spoil(content)
    refused(written(tmp_path / "a.npz", content), message)


def test_bones_without_length_are_nobodys(tmp_path):
    content = kimodo_fields(of_default_body(*parameters()))
    content["posed_joints"][:] = 0.0
    refused(written(tmp_path / "a.npz", content), "no length")


def joints(count):
    def change(content):
        content["posed_joints"] = np.zeros((FRAMES, count, 3))
        content["local_rot_mats"] = np.zeros((FRAMES, count, 3, 3))

    return change


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (without("posed_joints"), "no known motion format"),
        (joints(77), "'local_rot_mats'.*no rotations"),
        (joints(30), "'local_rot_mats'.*no rotations"),
        (joints(34), "Unitree G1"),
        (joints(5), "'posed_joints'.*expected"),
        (changed("local_rot_mats", lambda a: a[:, :21]), "'local_rot_mats'.*expected"),
        (changed("local_rot_mats", lambda a: 2.0 * a), "no rotations"),
        (changed("local_rot_mats", lambda a: -a), "no rotations"),
        (changed("local_rot_mats", lambda a: a[::-1]), "disagree"),
        (changed("posed_joints", lambda a: a[:9]), "different length"),
        (spoilt("posed_joints", (2, 1, 1), np.nan), "'posed_joints'.*NaN.*frame 2"),
    ],
)
def test_wrong_files(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path / "a.npz", content), message)

"""Joint positions in npy files: all layouts, clips, units; what is no person is refused."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.formats.positions.layouts import LAYOUTS
from halfphysics.motion.skeleton import BODY_JOINTS, JOINT_INDEX
from support.files.layouts import movement, quiet
from support.files.position_files import STRANGER, offsets, places, y_up
from support.files.wrong_files import broken_bytes_are_refused, refused

MET = 2e-3  # metres, mean over joints and frames
MET_HAND = 4e-3
FOREIGN = 0.0275  # metres, on the default body: its hips are 7 cm from a stranger's, its hands 1
REST = np.asarray(hp.Body.default().rest_joints)
FRAMES = 40
PELVIS = np.array([0.0, 0.9, 0.0])


def truth(seed=0, bones=None, frames=FRAMES, fingers=False):
    """Positions (T, J, 3), y up, of a movement with all joints bent."""
    translation, rotations = movement(frames, seed, up="y")
    rotations = np.array(rotations)
    if not fingers:
        rotations[:, 22:] = 0.0
    return places(rotations, translation + PELVIS, offsets(REST) if bones is None else bones)


def z_up(points):
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def written(path, positions):
    np.save(path, positions.astype(np.float32))
    return path


def errors(sequence, positions):
    own = sequence.bodies[0].joints(sequence.motion)[:, : positions.shape[1]]
    return np.linalg.norm(own - z_up(positions), axis=2)


def test_the_helper_turns_back():
    points = truth()
    assert np.abs(y_up(z_up(points)) - points).max() == 0.0


def test_twenty_two_joints_of_the_default_body(tmp_path):
    positions = truth()[:, :22]
    path = written(tmp_path / "a.npy", positions)
    with pytest.warns(hp.HalfPhysicsWarning, match="20 fps") as told:
        motion = hp.Motion.load(path)
    assert len(told) == 1
    assert motion.fps == 20.0
    assert motion.model == "smplx"
    assert motion.betas is None
    off = np.linalg.norm(hp.Body.default().joints(motion)[:, :22] - z_up(positions), axis=2)
    assert off.mean() < MET
    assert {"rotations", "hands", "betas", "fps"} == set(motion.origin.fields["invented"])
    assert quiet(path).bodies[0] is hp.Body.default()
    assert quiet(path, fps=25.0).motion.fps == 25.0
    assert len(quiet(path, frames=(5, 15)).motion) == 10


def test_a_strangers_skeleton_on_their_bones_and_on_the_default_body(tmp_path):
    positions = truth(bones=STRANGER)
    path = written(tmp_path / "a.npy", positions)
    sequence = quiet(path)
    assert errors(sequence, positions).mean() < MET
    assert abs(sequence.bodies[0].stature - 1.68) < 0.03
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = hp.Motion.load(path)
    off = np.linalg.norm(hp.Body.default().joints(motion)[:, :22] - z_up(positions), axis=2)
    assert off.mean() < FOREIGN
    hands = [JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"]]
    assert off[:, hands].mean() < 0.02


def test_a_child_is_scaled_to_the_default_body(tmp_path):
    positions = truth()[:, :22]
    path = written(tmp_path / "a.npy", 0.6 * positions)
    with pytest.warns(hp.HalfPhysicsWarning, match=r"scaled by 1\.667"):
        motion = hp.Motion.load(path)
    off = np.linalg.norm(hp.Body.default().joints(motion)[:, :22] - z_up(positions), axis=2)
    assert off.mean() < MET
    sequence = quiet(path)
    assert errors(sequence, 0.6 * positions).mean() < MET
    assert abs(sequence.bodies[0].stature - 0.6 * hp.Body.default().stature) < 0.02


def test_units(tmp_path):
    positions = truth()[:, :22]
    for factor, name in ((100.0, "cm"), (1000.0, "mm")):
        path = written(tmp_path / f"{name}.npy", factor * positions)
        with pytest.warns(hp.HalfPhysicsWarning, match=f"unit {name}"):
            sequence = hp.load_sequence(path)
        assert errors(sequence, positions).mean() < MET


def test_a_mirror_image_is_told(tmp_path):
    """Of a left-handed world: x comes back negated, and knees bend as people's do."""
    positions = truth()[:, :22]
    path = written(tmp_path / "a.npy", positions * [-1.0, 1.0, 1.0])
    with pytest.warns(hp.HalfPhysicsWarning, match="mirror image"):
        sequence = hp.load_sequence(path)
    assert errors(sequence, positions).mean() < MET


def test_another_axis_up_is_told(tmp_path):
    positions = truth()[:, :22]
    path = written(tmp_path / "a.npy", z_up(positions))
    with pytest.warns(hp.HalfPhysicsWarning, match="along z"):
        hp.load_sequence(path)
    assert errors(quiet(path, up="z"), positions).mean() < MET


def test_smpls_palms_turn_the_wrists(tmp_path):
    full = truth()
    palms = []
    for side in ("left", "right"):
        wrist, knuckle = (full[:, JOINT_INDEX[f"{side}_{j}"]] for j in ("wrist", "middle1"))
        palms.append(wrist + 0.8 * (knuckle - wrist))
    positions = np.concatenate([full[:, :22], np.stack(palms, axis=1)], axis=1)
    sequence = quiet(written(tmp_path / "a.npy", positions))
    assert errors(sequence, positions[:, :22]).mean() < MET
    middles = [JOINT_INDEX["left_middle1"], JOINT_INDEX["right_middle1"]]
    own = sequence.bodies[0].joints(sequence.motion)[:, middles]
    assert np.linalg.norm(own - z_up(full[:, middles]), axis=2).max() < 0.01
    assert np.abs(sequence.motion.rotations[:, JOINT_INDEX["left_wrist"]]).max() > 0.1


def test_fingers(tmp_path):
    full = truth(fingers=True)
    for count in (52, 55):
        columns = list(LAYOUTS[count])
        sequence = quiet(written(tmp_path / f"{count}.npy", full[:, columns]))
        off = errors(sequence, full)
        assert off[:, :22].mean() < MET
        assert off[:, 25:].mean() < MET_HAND
        assert "hands" not in sequence.motion.origin.fields["invented"]


def test_kit(tmp_path):
    """KIT's 21 joints: no upper spine, no collars; its feet have a joint more."""
    full = truth()
    positions = np.zeros((FRAMES, 21, 3))
    for column, joint in enumerate(LAYOUTS[21]):
        positions[:, column] = full[:, joint if joint >= 0 else 0]
    for ankle, middle in ((13, 14), (18, 19)):
        positions[:, middle] = 0.5 * (positions[:, ankle] + positions[:, middle + 1])
    sequence = quiet(written(tmp_path / "a.npy", 1000.0 * positions))
    assert sequence.motion.fps == 12.5
    given = [joint for joint in LAYOUTS[21] if joint >= 0]
    assert sorted({*given, 9, 13, 14} - {0}) == list(BODY_JOINTS)
    # The chest is placed by neck and shoulders, whose collars move: a centimetre.
    assert errors(sequence, full)[:, given].mean() < 0.01


def test_several_clips(tmp_path):
    one, other = truth(0)[:, :22], truth(1)[:, :22]
    path = written(tmp_path / "a.npy", np.stack([one, other]))
    clips = list(hp.clips(path))
    assert [clip.name for clip in clips] == ["0", "1"]
    for clip, positions in zip(clips, (one, other), strict=True):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert errors(clip.load(), positions).mean() < MET
    with pytest.raises(hp.HalfPhysicsError, match="holds several clips"):
        hp.Motion.load(path)


def test_a_folder_of_a_generator_is_a_library(tmp_path):
    """MoMask: joints/<k>/sample*_repeat*_len*.npy."""
    for k in range(2):
        (tmp_path / "joints" / str(k)).mkdir(parents=True)
        written(tmp_path / "joints" / str(k) / f"sample{k}_repeat0_len40.npy", truth(k)[:, :22])
    assert [clip.format for clip in hp.clips(tmp_path)] == ["joints", "joints"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda p: p[:1], "expected at least 2"),
        (lambda p: p[:0], "expected at least 2"),
        (lambda p: np.where(np.arange(22)[:, None] == 7, np.nan, p), "NaN.*frame 0"),
        (lambda p: 30.0 * p, "no joint positions of a person: found legs"),
        (lambda p: 0.0 * p, "no joint positions of a person: found legs"),
        (lambda p: p[:, np.random.default_rng(0).permutation(22)], "no joint positions"),
        (lambda p: np.random.default_rng(0).normal(0.0, 0.4, p.shape), "no joint positions"),
        (lambda p: p[:, :20], "no known motion format"),
        (lambda p: p[..., :2], "no known motion format"),
    ],
)
def test_wrong_files(tmp_path, change, message):
    refused(written(tmp_path / "a.npy", change(truth()[:, :22])), message)


def test_broken_bytes(tmp_path):
    broken_bytes_are_refused(written(tmp_path / "a.npy", truth(frames=6)[:, :22]))

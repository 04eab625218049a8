"""Motion: validation, slicing, resampling, the smplx package's names."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.motion.motion import Motion, Pose
from halfphysics.motion.resampling import sample_positions

# Rounding of a rotation through quaternions and back.
ROUNDING = 1e-12


def random_motion(frames: int = 20, fps: float = 30.0, seed: int = 0, **options) -> Motion:
    rng = np.random.default_rng(seed)
    translation = np.cumsum(rng.normal(0.0, 0.02, (frames, 3)), axis=0)
    rotations = np.cumsum(rng.normal(0.0, 0.1, (frames, 55, 3)), axis=0)
    return Motion(translation, rotations, fps, **options)


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles [rad] between rotations given as axis-angle (..., 3)."""
    return np.linalg.norm(rot.log(rot.multiply(rot.conjugate(rot.exp(a)), rot.exp(b))), axis=-1)


# -- construction --------------------------------------------------------------------------


def test_arrays_are_read_only_copies():
    translation, rotations = np.zeros((2, 3)), np.zeros((2, 55, 3))
    motion = Motion(translation, rotations, 30, betas=[1, 2])
    translation[0, 0] = 5.0
    assert motion.translation[0, 0] == 0.0
    for array in (motion.translation, motion.rotations, motion.betas, motion.axes, motion.poses):
        assert array.dtype == np.float64
        with pytest.raises(ValueError):
            array[...] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        motion.fps = 10.0
    assert isinstance(motion.fps, float)
    assert len(motion) == 2
    assert motion.poses.shape == (2, 165)


def test_poses_columns_are_accepted():
    motion = random_motion()
    again = Motion(motion.translation, motion.poses, motion.fps)
    assert np.array_equal(again.rotations, motion.rotations)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"translation": np.zeros((3, 2))},
            r"translation: found shape \(3, 2\), expected \(T, 3\)",
        ),
        ({"rotations": np.zeros((3, 52, 3))}, r"rotations: found shape \(3, 52, 3\), expected"),
        ({"rotations": np.zeros((4, 55, 3))}, "rotations: found 4 frames but translation has 3"),
        ({"translation": np.full((3, 3), np.nan)}, "translation: 9 values are NaN or infinite"),
        ({"rotations": np.full((3, 55, 3), np.inf)}, "rotations: 495 values are NaN or infinite"),
        ({"translation": "abc"}, "translation: not an array of numbers"),
        ({"translation": 10**400}, "translation: not an array of numbers"),
        ({"rotations": [[1.0], [1.0, 2.0]]}, "rotations: not an array of numbers"),
        ({"fps": 0}, "fps: found 0, expected a positive number"),
        ({"fps": float("nan")}, "fps: found nan"),
        ({"fps": "fast"}, "fps: found 'fast'"),
        ({"fps": None}, "fps: found None"),
        ({"fps": True}, "fps: found True"),
        ({"fps": "30"}, "fps: found '30', expected a positive number"),
        ({"betas": np.zeros((3, 10))}, r"betas: found shape \(3, 10\), expected a vector"),
        ({"gender": "other"}, "gender: found 'other', expected one of neutral, male, female"),
        ({"model": "star"}, "model: found 'star', expected one of smplx, smplh, smpl"),
        ({"gender": np.zeros(2)}, "gender: found array.* expected one of neutral, male, female"),
        ({"origin": "clip.npz"}, "origin: found 'clip.npz', expected None"),
        ({"holds": 3}, "holds: found 3, expected a tuple of AdaptedHold"),
        ({"axes": np.diag([1.0, 1.0, -1.0])}, "axes: found .* expected a rotation"),
        (
            {"translation": [[0, 0, 0], [1000, 0, 0], [0, 0, 0]]},
            "moves at 3e\\+04 m/s between frames 0",
        ),
    ],
)
def test_impossible_values_are_named(change, message):
    good = {"translation": np.zeros((3, 3)), "rotations": np.zeros((3, 55, 3)), "fps": 30.0}
    with pytest.raises(InputError, match=message):
        Motion(**(good | change))


def test_one_frame_is_no_motion():
    with pytest.raises(InputError, match=r"found 1 frame.*at least 2"):
        Motion(np.zeros((1, 3)), np.zeros((1, 55, 3)), 30)


# -- indexing ------------------------------------------------------------------------------


def test_indexing():
    motion = random_motion()
    pose = motion[-1]
    assert isinstance(pose, Pose)
    assert np.array_equal(pose.rotations, motion.rotations[-1])
    assert np.array_equal(pose.axes, motion.axes)
    part = motion[5:12]
    assert isinstance(part, Motion)
    assert len(part) == 7
    assert part.fps == 30.0
    assert np.array_equal(part.translation, motion.translation[5:12])
    assert motion[::3].fps == 10.0  # a step keeps real time
    with pytest.raises(IndexError):
        motion[20]
    with pytest.raises(InputError, match="found 1 frame"):
        motion[3:4]
    assert len(list(motion)) == 20


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"translation": None}, "translation: not an array of numbers|found shape"),
        ({"translation": [[0.0], [0.0, 0.0]]}, "translation: not an array of numbers"),
        ({"fps": np.zeros(2)}, "fps: found array"),
    ],
)
def test_other_frames_are_checked(change, message):
    motion = random_motion()
    good = {"translation": motion.translation, "rotations": motion.rotations}
    with pytest.raises(InputError, match=message):
        motion.with_frames(**(good | change))


def test_pose_shape_is_checked():
    with pytest.raises(InputError, match=r"rotations: found shape \(52, 3\)"):
        Pose(np.zeros(3), np.zeros((52, 3)))


# -- resampling ----------------------------------------------------------------------------


@pytest.mark.parametrize(("fps", "factor"), [(30.0, 2), (25.0, 4), (30000 / 1001, 2), (120.0, 3)])
def test_up_and_down_again_is_exact(fps, factor):
    motion = random_motion(41, fps, betas=np.ones(3), gender="female")
    up = motion.resample(fps * factor)
    assert len(up) == 40 * factor + 1
    assert np.array_equal(up.rotations[::factor], motion.rotations)
    down = up.resample(fps)
    assert np.array_equal(down.translation, motion.translation)
    assert np.array_equal(down.rotations, motion.rotations)
    assert down.gender == "female"
    assert np.array_equal(down.betas, motion.betas)


def test_resampling_is_slerp_at_constant_rate():
    half_turn = np.zeros((2, 55, 3))
    half_turn[1] = [0.0, 0.0, np.pi]  # an exact half turn: no shortest arc, but a constant rate
    motion = Motion([[0, 0, 0], [1, 2, 3]], half_turn, 10.0).resample(80.0)
    steps = angle_between(motion.rotations[:-1], motion.rotations[1:])
    assert np.allclose(steps, np.pi / 8, atol=ROUNDING)
    assert np.allclose(np.diff(motion.translation, axis=0), [1 / 8, 2 / 8, 3 / 8])


def test_resampling_takes_the_short_way_over_a_flip_of_sign():
    # 190 degrees about z is -170: the same rotation, written with the other sign.
    rotations = np.zeros((2, 55, 3))
    rotations[0, :, 2] = np.radians(175.0)
    rotations[1, :, 2] = np.radians(-175.0)
    middle = Motion(np.zeros((2, 3)), rotations, 10.0).resample(20.0).rotations[1]
    assert np.allclose(angle_between(middle, np.array([0.0, 0.0, np.pi])), 0.0, atol=ROUNDING)


def test_resampling_keeps_to_the_clip():
    motion = random_motion(10, 30.0)  # 0.3 s
    for fps in (7.0, 24.0, 29.97, 31.0, 100.0):
        again = motion.resample(fps)
        assert again.fps == fps
        assert again.duration <= motion.duration + 1e-9
        assert again.duration > motion.duration - 1.0 / fps
        assert np.array_equal(again.translation[0], motion.translation[0])
    with pytest.raises(InputError, match="leaves one frame"):
        motion.resample(2.0)
    with pytest.raises(InputError, match="expected a positive number"):
        motion.resample(0.0)


@pytest.mark.parametrize(
    ("said", "rate"), [(23.976, 24.0), (29.97, 30.0), (59.94, 60.0), (119.88, 120.0)]
)
@pytest.mark.parametrize("part", [1, 2])
def test_rates_of_television_lose_no_frame(said, rate, part):
    """As they are said, of clips at their own rate, and of those at a multiple."""
    motion = random_motion(125, part * rate / 1.001)
    again = motion.resample(said)
    assert len(again) == (len(motion) - 1) // part + 1
    # Times drift by a millionth of a frame for each frame.
    step = np.abs(np.diff(motion.translation, axis=0)).max()
    assert np.abs(again.translation - motion.translation[::part]).max() < 125 * 2e-6 * step
    for other in (0.998 * rate, 1.003 * rate):
        assert motion.resample(other).duration <= motion.duration + 1e-9


@pytest.mark.parametrize(("fps", "new_fps"), [(30.0, 29.97), (29.97, 30.0), (24.0, 30.0)])
def test_no_sample_of_another_rate_is_after_the_last_frame(fps, new_fps):
    """Of long clips too: every sample is at its time, and none that the clip has is left out."""
    for frames in range(10_000, 11_002):
        position = sample_positions(frames, fps, new_fps)
        # A sample 1e-6 frames after the last frame is that frame.
        np.testing.assert_allclose(
            position[-2:], np.arange(len(position))[-2:] * fps / new_fps, rtol=0.0, atol=1.1e-6
        )
        assert position[-1] + fps / new_fps > frames - 1


@settings(max_examples=50, deadline=None)
@given(st.floats(5.0, 240.0), st.integers(2, 60), st.integers(0, 1000))
def test_resampled_rotations_lie_between_their_neighbours(fps, frames, seed):
    motion = random_motion(frames, 30.0, seed)
    if np.floor(motion.duration * fps + 1e-6) < 1:
        return
    again = motion.resample(fps)
    time = np.arange(len(again)) / fps * 30.0
    low = np.clip(np.floor(time + 1e-6).astype(int), 0, frames - 2)
    whole = angle_between(motion.rotations[low], motion.rotations[low + 1])
    parts = angle_between(motion.rotations[low], again.rotations)
    rest = angle_between(again.rotations, motion.rotations[low + 1])
    # The interpolated rotation lies on the shortest arc: the two angles add up. Angles of
    # nearly equal rotations carry the square root of the rounding.
    assert np.allclose(parts + rest, whole, atol=1e-7)


# -- the names of the smplx package ----------------------------------------------------------


@pytest.mark.parametrize("up", ["z", "y"])
def test_smplx_names_round_trip(up):
    motion = random_motion(betas=np.arange(10.0), gender="male")
    parameters = motion.to_smplx()
    assert parameters["body_pose"].shape == (20, 63)
    assert parameters["betas"].shape == (1, 10)
    again = Motion.from_smplx(fps=30, gender="male", up=up, **parameters)
    assert np.array_equal(again.betas, motion.betas)
    back = again.to_smplx()
    assert np.allclose(back["transl"], parameters["transl"], atol=ROUNDING)
    assert angle_between(back["global_orient"], parameters["global_orient"]).max() < 1e-7
    for name in parameters.keys() - {"transl", "global_orient"}:
        assert np.array_equal(back[name], parameters[name])


def test_smplx_batches_matrices_and_missing_parts():
    motion = random_motion()
    p = motion.to_smplx()
    batched = Motion.from_smplx(
        fps=30,
        global_orient=p["global_orient"][None],
        transl=p["transl"][None],
        body_pose=p["body_pose"].reshape(1, 20, 21, 3),
    )
    assert np.array_equal(batched.rotations[:, :22], motion.rotations[:, :22])
    assert not batched.rotations[:, 22:].any()
    matrices = Motion.from_smplx(
        fps=30,
        global_orient=rot.rotvec_to_matrix(motion.rotations[:, :1]),
        transl=p["transl"],
        body_pose=rot.rotvec_to_matrix(motion.rotations[:, 1:22]),
    )
    assert angle_between(matrices.rotations, batched.rotations).max() < 1e-7


@pytest.mark.parametrize("frames", [3, 20])
def test_smplx_matrices_of_smpl_and_of_one_joint(frames):
    motion = random_motion()[:frames]
    p = motion.to_smplx()
    body = np.concatenate([motion.rotations[:, 1:22], np.ones((frames, 2, 3))], axis=1)
    found = Motion.from_smplx(
        fps=30,
        global_orient=rot.rotvec_to_matrix(motion.rotations[:, 0]),  # (T, 3, 3)
        transl=p["transl"],
        body_pose=rot.rotvec_to_matrix(body),  # (T, 23, 3, 3): the last two are rigid hands
        jaw_pose=rot.rotvec_to_matrix(motion.rotations[:, 22]),
    )
    assert angle_between(found.rotations[:, :23], motion.rotations[:, :23]).max() < 1e-7
    assert not found.rotations[:, 23:].any()


def test_one_matrix_for_all_frames_is_no_three_of_axis_angle():
    turn = rot.rotvec_to_matrix(np.array([[0.3, -0.2, 0.5]]))  # (1, 3, 3)
    found = Motion.from_smplx(fps=30, global_orient=turn, transl=np.zeros((3, 3)))
    assert np.abs(found.rotations[:, 0] - [0.3, -0.2, 0.5]).max() < 1e-12


def test_smplx_smpl_body_and_mean_hands():
    body = np.zeros((4, 69))
    body[:, 63:] = 1.0  # the rigid hands, which have no joint here
    mean = np.linspace(-1.0, 1.0, 90)
    motion = Motion.from_smplx(
        fps=30, global_orient=np.zeros((4, 3)), transl=np.zeros((4, 3)), body_pose=body,
        model="smpl", hands_mean=mean,
    )  # fmt: skip
    assert not motion.rotations[:, :25].any()
    assert np.array_equal(motion.poses[0, 75:], mean)


def test_smplx_matrices_of_smpls_body():
    """As HMR and its successors give them: 23 joints, of which the last two are rigid hands."""
    turns = random_motion(4).rotations[:, 1:24]
    motion = Motion.from_smplx(
        fps=30, global_orient=np.zeros((4, 3)), transl=np.zeros((4, 3)), model="smpl",
        body_pose=rot.rotvec_to_matrix(turns),
    )  # fmt: skip
    assert angle_between(motion.rotations[:, 1:22], turns[:, :21]).max() < 1e-7
    assert not motion.rotations[:, 22:].any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"left_hand_pose": np.zeros((4, 6))}, "left_hand_pose: found shape .*PCA"),
        ({"body_pose": np.zeros((4, 60))}, r"body_pose: found shape \(4, 60\), expected \(T, 63\)"),
        ({"body_pose": np.zeros((3, 63))}, "body_pose: found 3 frames, expected 4"),
        ({"transl": np.zeros((4, 2))}, "transl: found shape"),
        ({"betas": np.arange(8.0).reshape(4, 2)}, "betas: the shape changes over the frames"),
        ({"betas": np.zeros((3, 2))}, "betas: found shape"),
        ({"up": "w"}, "up: found 'w'"),
        ({"hands_mean": np.zeros(45)}, "hands_mean: found shape"),
        ({"up": ["z"]}, r"up: found \['z'\]"),
        ({"body_pose": 1.0}, r"body_pose: found shape \(\), expected \(T, 63\)"),
        ({"left_hand_pose": 1.0}, r"left_hand_pose: found shape \(\), expected \(T, 45\)"),
        ({"global_orient": np.zeros((5, 3, 3))}, r"found 15 frames, expected 4.*shape \(T, 3, 3\)"),
        *(
            ({name: wrong}, f"{name}: not an array of numbers")
            for name in ("global_orient", "transl", "body_pose", "betas", "hands_mean")
            for wrong in ("walk", [[1.0], [1.0, 2.0]], {}, 10**400)
        ),
    ],
)
def test_smplx_impossible_values_are_named(change, message):
    good = {"fps": 30, "global_orient": np.zeros((4, 3)), "transl": np.zeros((4, 3))}
    with pytest.raises(InputError, match=message):
        Motion.from_smplx(**(good | change))


def test_smplx_expression_is_reported_and_typos_refused():
    good = {"fps": 30, "global_orient": np.zeros((4, 3)), "transl": np.zeros((4, 3))}
    Motion.from_smplx(**good, expression=np.zeros((4, 10)))
    with pytest.warns(HalfPhysicsWarning, match="expression: ignored"):
        Motion.from_smplx(**good, expression=np.ones((4, 10)))
    with pytest.raises(TypeError):
        Motion.from_smplx(**good, body_poses=np.zeros((4, 63)))


# -- on the ground ---------------------------------------------------------------------------


def test_grounded_touches_the_height_asked():
    body = Body.default()
    motion = random_motion(8)
    low = body.vertices(motion.grounded(body, z=0.25))[..., 2].min(axis=1)
    assert abs(low.min() - 0.25) < 1e-9
    median = body.vertices(motion.grounded(body, percentile=50.0))[..., 2].min(axis=1)
    assert abs(np.median(median)) < 1e-9
    same = motion.grounded(body).translation - motion.translation
    assert np.ptp(same, axis=0).max() < 1e-12  # moved, not bent
    assert not same[:, :2].any()
    with pytest.raises(InputError, match=r"percentile: .* from 0 to 100, found 101"):
        motion.grounded(body, percentile=101)


@pytest.mark.parametrize("wrong", [None, "body.npz", Body, Body.default], ids=str)
def test_grounding_takes_a_body(wrong):
    with pytest.raises(InputError, match=r"body: expected a halfphysics\.Body.*found "):
        random_motion(3).grounded(wrong)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"z": "up"}, r"z: expected a number \[m\], found 'up'"),
        ({"z": np.nan}, "z: expected a number"),
        ({"percentile": "half"}, "percentile: expected a number from 0 to 100, found 'half'"),
    ],
)
def test_grounding_takes_numbers(options, message):
    with pytest.raises(InputError, match=message):
        random_motion(3).grounded(Body.default(), **options)


@pytest.mark.parametrize("path", [123, None, b"walk.npz", ["walk.npz"], "walk\0.npz"])
def test_a_path_is_text(path):
    for use in (Motion.load, random_motion(3).save):
        with pytest.raises(InputError, match=r"path: expected the path of a file, .* found"):
            use(path)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fps": "fast"}, "fps: found 'fast', expected a positive number"),
        ({"fps": np.inf}, "fps: found inf"),
        ({"frames": 5}, r"frames: found 5, expected \(start, stop\)"),
        ({"frames": "0:5"}, r"frames: found '0:5', expected \(start, stop\)"),
        ({"frames": (0.0, 5)}, r"frames: found \(0\.0, 5\)"),
    ],
)
def test_options_of_load_that_are_impossible(tmp_path, options, message):
    random_motion(3).save(tmp_path / "m.npz")
    with pytest.raises(InputError, match=message):
        Motion.load(tmp_path / "m.npz", **options)


def test_rates_that_would_fill_the_memory():
    motion = random_motion(3)
    assert len(motion.resample(10_000.0)) > 100
    for fps in (10_001, 1e12):
        with pytest.raises(InputError, match="expected at most 10000 frames per second"):
            motion.resample(fps)
    with pytest.raises(InputError, match="fps: found 'x', expected a positive number"):
        motion.resample("x")


# -- stiffness -----------------------------------------------------------------------------


def test_stiffness_scale_goes_with_its_frames():
    scale = 1.0 + np.random.default_rng(1).uniform(0.0, 9.0, (20, 55))
    motion = random_motion(stiffness_scale=scale)
    assert np.array_equal(motion[3].stiffness_scale, scale[3])
    assert np.array_equal(motion[15:2:-4].stiffness_scale, scale[15:2:-4])
    moved = motion.with_frames(motion.translation + 1.0, motion.rotations)
    assert np.array_equal(moved.stiffness_scale, scale)
    assert motion.with_frames(motion.translation[:9], motion.rotations[:9]).stiffness_scale is None
    twice = motion.resample(60.0)
    assert np.array_equal(twice.stiffness_scale[::2], scale)
    assert np.allclose(twice.stiffness_scale[1::2], 0.5 * (scale[1:] + scale[:-1]))
    assert np.array_equal(twice.resample(30.0).stiffness_scale, scale)
    assert random_motion()[3].stiffness_scale is None


@pytest.mark.parametrize("wrong", [np.ones(20), np.ones((19, 55)), -np.ones((20, 55))])
def test_a_stiffness_scale_of_another_shape_or_sign_is_refused(wrong):
    with pytest.raises(InputError, match="stiffness_scale"):
        random_motion(stiffness_scale=wrong)

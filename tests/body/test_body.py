"""Body: its joints and vertices, checked in closed form."""

from __future__ import annotations

import dataclasses
import warnings
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.body.match import check_match
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError, MismatchError
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS
from support.files.model_files import fields, write_npz

# Rounding of double precision over chains of ten joints, a few metres from the origin.
ROUNDING = 1e-13


@pytest.fixture(scope="module")
def body() -> Body:
    return Body.default()


@pytest.fixture(scope="module")
def licensed(tmp_path_factory: pytest.TempPathFactory) -> Body:
    """A made-up SMPL-X file with pose blend shapes."""
    path = write_npz(tmp_path_factory.mktemp("m") / "SMPLX_MALE.npz", fields())
    return Body.load(path, betas=[1.0, -0.5, 2.0])


def make_motion(frames: int = 12, seed: int = 0, **options: Any) -> Motion:
    rng = np.random.default_rng(seed)
    translation = rng.normal(size=(frames, 3)) * 0.1
    return Motion(translation, rng.normal(size=(frames, 55, 3)) * 0.5, 30.0, **options)


def test_rest_pose_is_the_rest_body(body: Body, licensed: Body) -> None:
    for one in (body, licensed):
        rest = Pose(np.zeros(3), np.zeros((55, 3)))
        np.testing.assert_allclose(one.vertices(rest), one.rest_vertices, rtol=0, atol=ROUNDING)
        positions, quaternions = one.joint_frames(rest)
        np.testing.assert_allclose(positions, one.rest_joints, rtol=0, atol=ROUNDING)
        np.testing.assert_array_equal(quaternions, np.tile([1.0, 0, 0, 0], (55, 1)))


def test_whole_body_turn_is_rigid_about_the_pelvis(licensed: Body) -> None:
    """Turning the root by Q turns every vertex by Q about the pelvis, whatever the pose."""
    rng = np.random.default_rng(3)
    motion = make_motion()
    turn = rot.exp(rng.normal(size=(len(motion), 3)) * 2.0)
    turned = np.array(motion.rotations)
    turned[:, 0] = rot.log(rot.multiply(turn, rot.exp(turned[:, 0])))
    pelvis = licensed.joints(motion)[:, :1]
    arms = licensed.vertices(motion) - pelvis
    expected = pelvis + rot.rotate(turn[:, None], arms)
    found = licensed.vertices(Motion(motion.translation, turned, 30.0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_one_joint_moves_only_what_hangs_on_it(body: Body) -> None:
    elbow = JOINT_INDEX["left_elbow"]
    below = [elbow]
    for j in range(55):
        if PARENTS[j] in below:
            below.append(j)
    pose = np.zeros((55, 3))
    pose[elbow] = [0.0, 0.0, 1.2]
    moved = body.vertices(Pose(np.zeros(3), pose))
    share = body.weights[:, below].sum(axis=1)
    rest = body.rest_vertices
    np.testing.assert_allclose(moved[share == 0], rest[share == 0], rtol=0, atol=ROUNDING)
    whole = share > 1.0 - 1e-12
    assert whole.sum() > 100
    joint = body.rest_joints[elbow]
    expected = joint + rot.rotate(rot.exp(pose[elbow]), rest[whole] - joint)
    np.testing.assert_allclose(moved[whole], expected, rtol=0, atol=1e-11)


def test_bones_keep_their_length_and_children_hang_on_parents(body: Body) -> None:
    motion = make_motion()
    positions, quaternions = body.joint_frames(motion)
    for j in range(1, 55):
        p = PARENTS[j]
        arm = body.rest_joints[j] - body.rest_joints[p]
        expected = positions[:, p] + rot.rotate(quaternions[:, p], arm)
        np.testing.assert_allclose(positions[:, j], expected, rtol=0, atol=ROUNDING)
        local = rot.multiply(rot.conjugate(quaternions[:, p]), quaternions[:, j])
        np.testing.assert_allclose(local, rot.exp(motion.rotations[:, j]), rtol=0, atol=ROUNDING)


def test_axes_turn_a_file_about_the_world_origin(licensed: Body) -> None:
    """A y-up file: every vertex of the z-up motion is the turned vertex of the y-up one."""
    axes = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    rng = np.random.default_rng(5)
    y_up = make_motion(seed=5)
    turned = np.array(y_up.rotations)
    turned[:, 0] = rot.matrix_to_rotvec(axes @ rot.rotvec_to_matrix(turned[:, 0]))
    z_up = Motion(y_up.translation @ axes.T, turned, 30.0, axes=axes)
    np.testing.assert_allclose(
        licensed.vertices(z_up), licensed.vertices(y_up) @ axes.T, rtol=0, atol=ROUNDING
    )
    np.testing.assert_allclose(
        licensed.joints(z_up)[:, 0],
        licensed.rest_joints[0] @ axes.T + z_up.translation,
        rtol=0, atol=ROUNDING,
    )  # fmt: skip
    # Any turn, of a single pose, and of a motion without axes.
    axes = rot.rotvec_to_matrix(rng.normal(size=3))
    pose = Pose(np.ones(3), np.zeros((55, 3)), axes)
    np.testing.assert_allclose(
        licensed.joints(pose)[0], axes @ licensed.rest_joints[0] + 1.0, rtol=0, atol=ROUNDING
    )
    bare = SimpleNamespace(translation=[1.0, 1, 1], rotations=np.zeros((55, 3)))
    np.testing.assert_allclose(licensed.joints(bare)[0], licensed.rest_joints[0] + 1.0)  # type: ignore[arg-type]


def test_a_pose_is_one_frame(licensed: Body) -> None:
    motion = make_motion()
    vertices, joints = licensed.vertices(motion), licensed.joints(motion)
    frames, quaternions = licensed.joint_frames(motion)
    assert vertices.shape == (12, 90, 3)
    assert frames.tobytes() == joints.tobytes()
    for i in range(3):
        assert licensed.vertices(motion[i]).tobytes() == vertices[i].tobytes()
        assert licensed.joints(motion[i]).tobytes() == joints[i].tobytes()
        assert licensed.joint_frames(motion[i])[1].tobytes() == quaternions[i].tobytes()


def test_frames_and_indices_choose(licensed: Body) -> None:
    motion = make_motion()
    whole = licensed.vertices(motion)
    for frames in (slice(2, 9, 3), [3, 1, -1], np.array([5]), 4, np.int64(-2), range(3)):
        key = frames if not isinstance(frames, range) else list(frames)
        found = licensed.vertices(motion, frames=frames)
        np.testing.assert_array_equal(found, whole[key])
    np.testing.assert_array_equal(licensed.vertices(motion, indices=[4, 2]), whole[:, [4, 2]])
    np.testing.assert_array_equal(
        licensed.vertices(motion, 3, indices=[4], threads=3), whole[3, [4]]
    )
    for frames in (12, [0, 12], [[0, 1]], "first", 1.5):
        with pytest.raises(InputError, match="frames"):
            licensed.vertices(motion, frames=frames)  # type: ignore[arg-type]
    for indices in ([[0], [0, 1]], ["crown"], 0.5):
        with pytest.raises(InputError, match=r"indices: found .*expected whole numbers \(n,\)"):
            licensed.vertices(motion, indices=indices)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="single pose"):
        licensed.vertices(motion[0], frames=[0])


def test_what_is_no_motion_is_refused(body: Body) -> None:
    with pytest.raises(InputError, match="found ndarray"):
        body.joints(np.zeros((3, 55, 3)))  # type: ignore[arg-type]
    for shape in ((22, 3), (4, 55, 4), (165,)):
        wrong = SimpleNamespace(rotations=np.zeros(shape), translation=np.zeros((4, 3)))
        with pytest.raises(InputError, match=r"\(T, 55, 3\)"):
            body.joints(wrong)  # type: ignore[arg-type]


# The default body


def test_default_body_is_a_person(body: Body) -> None:
    assert (body.model, body.gender, body.source) == ("free", "neutral", None)
    assert body.betas.shape == (10,)
    assert body.rest_joints.shape == (55, 3)
    assert 1.6 < body.stature < 1.8
    np.testing.assert_allclose(body.weights.sum(axis=1), 1.0, rtol=0, atol=1e-12)
    assert body.weights.min() >= 0.0


def test_default_body_takes_its_own_betas(body: Body) -> None:
    tall = Body.default(betas=[2.0])
    assert tall.betas.tolist() == [2.0] + [0.0] * 9
    assert np.abs(tall.rest_vertices - body.rest_vertices).max() > 0.005
    # Directions are linear: twice the coefficient, twice the way.
    more = Body.default(betas=[4.0])
    np.testing.assert_allclose(
        more.rest_joints - body.rest_joints, 2 * (tall.rest_joints - body.rest_joints), atol=1e-12
    )
    with pytest.warns(HalfPhysicsWarning, match="free model has 10"):
        Body.default(betas=np.ones(12))


@pytest.mark.parametrize("stature", [0.5, 1.52, 2.1])
def test_stature_scales_evenly(stature: float) -> None:
    plain, body = Body.default(betas=[1.0]), Body.default(betas=[1.0], stature=stature)
    assert body.stature == pytest.approx(stature, rel=1e-14)
    factor = stature / plain.stature
    np.testing.assert_allclose(body.rest_vertices, plain.rest_vertices * factor, rtol=1e-14)
    np.testing.assert_allclose(body.rest_joints, plain.rest_joints * factor, rtol=1e-14)
    np.testing.assert_array_equal(body.betas, plain.betas)


def test_mass_scales_masses_and_inertias_evenly() -> None:
    plain, body = Body.default(stature=1.8), Body.default(stature=1.8, mass=72.6)
    assert body.mass == pytest.approx(72.6, rel=1e-14)
    factor = 72.6 / plain.mass
    for part, own in zip(plain.variant.parts, body.variant.parts, strict=True):
        assert own.mass == pytest.approx(factor * part.mass, rel=1e-14)
        assert own.inertia == pytest.approx(factor * part.inertia, rel=1e-14)
        assert np.array_equal(own.com, part.com)
    assert np.array_equal(body.rest_vertices, plain.rest_vertices)


@pytest.mark.parametrize("option", ["betas", "bones", "stature", "mass"])
def test_numbers_without_end_are_refused(option: str) -> None:
    with pytest.raises(InputError, match=f"{option}: "):
        Body.default(**{option: 10**400})


@pytest.mark.parametrize("mass", [0.0, -60.0, np.nan, 1e4, "heavy", True])
def test_impossible_masses(mass: Any) -> None:
    with pytest.raises(InputError, match="mass"):
        Body.default(mass=mass)


@pytest.mark.parametrize("stature", [175, 0.0, -1.7, np.nan, "tall", True])
def test_impossible_statures(stature: Any) -> None:
    with pytest.raises(InputError, match="stature"):
        Body.default(stature=stature)


def test_bodies_share_nothing_that_can_change(body: Body) -> None:
    for name in ("weights", "faces", "rest_vertices", "rest_joints", "betas"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(body, name)[0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        body.gender = "male"  # type: ignore[misc]


# Motion and body together


def test_match_of_model_and_gender(licensed: Body) -> None:
    same = make_motion(gender="male", model="smplx", betas=[1.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_match(same, licensed)
        for other in ({"gender": "female"}, {"gender": "male", "model": "smplh"}):
            motion = make_motion(betas=[1.0], **other)
            check_match(motion, licensed, allow_mismatch=True)
            with pytest.raises(MismatchError) as caught:
                check_match(motion, licensed)
            text = str(caught.value)
            for part in ("smplx male", motion.gender, motion.model, "SMPLX_MALE.npz", "allow_mism"):
                assert part in text
        for unknown in (
            SimpleNamespace(model="smplx", gender="unknown", betas=None),
            SimpleNamespace(model="smplx", gender=None, betas=None),
        ):
            check_match(unknown, licensed)  # type: ignore[arg-type]
        check_match(make_motion(gender="female"), dataclasses.replace(licensed, gender="unknown"))


def test_default_body_goes_with_every_motion_and_says_what_is_lost(body: Body) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for betas in (None, np.zeros(16)):
            check_match(make_motion(gender="female", model="smpl", betas=betas), body)
    with pytest.warns(HalfPhysicsWarning, match=r"smpl female.*Body\.default\(stature="):
        check_match(make_motion(gender="female", model="smpl", betas=[0.0, 1.0]), body)


# The variant


def test_variant_is_made_once_and_written_whole(
    body: Body, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    import mujoco

    assert body.variant is body.variant
    path = tmp_path / "variant.xml"
    body.save_mjcf(path)
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.nv == 168
    before = path.read_bytes()
    monkeypatch.setattr("halfphysics.body.mjcf_person.to_mjcf", lambda variant: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        body.save_mjcf(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["variant.xml"]
    monkeypatch.undo()
    with pytest.raises(FileError, match="nowhere"):
        body.save_mjcf(tmp_path / "nowhere" / "a.xml")


def test_main_joint_is_the_one_of_the_largest_weight():
    body = Body.default()
    assert np.array_equal(body.main_joint, np.argmax(body.weights, axis=1))
    assert not body.main_joint.flags.writeable

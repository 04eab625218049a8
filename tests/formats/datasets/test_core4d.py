"""CORE4D files: two people and one object, y-up, joints that say the bones."""

from __future__ import annotations

import json
import warnings
from functools import partial

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.motion.skeleton import BODY_JOINTS, JOINT_INDEX, PARENTS
from support.carries.files.core4d import FINGERS, tips_of
from support.files.layouts import movement, quiet
from support.files.linear_blend import lbs
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.wrong_files import (
    Boom,
    broken_bytes_are_refused,
    changed,
    put,
    refused,
    usual,
)

#: As the data set has it: tests of the floor that is added are in test_ground.py.
load_sequence = partial(hp.load_sequence, ground=False)

FRAMES = 12
#: Positions are in single precision [m].
SINGLE = 1e-5


def body(number: int) -> hp.Body:
    """Whose bones nobody else has: each a little longer or shorter than usual."""
    joints = np.asarray(hp.Body.default().rest_joints)
    bones = joints.copy()
    bones[1:] -= joints[PARENTS[1:]]
    lengths = np.random.default_rng(number).uniform(0.92, 1.08, (55, 1))
    return hp.Body.default(bones=bones * lengths)


def movements(number: int) -> hp.Motion:
    """All joints bent, y-up in the file; fingers without a turn about their bones."""
    translation, r = movement(FRAMES, seed=number, up="y")
    r[:, 22:25] = 0.0
    free, ends = hp.Body.default(), {}
    for row, vertex in tips_of(free).items():
        side, finger = ("left", "right")[(row - 66) // 5], FINGERS[(row - 66) % 5]
        ends[JOINT_INDEX[f"{side}_{finger}3"]] = free.rest_vertices[vertex]
    for joint in range(25, 55):  # their turn about the bone is not in joint positions
        end = ends[joint] if joint in ends else free.rest_joints[joint + 1]
        bone = end - free.rest_joints[joint]
        unit = bone / np.linalg.norm(bone)
        r[:, joint] -= (r[:, joint] @ unit)[:, None] * unit
    return hp.Motion(translation, r, 15.0)


def fields(number: int) -> dict:
    """One person's file, with the joints of SMPL-X and the tips of the fingers."""
    motion, own = movements(number), body(number)
    joints = np.zeros((FRAMES, 127, 3))
    joints[:, :55] = own.joints(motion)
    tips = tips_of(own)
    joints[:, list(tips)] = own.vertices(motion, indices=list(tips.values()))
    return {
        "betas": np.tile(np.linspace(0.5, -0.5, 10), (FRAMES, 1)).astype(np.float32),
        "expression": np.zeros((FRAMES, 10), np.float32),
        "global_orient": motion.rotations[:, 0].astype(np.float32),
        "transl": motion.translation.astype(np.float32),
        "body_pose": motion.rotations[:, list(BODY_JOINTS)].astype(np.float32),
        "left_hand_pose": np.random.default_rng(number).normal(0, 0.2, (FRAMES, 12)),
        "right_hand_pose": np.random.default_rng(number + 9).normal(0, 0.2, (FRAMES, 12)),
        "joints": joints.astype(np.float32),
        "vertices": np.zeros((FRAMES, 10475, 3), np.float32),
    }


def poses() -> np.ndarray:
    t = np.linspace(0.0, 1.0, FRAMES)[:, None]
    out = np.tile(np.eye(4), (FRAMES, 1, 1))
    turn = np.array([0.3, -0.2, 0.8]) + t * np.array([0.1, 0.3, -0.4])
    out[:, :3, :3] = rot.rotvec_to_matrix(turn)
    out[:, :3, 3] = np.array([0.4, 0.8, 0.3]) + t * np.array([0.2, 0.3, -0.1])
    return out


def put_person(folder, number: int, content) -> None:
    np.savez(folder / f"person{number}_poses.npz", np.array(content, dtype=object))


@pytest.fixture
def data_set(tmp_path):
    root = tmp_path / "CORE4D_Real"
    folder = root / "human_object_motions" / "20231002" / "004"
    meshes = root / "object_models" / "chair"
    folder.mkdir(parents=True)
    meshes.mkdir(parents=True)
    for number in (1, 2):
        put_person(folder, number, fields(number))
    np.save(folder / "smooth_objposes.npy", poses())
    (folder / "object_metadata.json").write_text(json.dumps({"obj_name": "Chair001"}))
    box = trimesh.creation.box((0.4, 0.3, 0.5))
    box.apply_translation((0.1, 0.0, 0.2))
    box.export(meshes / "chair001_m.obj")
    return folder


def test_two_people_have_the_recorded_joints(data_set):
    sequence = quiet(data_set)
    assert len(sequence.motions) == len(sequence.bodies) == 2
    for number, motion, own in zip((1, 2), sequence.motions, sequence.bodies, strict=True):
        assert (motion.fps, motion.model, motion.gender) == (15.0, "smplx", "neutral")
        asked = fields(number)["joints"][:, :55] @ axes_of("y").T
        # Jaw and eyes are not posed in the files.
        assert np.abs(own.joints(motion) - asked).max() < SINGLE
        # Fingers turn as they did, their last joints by the tips.
        turned = own.joint_frames(motion)[1]
        want = body(number).joint_frames(movements(number))[1]
        want = rot.multiply(rot.from_matrix(axes_of("y")), want)
        assert (np.abs(np.sum(turned * want, axis=-1)) > 1.0 - 1e-8).all()


def test_flat_hands_stay_flat(data_set):
    """What rounding and the place of the tips make of them is no recorded finger."""
    motion, own = movements(1), body(1)
    motion = motion.with_frames(motion.translation, np.where(
        np.arange(55)[:, None] >= 25, 0.0, motion.rotations))  # fmt: skip
    content, tips = fields(1), tips_of(own)
    content["joints"][:, :55] = own.joints(motion)
    content["joints"][:, list(tips)] = own.vertices(motion, indices=list(tips.values())) + 0.002
    put_person(data_set, 1, content)
    assert not quiet(data_set).motions[0].rotations[:, 25:].any()


def test_one_file_is_one_motion_and_both_a_sequence(data_set):
    first, second = (data_set / f"person{k}_poses.npz" for k in (1, 2))
    with pytest.warns(HalfPhysicsWarning, match="the recorded bones: stature"):
        motion = hp.Motion.load(second)
    assert np.abs(motion.translation - quiet(data_set).motions[1].translation).max() == 0.0
    assert len(quiet(first).motions) == 2
    assert [clip.format for clip in hp.clips(data_set.parents[2])] == ["core4d"]
    second.unlink()
    assert len(quiet(data_set).motions) == 1


def test_the_object(data_set):
    sequence = quiet(data_set)
    item, track = sequence.scene.objects["chair001"], sequence.recorded["chair001"]
    vertices = item.visual.vertices
    for frame in range(FRAMES):
        asked = vertices @ poses()[frame, :3, :3].T + poses()[frame, :3, 3]
        placed = rot.rotate(track.quaternion[frame], vertices) + track.position[frame]
        assert np.abs(placed - asked @ axes_of("y").T).max() < SINGLE
    assert np.array_equal(item.position, track.position[0])
    part = quiet(data_set, frames=(2, 8), objects="replayed")
    assert np.array_equal(part.scene.objects["chair001"].positions, track.position[2:8])


def test_the_objects_name_may_be_in_the_file_of_its_poses(data_set):
    asked = quiet(data_set).recorded["chair001"]
    (data_set / "object_metadata.json").unlink()
    (data_set / "smooth_objposes.npy").rename(data_set / "object_poses_chair001.npy")
    assert np.array_equal(quiet(data_set).recorded["chair001"].position, asked.position)


def test_the_users_model_unfolds_the_hands_and_gives_the_body(data_set, tmp_path):
    model = write_npz(tmp_path / "SMPLX_NEUTRAL.npz", model_fields("smplx"))
    sequence = quiet(data_set, model=model)
    content, person = model_fields("smplx"), fields(1)
    r = np.zeros((FRAMES, 55, 3))
    r[:, 0], r[:, list(BODY_JOINTS)] = person["global_orient"], person["body_pose"]
    for side, first in (("left", 25), ("right", 40)):
        axes = content[f"hands_components{side[0]}"][:12]
        r[:, first : first + 15] = (person[f"{side}_hand_pose"] @ axes).reshape(FRAMES, 15, 3)
    for frame in (0, FRAMES - 1):
        asked = lbs("smplx", content, person["betas"][0], r[frame]) + person["transl"][frame]
        found = sequence.bodies[0].vertices(sequence.motions[0], frames=frame)
        assert np.abs(found - asked @ axes_of("y").T).max() < 1e-9


def test_without_joints_fingers_stay_flat_and_the_size_is_not_known(data_set):
    content = fields(1)
    del content["joints"]
    put_person(data_set, 1, content)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sequence = load_sequence(data_set)
    told = "\n".join(str(each.message) for each in said)
    assert "principal components and no 'joints'" in told
    assert "Body.default() is taken" in told
    assert not sequence.motions[0].rotations[:, 25:].any()
    assert sequence.bodies[0] is hp.Body.default()


def test_joints_that_the_rotations_do_not_give_are_said(data_set):
    content = fields(1)
    content["joints"][4, 7] += 0.1
    put_person(data_set, 1, content)
    with pytest.warns(HalfPhysicsWarning) as said:
        load_sequence(data_set)
    assert any("disagree by up to 0.1" in str(each.message) for each in said)


WRONG = [
    *usual("transl"),
    ("pose flat", changed("body_pose", lambda a: a.reshape(FRAMES, 63)), "'body_pose'.*21, 3"),
    ("few joints", changed("joints", lambda a: a[:, :24]), "'joints'.*127, 3"),
    ("joints NaN", changed("joints", lambda a: a * np.nan), "'joints'.*NaN"),
    ("joints in mm", changed("joints", lambda a: a * 1000.0), "in metres"),
    ("short", changed("joints", lambda a: a[:-1]), "different length"),
    (
        "betas vary",
        changed("betas", lambda a: a + np.arange(12)[:, None]),
        "field 'betas': the shape changes",
    ),
    ("pose of text", put("global_orient", "up"), "'global_orient'.*expected"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_people(data_set, spoil, message):
    content = fields(1)
    spoil(content)
    put_person(data_set, 1, content)
    with pytest.raises(hp.HalfPhysicsError, match=f"(?s)person1_poses.npz.*({message})"):
        quiet(data_set)


def test_other_wrong_files(data_set):
    second = data_set / "person2_poses.npz"
    with pytest.raises(hp.HalfPhysicsError, match=r"holds two people.*person1_poses.npz or"):
        hp.Motion.load(data_set)
    track = data_set / "smooth_objposes.npy"
    bent = poses()
    bent[3, :3, :3] *= 1.1
    np.save(track, bent)
    with pytest.raises(hp.HalfPhysicsError, match="matrix of frame 3 is no rotation"):
        quiet(data_set)
    np.save(track, poses()[:-1])
    refused(data_set, "different length")
    np.save(track, poses()[:, :3])
    with pytest.raises(hp.HalfPhysicsError, match=r"smooth_objposes.npy.*\(T, 4, 4\)"):
        quiet(data_set)
    np.save(track, poses())
    mesh = data_set.parents[2] / "object_models/chair/chair001_m.obj"
    mesh.rename(mesh.with_name("other.obj"))
    refused(data_set, "the mesh of 'chair001'.*chair001_m.obj.*assets=")
    (data_set / "object_metadata.json").write_text("{")
    with pytest.raises(hp.HalfPhysicsError, match=r"object_metadata.json: cannot be read"):
        quiet(data_set)
    (data_set / "object_metadata.json").unlink()
    refused(data_set, "which object it is.*'obj_name'.*object_poses_NAME.npy")
    for number in (1, 2):
        np.save(data_set / f"object_poses_chair00{number}.npy", poses())
    refused(data_set, "chair001.npy, object_poses_chair002.npy, expected.*one object")
    for path in data_set.glob("*.npy"):
        path.unlink()
    refused(data_set, "smooth_objposes.npy or object_poses_NAME.npy, neither is there")
    put_person(data_set, 2, [1.0])
    with pytest.raises(hp.HalfPhysicsError, match=r"person2_poses.npz.*expected a dict"):
        quiet(data_set)
    np.savez(second, other=np.zeros(3))
    with pytest.raises(hp.HalfPhysicsError, match=r"person2_poses.npz: found fields"):
        quiet(data_set)


def test_hostile_files(data_set, tmp_path):
    mark = tmp_path / "was_run"
    put_person(data_set, 1, {**fields(1), "betas": Boom(mark)})
    with pytest.raises(hp.HalfPhysicsError, match="unsafe or unknown content"):
        quiet(data_set)
    assert not mark.exists()


def test_broken_files(data_set):
    put_person(data_set, 1, {k: v for k, v in fields(1).items() if k != "vertices"})
    broken_bytes_are_refused(data_set / "person1_poses.npz")

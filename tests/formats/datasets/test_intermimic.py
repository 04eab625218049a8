"""InterMimic tensors: a person as a robot, with an unknown shape, and an object."""

from __future__ import annotations

import contextlib
import functools
import pickle
import re
import warnings
from functools import partial

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base import stored_objects as stored
from halfphysics.base.axes import axes_of
from halfphysics.formats import losses
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS, SMPLH_JOINTS
from support.bones import elsewhere, own_bones
from support.files.dumps import Tensor, torch_saved
from support.files.layouts import movement
from support.files.model_files import write_npz
from support.files.wrong_files import Boom, broken_bytes_are_refused, refused

#: As the data set has it: tests of the floor that is added are in test_ground.py.
load_sequence = partial(hp.load_sequence, ground=False)

SINGLE = 2e-6  # metres, of positions in single precision
SHAPE = 1e-6  # metres, of a skin whose shape was found by its joints in single precision
NAME = "sub3_largebox_003.pt"
WIDTH = 591
FINGERS = ("index", "middle", "pinky", "ring", "thumb")


@contextlib.contextmanager
def told(*patterns: str):
    """Warnings that contain each of these; besides them at most those of the shape and the mass."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    lines = [str(w.message) for w in caught]
    for pattern in (*patterns, "."):
        assert any(re.search(pattern, line) for line in lines), (pattern, lines)
    usual = ("does not say whose shape", "weighs", *patterns)
    assert all(any(re.search(pattern, line) for pattern in usual) for line in lines), lines


def side(name: str) -> list[str]:
    """The joints of an arm in the robot's order."""
    arm = [f"{name}_{j}" for j in ("collar", "shoulder", "elbow", "wrist")]
    return arm + [f"{name}_{finger}{k}" for finger in FINGERS for k in (1, 2, 3)]


#: L_Hip L_Knee L_Ankle L_Toe, R_..., Torso Spine Chest, Neck Head, L_Thorax ... R_Thorax ...
ROBOT = [
    "pelvis",
    *(f"{s}_{j}" for s in ("left", "right") for j in ("hip", "knee", "ankle", "foot")),
    *("spine1", "spine2", "spine3", "neck", "head"),
    *side("left"),
    *side("right"),
]
JOINTS = [JOINT_INDEX[name] for name in ROBOT]
#: Upright frames at rest: x y z of SMPL are their y z x.
TURN = Rotation.from_quat([0.5, 0.5, 0.5, 0.5])


def person(frames: int = 12, hands: float = 1.0) -> hp.Motion:
    translation, rotations = movement(frames)
    rotations[:, 22:25] = 0.0
    rotations[:, 25:] *= hands
    return hp.Motion(translation + np.array([0, 0, 1.3]), rotations, 30.0)


def rows(body: hp.Body, motion: hp.Motion | None = None) -> np.ndarray:
    """The tensor of a person (by default `person()`), as the data set's own converter makes it."""
    motion = person() if motion is None else motion
    frames, turns = len(motion), np.array(motion.rotations)
    world = [Rotation.from_rotvec(turns[:, 0])]
    for joint in range(1, 55):
        world.append(world[PARENTS[joint]] * Rotation.from_rotvec(turns[:, joint]))
    upright = {j: world[j] * TURN.inv() for j in JOINTS}
    places = body.joints(motion)
    out = np.zeros((frames, WIDTH))
    out[:, 0:3] = places[:, 0]
    out[:, 3:7] = upright[0].as_quat()
    for index, joint in enumerate(JOINTS[1:]):
        local = upright[PARENTS[joint]].inv() * upright[joint]
        out[:, 9 + 3 * index : 12 + 3 * index] = local.as_rotvec()
    out[:, 162:318] = places[:, JOINTS].reshape(frames, -1)
    t = np.linspace(0.0, 1.0, frames)[:, None]
    out[:, 318:321] = t * [1.0, 0.5, 0.2] + 1.0
    thing = Rotation.from_rotvec(t * [0.3, 1.0, -0.2]).as_quat()
    thing[5] *= -1.0  # the same rotation
    out[:, 321:325] = thing
    out[:, 330:383] = np.arange(53) % 2
    out[:, 383:] = np.hstack([upright[j].as_quat() for j in JOINTS])
    return out


def written(path, array):
    single = array.astype(np.float32)
    size = tuple(single.shape)
    stride = tuple(int(np.prod(size[i + 1 :])) for i in range(len(size)))
    return torch_saved(path, Tensor("0", "FloatStorage", single.size, size, stride), {"0": single})


@functools.cache
def space():
    from halfphysics.body.body import _free

    return _free()


def model(folder, gender: str, factor: float = 1.0, layout: tuple[int, ...] = tuple(range(55))):
    """A model file of SMPL-X or SMPL-H in layout, of the free body in form."""
    free, rng = space(), np.random.default_rng(len(gender))
    joints = list(layout)
    parents = [layout.index(PARENTS[j]) if j else 0 for j in joints]
    table = np.stack([parents, np.arange(len(joints))]).astype(np.int64)
    weights = np.array(free.weights)
    if len(joints) < 55:  # the face is the head's
        weights[:, JOINT_INDEX["head"]] += weights[:, 22:25].sum(axis=1)
    table[0, 0] = 2**32 - 1
    # Every shape direction bends the whole body smoothly.
    bends = rng.normal(size=(3, 3, 12)) * 0.03
    shapedirs = np.einsum("vi,ijk->vjk", np.sin(3.0 * free.template), bends)
    content = {
        "v_template": factor * free.template,
        "f": free.faces.astype(np.uint32),
        "weights": weights[:, joints],
        "J_regressor": free.joint_regressor[joints],
        "kintree_table": table.astype(np.uint32),
        "shapedirs": shapedirs,
        "hands_meanl": np.tile([0.0, 0.0, -0.7], 15),
        "hands_meanr": np.tile([0.0, 0.0, 0.7], 15),
        "hands_componentsl": np.eye(45),
        "hands_componentsr": np.eye(45),
    }
    name = "SMPLX" if len(joints) == 55 else "SMPLH"
    return write_npz(folder / f"{name}_{gender.upper()}.npz", content)


BETAS = np.array([1.5, -0.7, 0.4, 1.1, -1.9, 0.3, 0.8, -0.2, 0.6, -1.0, 0.5, 0.9])


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    model(folder, "female", 0.93)
    model(folder, "male")
    return folder


@pytest.fixture
def assets(tmp_path):
    """The mesh where InterMimic has it, centred."""
    folder = tmp_path / "assets" / "objects" / "objects" / "largebox"
    folder.mkdir(parents=True)
    trimesh.creation.box((0.3, 0.4, 0.2)).export(folder / "largebox.obj")
    return tmp_path / "assets"


def test_the_default_body_of_that_size(tmp_path):
    tall = hp.Body.default(stature=1.91)
    path = written(tmp_path / NAME, rows(tall))
    with told(r"recorded bones, stature 1\.91 m.*model="):
        motion = hp.Motion.load(path)
    assert (motion.fps, motion.model, motion.betas) == (30.0, "smplx", None)
    assert np.abs(tall.vertices(motion) - tall.vertices(person())).max() < SINGLE
    # With the option, the pelvis turns about the world's origin.
    with told():
        y_up = hp.Motion.load(path, up="y")
    turned = tall.vertices(person()) @ axes_of("y").T
    assert np.abs(tall.vertices(y_up) - turned).max() < SINGLE
    with told():
        part = hp.Motion.load(path, frames=(3, 8))
    assert np.abs(part.translation - motion.translation[3:8]).max() < SINGLE


def test_the_body_has_the_recorded_bones(tmp_path, assets):
    """Joints are where the file has them, in every frame, to single precision."""
    bones = elsewhere()
    bones[0] = np.nan
    for joint, ratio in ((18, 1.08), (19, 1.08), (4, 0.95), (26, 0.9), (28, 1.1)):
        row = bones[joint] if np.isfinite(bones[joint, 0]) else own_bones(hp.Body.default())[joint]
        bones[joint] = ratio * row
    person_of_the_file = hp.Body.default([1.0, -2.0], bones=bones)
    array = rows(person_of_the_file)
    path = written(tmp_path / NAME, array)
    with told("recorded bones, stature 1.6"):
        sequence = load_sequence(path, assets)
    places = array[:, 162:318].reshape(len(array), -1, 3)
    found = sequence.body.joints(sequence.motion)[:, JOINTS]
    assert np.abs(found - places).max() < SINGLE
    # The head's joints are in no file: they follow.
    assert np.isfinite(sequence.body.rest_joints).all()
    assert sequence.body.variant.mass > 30.0


def test_the_shape_is_found(tmp_path, models):
    body = hp.Body.load(models / "SMPLX_MALE.npz", BETAS)
    path = written(tmp_path / NAME, rows(body))
    # From a file, and from a folder, where the fitting gender is chosen.
    for given in (models / "SMPLX_MALE.npz", models):
        motion = hp.Motion.load(path, model=given)
        assert (motion.model, motion.gender) == ("smplx", "male")
        own = hp.Body.load(models, motion.betas, gender=motion.gender)
        assert np.abs(own.vertices(motion) - body.vertices(person())).max() < SHAPE
    with told("bones differ by up to .* mm.*another gender"):
        hp.Motion.load(path, model=models, gender="female")


def test_the_shape_of_other_models_is_found(tmp_path):
    body = hp.Body.load(model(tmp_path, "neutral", layout=SMPLH_JOINTS), BETAS)
    assert body.model == "smplh"
    path = written(tmp_path / NAME, rows(body))
    motion = hp.Motion.load(path, model=tmp_path / "SMPLH_NEUTRAL.npz")
    assert (motion.model, motion.gender) == ("smplh", "neutral")
    own = hp.Body.load(tmp_path / "SMPLH_NEUTRAL.npz", motion.betas)
    assert np.abs(own.vertices(motion) - body.vertices(person())).max() < SHAPE


def test_relaxed_hands_are_seen_by_their_joints(tmp_path, models):
    # The converter poses models whose mean hand is added: zero fingers are a relaxed hand.
    body = hp.Body.load(models / "SMPLX_MALE.npz", BETAS)
    raw = person(hands=0.1)
    bent = raw.rotations.copy()
    bent[:, 25:] += body.hands_mean.reshape(30, 3)
    relaxed = hp.Motion(raw.translation, bent, 30.0)
    array = rows(body, raw)
    array[:, 162:318] = rows(body, relaxed)[:, 162:318]
    path = written(tmp_path / NAME, array)
    motion = hp.Motion.load(path, model=models)
    assert np.abs(motion.rotations[:, 25:] - relaxed.rotations[:, 25:]).max() < SINGLE
    own = hp.Body.load(models, motion.betas, gender=motion.gender)
    assert np.abs(own.joints(motion) - body.joints(relaxed)).max() < SHAPE
    refused(path, "joints of the hands are those of the model's relaxed hand.*model=.*hands='flat'")
    flat = hp.Motion.load(path, hands="flat", model=models)
    assert np.abs(flat.rotations - raw.rotations).max() < SINGLE


def test_object_and_body(tmp_path, assets):
    body = hp.Body.default()
    array = rows(body)
    path = written(tmp_path / NAME, array)
    with told("does not say whose shape", "weighs"):
        sequence = load_sequence(path, assets)
    assert abs(sequence.body.stature - body.stature) < 1e-3
    mesh = trimesh.load(assets / "objects" / "objects" / "largebox" / "largebox.obj")
    track = sequence.recorded["largebox"]
    for frame in (0, 5, 11):
        asked = Rotation.from_quat(array[frame, 321:325]).apply(mesh.vertices)
        asked += array[frame, 318:321]
        placed = rot.rotate(track.quaternion[frame], mesh.vertices) + track.position[frame]
        assert np.abs(placed - asked).max() < SINGLE
    assert np.array_equal(sequence.scene.objects["largebox"].position, track.position[0])
    with told():
        replayed = load_sequence(path, assets, objects="replayed")
    assert np.array_equal(replayed.scene.objects["largebox"].positions, track.position)


def test_a_mesh_of_another_data_set_is_noticed(tmp_path, assets):
    file = assets / "objects" / "objects" / "largebox" / "largebox.obj"
    mesh = trimesh.load(file)
    mesh.apply_translation((0.1, 0.0, 0.0))
    mesh.export(file)
    path = written(tmp_path / NAME, rows(hp.Body.default()))
    with told("not centred"):
        load_sequence(path, assets)


def test_written_as_it_came(tmp_path, models):
    body = hp.Body.load(models / "SMPLX_MALE.npz", BETAS)
    path = written(tmp_path / NAME, rows(body))
    motion = hp.Motion.load(path, model=models)
    own = hp.Body.load(models, motion.betas, gender=motion.gender)
    with pytest.raises(hp.HalfPhysicsError, match="body="):
        motion.save(tmp_path / "sub3_largebox_004.pt")
    motion.save(tmp_path / "sub3_largebox_004.pt", body=own)
    first, again = (stored.read(tmp_path / f"sub3_largebox_00{n}.pt") for n in (3, 4))
    assert again.dtype == np.float32
    # Both signs of a quaternion are the same rotation.
    for start in (3, 321, *range(383, WIDTH, 4)):
        for array in (first, again):
            quaternion = array[:, start : start + 4]
            quaternion *= np.sign(quaternion[:, 3:])
    assert np.abs(again - first).max() < SINGLE
    back = hp.Motion.load(tmp_path / "sub3_largebox_004.pt", model=models)
    assert np.abs(own.vertices(back) - own.vertices(motion)).max() < SINGLE


def test_any_motion_is_written(tmp_path, assets):
    body = hp.Body.default(stature=1.6)
    path = tmp_path / NAME
    hp.Motion.from_smplx(
        fps=60.0, up="y", transl=np.zeros((9, 3)), global_orient=movement(9, up="y")[1][:, 0]
    ).resample(30.0).save(path, format="intermimic", body=body)
    with told():
        motion = hp.Motion.load(path)
    motion.resample(60.0).save(path, body=body)  # the object along with the person
    with told("weighs"):
        sequence = load_sequence(path, assets)
    assert len(sequence.motion) == 9
    assert losses(motion, path) == []
    other = hp.Motion(*movement(), 60.0, betas=[1.0], gender="male")
    assert losses(other, path, "intermimic") == [
        "jaw and eyes",
        "the shape (betas), but for the joints of it",
        "the gender 'male'",
        "the frame rate 60: readers take 30; say motion.resample(30)",
        "an object: there is none, and its columns say that it lies at the origin",
    ]


def put(columns, value):
    def spoil(array):
        array[columns] = value
        return array

    return spoil


EVERY = slice(None)
WRONG = {
    "590 columns": (lambda a: a[:, :-1], r"shape \(12, 590\), expected \(T, 591\)"),
    "592 columns": (lambda a: np.hstack([a, a[:, :1]]), r"\(12, 592\), expected"),
    "transposed": (lambda a: a.T, r"\(591, 12\), expected"),
    "flat": (lambda a: a.reshape(-1), "expected .T, 591"),
    "a batch": (lambda a: a[None], "expected .T, 591"),
    "nothing": (lambda a: a[:0], "0 frames"),
    "one frame": (lambda a: a[:1], "1 frame"),
    "NaN": (put((3, 1), np.nan), "NaN.*frame 3"),
    "infinite": (put((4, 200), np.inf), "infinite.*frame 4"),
    "root not turned": (put((2, slice(3, 7)), 0.0), "columns 3:7.*frame 2.*length 1"),
    "root turned twice": (put((EVERY, slice(3, 7)), 2.0), "columns 3:7.*length 1"),
    "object not turned": (put((7, slice(321, 325)), 0.0), "columns 321:325.*object.*frame 7"),
    "no joints": (put((EVERY, slice(162, 318)), 0.0), "columns 162:318.*bones from 0 to 0"),
    "joints apart": (lambda a: a * np.where(np.arange(WIDTH) // 156 == 1, 9, 1), "columns|length"),
    "a doll": (
        lambda a: a * np.where((np.arange(WIDTH) >= 162) & (np.arange(WIDTH) < 318), 0.1, 1),
        "joint positions: bones: pelvis to left_hip: found 0.* m, expected",
    ),
    "a giant": (
        lambda a: a * np.where((np.arange(WIDTH) >= 162) & (np.arange(WIDTH) < 318), 2.0, 1),
        "joint positions: bones: found those of a person of 3.* m",
    ),
    "a jump": (put((5, 0), 1e4), "m/s between frames"),
    "object apart": (put((EVERY, slice(321, 325)), 1e20), "columns 321:325"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files(tmp_path, assets, name):
    spoil, message = WRONG[name]
    array = spoil(rows(hp.Body.default()).copy())
    refused(written(tmp_path / NAME, array), message, assets=assets)


def test_wrong_things_in_a_file(tmp_path, assets):
    good = rows(hp.Body.default()).astype(np.float32)
    path = tmp_path / NAME
    for content in ([good], {"hoi_data": good}, "text", 3.0, None):
        path.write_bytes(pickle.dumps(content))
        refused(path, "no known motion format", assets=assets)
    path.write_bytes(pickle.dumps(good.astype(str)))
    refused(path, "expected numbers", assets=assets)
    path.write_bytes(pickle.dumps(good.astype(complex)))
    refused(path, "expected numbers", assets=assets)
    mark = tmp_path / "was_run"
    path.write_bytes(pickle.dumps([good, Boom(mark)]))
    refused(path, "unsafe or unknown content", assets=assets)
    assert not mark.exists()


def test_wrong_names_and_options(tmp_path, assets):
    array = rows(hp.Body.default())
    refused(written(tmp_path / "clip.pt", array), "expected SUBJECT_OBJECT_NUMBER", assets=assets)
    refused(written(tmp_path / "a_sofa_1.pt", array), "mesh of the object 'sofa'.*Looked for")
    path = written(tmp_path / NAME, array)
    refused(path, "holds one motion only", clip="a")
    with pytest.raises(hp.HalfPhysicsError, match="model: found 'nobody'"):
        hp.Motion.load(path, model="nobody")


def test_positions_that_disagree_are_said(tmp_path):
    array = rows(hp.Body.default())
    array[6, 162 + 3 * 5] += 0.1
    with told("disagree by up to 0.1"):
        hp.Motion.load(written(tmp_path / NAME, array))


def test_broken_bytes(tmp_path):
    broken_bytes_are_refused(written(tmp_path / NAME, rows(hp.Body.default())))


def test_a_damaged_model_in_a_folder_is_said(tmp_path):
    """A folder need not have all genders; an unreadable file is not treated as missing."""
    folder = tmp_path / "models"
    folder.mkdir()
    model(folder, "neutral")
    path = written(tmp_path / NAME, rows(hp.Body.load(next(folder.iterdir()))))
    assert hp.Motion.load(path, model=folder).gender == "neutral"
    (folder / "SMPLX_MALE.npz").write_bytes(b"PK no more")
    with pytest.raises(hp.HalfPhysicsError, match=r"SMPLX_MALE\.npz"):
        hp.Motion.load(path, model=folder)

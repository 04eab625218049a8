"""glTF: our own files come back, rigs of other programs are put on the body, with what is there."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import foreign_json
from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning
from halfphysics.formats.bvh.channels import animated
from halfphysics.formats.bvh.text import read_bvh
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.result import ObjectTrack
from support.files.bvh_files import MIXAMO
from support.files.gltf_rigs import Builder, add_person, motion_of, person, read
from support.files.layouts import movement, quiet

BODY = hp.Body.default()
SINGLE = 1e-5  # metres: keys are in single precision
# Bones that a rest pose turns the shortest way: the default body's are to a few micrometres.
NEAR = 3e-5


def off(one: hp.Motion, other: hp.Motion) -> float:
    assert (len(one), one.fps) == (len(other), other.fps)
    return float(np.abs(BODY.vertices(one) - BODY.vertices(other)).max())


# -- our own ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
@pytest.mark.parametrize("fps", [30.0, 59.94, 120.0])
def test_what_is_exported_comes_back(tmp_path, suffix, fps):
    motion = hp.Motion(*movement(20), fps)
    hp.export(motion, tmp_path / f"x{suffix}")
    assert off(read(tmp_path / f"x{suffix}"), motion) < SINGLE
    assert off(read(tmp_path / f"x{suffix}", frames=(3, 9)), motion[3:9]) < SINGLE


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_a_sequence_comes_back_with_its_people_objects_and_room(tmp_path):
    people = tuple(hp.Motion(*movement(20, seed=seed), 30.0) for seed in (1, 2))
    bones = np.full((55, 3), np.nan)
    bones[1:22] = 1.1 * (
        BODY.rest_joints[1:22] - BODY.rest_joints[hp.motion.skeleton.PARENTS[1:22]]
    )
    tall = hp.Body.default(bones=bones)
    scene = hp.Scene()
    scene.add_static("ground", hp.Plane(offset=0.1))
    scene.add_static("shelf", hp.Box((0.4, 0.3, 0.2)), position=(1.0, 2.0, 0.5))
    t = np.linspace(0.0, 1.0, 20)[:, None]
    path, turns = [0.5, 0.2, 1.0] + 0.3 * t, rot.exp(t * np.array([0.4, 0.5, 0.6]))
    scene.add_moving("box", hp.Box((0.1, 0.2, 0.3)), path, turns, fps=30.0)
    recorded = {"box": ObjectTrack(position=path, quaternion=turns)}
    hp.export(hp.Sequence(people, scene, (tall, BODY), recorded=recorded), tmp_path / "a.glb")
    back = quiet(tmp_path / "a.glb", objects="replayed")
    for motion, asked, body, own in zip(
        back.motions, people, back.bodies, (tall, BODY), strict=True
    ):
        assert np.abs(body.joints(motion) - own.joints(asked)).max() < SINGLE
    assert isinstance(back.scene.statics["ground"].shape, hp.Plane)
    assert abs(back.scene.statics["ground"].shape.offset - 0.1) < SINGLE
    shelf = back.scene.statics["shelf"]
    corners = rot.rotate(shelf.quaternion, shelf.shape.vertices) + shelf.position
    low, high = corners.min(axis=0), corners.max(axis=0)
    box = scene.statics["shelf"].shape.triangles()[0] + np.array([1.0, 2.0, 0.5])
    assert np.abs(low - box.min(axis=0)).max() < SINGLE
    assert np.abs(high - box.max(axis=0)).max() < SINGLE
    track = back.recorded["box"]
    assert np.abs(track.position - path).max() < SINGLE
    assert rot.log(rot.multiply(rot.conjugate(track.quaternion), turns)).max() < SINGLE
    assert list(quiet(tmp_path / "a.glb", ground=False, adapt=False).scene.objects) == ["box"]
    with pytest.warns(HalfPhysicsWarning, match=r"of 2 people \('person0', 'person1'\) the first"):
        assert off(hp.Motion.load(tmp_path / "a.glb"), people[0]) > 0.01  # on another body
    assert [clip.name for clip in hp.clips(tmp_path / "a.glb")] == ["take"]


# -- rigs of other programs ------------------------------------------------------------------------


def a_pose(degrees: float) -> np.ndarray:
    """SMPL-X from file joints where arms and hands hang at the bind pose."""
    own = np.tile([1.0, 0.0, 0.0, 0.0], (55, 1))
    parts = ("shoulder", "elbow", "wrist", "index", "middle", "pinky", "ring", "thumb")
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for joint, name in enumerate(JOINT_NAMES):
            if name.startswith(side) and any(part in name for part in parts):
                own[joint] = rot.exp([0.0, 0.0, sign * np.radians(degrees)])
    return own


RIGS = {
    "frames parallel at the bind pose": {},
    "any frames": {"seed": 3},
    "centimetres below a scaled armature": {"seed": 3, "unit": 100.0},
    "Blender's: turned, in centimetres": {"unit": 100.0, "tilt": (np.pi / 2, 0.0, 0.0), "seed": 4},
    "a tilted armature": {"tilt": (np.pi / 2, 0.0, 0.0)},
    "an A pose": {"seed": 5, "own": a_pose(50.0)},
    "a prefix": {"seed": 6, "prefix": "mixamorig:"},
    "steps": {"seed": 7, "kind": "STEP"},
    "cubic": {"seed": 7, "kind": "CUBICSPLINE"},
    "no skin": {"seed": 8, "skinned": False},
    "a late start": {"seed": 9, "start": 1.0 / 24.0},
}


@pytest.mark.parametrize("rig", RIGS)
def test_rigs(tmp_path, rig):
    motion = motion_of(fps=24.0 if "late" in rig else 30.0)
    path = person(motion, BODY, **RIGS[rig]).glb(tmp_path / "a.glb")
    assert off(read(path), motion) < NEAR


@pytest.mark.parametrize(
    "turn", [[np.pi / 2, 0, 0], [0, np.pi / 2, 0], [0, 0, np.pi], [0.9, -1.1, 0.5]]
)
@pytest.mark.parametrize("stature", [None, 1.5])
def test_joints_of_smplx_whose_bind_pose_is_turned(tmp_path, turn, stature):
    """Programs put the world's axes, or any, into the space of the mesh: the motion is the same."""
    body, motion = hp.Body.default(stature=stature), motion_of()
    names = dict(enumerate(JOINT_NAMES))
    turned = rot.rotvec_to_matrix(np.array(turn, dtype=float))
    path = person(motion, body, names=names, turned=turned).glb(tmp_path / "a.glb")
    with pytest.warns(HalfPhysicsWarning, match=r"turned by \d+ degrees: turned back; y up"):
        found = hp.Motion.load(path)
    assert np.abs(body.vertices(found) - body.vertices(motion)).max() < SINGLE
    own = quiet(path).bodies[0] or BODY
    assert np.abs(own.rest_joints - body.rest_joints).max() < SINGLE


def test_what_is_done_is_told_once_and_up_can_be_said(tmp_path):
    names = {j: n for j, n in MIXAMO.items() if "Hand" not in n} | {JOINT_INDEX["jaw"]: "Hat"}
    path = person(motion_of(), BODY, names=names, unit=50.0).glb(tmp_path / "a.glb")
    with pytest.warns(HalfPhysicsWarning) as caught:
        hp.Motion.load(path)
    assert len(caught) == 1
    said = str(caught[0].message)
    assert "put on the default body by joint names; unit m" in said
    assert "y up" in said
    assert "left_wrist, right_wrist, all fingers" in said
    assert said.endswith("not used of the file: Hat")


@pytest.mark.parametrize("clip", ["dab", "jesse_dance"])
@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_a_real_skeleton_is_read_as_from_its_bvh_file(shared_data, tmp_path, clip):
    path = shared_data / "motion" / f"animdraw_{clip}.bvh"
    bvh = read_bvh(path)
    joints = animated(bvh, slice(0, 60))
    builder, nodes = Builder(), []
    animation = builder.animation("take")
    times = np.arange(len(joints.positions)) / bvh.fps
    inverse = np.tile(np.eye(4), (len(joints.names), 1, 1))
    rest = np.zeros((len(joints.names), 3))
    for joint, parent in enumerate(joints.parents):
        world, place = joints.quaternions[:, joint], joints.positions[:, joint]
        if parent >= 0:
            rest[joint] = rest[parent] + joints.offsets[joint]
            into = rot.conjugate(joints.quaternions[:, parent])
            world = rot.multiply(into, world)
            place = rot.rotate(into, place - joints.positions[:, parent])
        nodes.append(builder.node(nodes[parent] if parent >= 0 else None, name=joints.names[joint]))
        builder.animate(animation, nodes[joint], "rotation", times, world)
        builder.animate(animation, nodes[joint], "translation", times, place)
    for joint, end in joints.ends.items():
        nodes.append(builder.node(nodes[joint], name=f"{joints.names[joint]}_end"))
        builder.json["nodes"][nodes[-1]]["translation"] = end.tolist()
        rest = np.vstack([rest, rest[joint] + end])
        inverse = np.concatenate([inverse, np.eye(4)[None]])
    inverse[:, :3, 3] = -rest
    columns = builder.accessor(np.swapaxes(inverse, 1, 2).reshape(-1, 16), "MAT4")
    builder.json["skins"] = [{"joints": nodes, "inverseBindMatrices": columns}]
    asked = hp.Motion.load(path, frames=(0, 60))
    found = hp.Motion.load(builder.glb(tmp_path / "a.glb"))
    assert off(found, asked) < SINGLE


def test_skins_of_parts_are_one_person(tmp_path):
    motion = motion_of()
    builder = person(motion, BODY, seed=1)
    skin = builder.json["skins"].pop()
    names = [builder.json["nodes"][joint]["name"] for joint in skin["joints"]]
    columns = np.frombuffer(
        bytes(builder.data[builder.json["bufferViews"][-1]["byteOffset"] :][: 64 * len(names)]),
        "<f4",
    ).reshape(-1, 16)
    for part in (
        "LeftUpLeg LeftLeg LeftFoot LeftToeBase",
        "RightUpLeg RightLeg RightFoot RightToeBase",
    ):
        rows = [names.index(name) for name in part.split()]
        add_skin(builder, [skin["joints"][k] for k in rows], columns[rows])
    away = ("Leg", "Foot", "Toe")
    rows = [k for k, name in enumerate(names) if not any(part in name for part in away)]
    add_skin(builder, [skin["joints"][k] for k in rows], columns[rows])
    assert off(read(builder.glb(tmp_path / "a.glb")), motion) < NEAR


def add_skin(builder: Builder, joints: list[int], columns: np.ndarray) -> None:
    matrices = builder.accessor(columns, "MAT4")
    builder.json["skins"].append({"joints": joints, "inverseBindMatrices": matrices})


def test_rigs_in_centimetres_without_a_scale_are_found_by_their_legs(tmp_path):
    motion = motion_of()
    builder = person(motion, BODY, unit=100.0, seed=1)
    for node in builder.json["nodes"]:
        node.pop("scale", None)
    assert off(read(builder.glb(tmp_path / "a.glb")), motion) < NEAR


def test_text_with_a_buffer_beside_it(tmp_path):
    motion = motion_of()
    path = person(motion, BODY, seed=2).gltf(tmp_path / "a.gltf", "a%20b.bin")
    (tmp_path / "a b.bin").write_bytes((tmp_path / "a%20b.bin").read_bytes())
    assert off(read(path), motion) < NEAR
    (tmp_path / "a b.bin").unlink()
    (tmp_path / "a%20b.bin").unlink()
    with pytest.raises(HalfPhysicsError, match=r"a b.bin is not beside it. Copy it there"):
        read(path)


def test_text_beyond_the_size_of_other_json(tmp_path, monkeypatch):
    """The reader of glTF has a bound of its own."""
    motion = motion_of()
    hp.export(motion, tmp_path / "a.gltf")
    monkeypatch.setattr(foreign_json, "MAX_BYTES", 1000)
    assert off(read(tmp_path / "a.gltf"), motion) < SINGLE


def test_several_animations_are_clips(tmp_path):
    motions = [motion_of(), motion_of(12, seed=4)]
    builder = Builder()
    nodes = add_person(builder, builder.animation("walk"), motions[0], BODY, seed=2)
    again = Builder()
    add_person(again, again.animation("run"), motions[1], BODY, seed=2)
    run = builder.animation("run")
    for channel in again.json["animations"][0]["channels"]:
        sampler = again.json["animations"][0]["samplers"][channel["sampler"]]
        arrays = {}
        for end in ("input", "output"):
            accessor = again.json["accessors"][sampler[end]]
            view = again.json["bufferViews"][accessor["bufferView"]]
            raw = bytes(again.data[view["byteOffset"] :][: view["byteLength"]])
            arrays[end] = np.frombuffer(raw, "<f4").reshape(accessor["count"], -1)
        values = arrays["output"]
        path = channel["target"]["path"]
        if path == "rotation":
            values = values[:, [3, 0, 1, 2]]
        builder.animate(run, channel["target"]["node"], path, arrays["input"][:, 0], values)
    assert len(nodes) == len(MIXAMO)
    path = builder.glb(tmp_path / "a.glb")
    assert [clip.name for clip in hp.clips(path)] == ["walk", "run"]
    for name, motion in zip(("walk", "run"), motions, strict=True):
        assert off(read(path, clip=name), motion) < NEAR
    with pytest.raises(HalfPhysicsError, match="several clips: walk, run"):
        read(path)


def test_two_people_and_things_of_another_program(tmp_path):
    people = [motion_of(seed=5), motion_of(seed=6)]
    builder = Builder()
    animation = builder.animation("take")
    for index, motion in enumerate(people):
        add_person(builder, animation, motion, BODY, seed=index, prefix=f"p{index}:")
    corners = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]], dtype=float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    builder.json["meshes"] = [
        {
            "primitives": [
                {
                    "attributes": {"POSITION": builder.accessor(corners, "VEC3")},
                    "indices": builder.accessor(faces.reshape(-1, 1), "SCALAR", 5121),
                }
            ]
        }
    ]
    thing = builder.node(name="mug", mesh=0, scale=[2.0, 2.0, 2.0], translation=[0.0, 1.0, 0.0])
    t = np.arange(16)[:, None] / 30.0
    places = np.array([0.5, 1.0, 0.2]) + t * [0.1, 0.3, -0.2]
    builder.animate(animation, thing, "translation", t[:, 0], places)
    builder.node(name="rock", mesh=0, translation=[3.0, 0.0, 0.0])
    builder.node(builder.json["skins"][0]["joints"][5], name="hat", mesh=0)
    sequence = quiet(builder.glb(tmp_path / "a.glb"), ground=False, adapt=False)
    for motion, asked in zip(sequence.motions, people, strict=True):
        assert off(motion, asked) < NEAR
    assert list(sequence.scene.objects) == ["mug"]
    assert list(sequence.scene.statics) == ["rock"]
    item, track = sequence.scene.objects["mug"], sequence.recorded["mug"]
    asked = (2.0 * corners + places[7]) @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=float)
    found = rot.rotate(track.quaternion[7], item.visual.vertices) + track.position[7]
    away = np.linalg.norm(found[:, None] - asked[None], axis=-1)
    assert max(away.min(axis=0).max(), away.min(axis=1).max()) < NEAR


@pytest.mark.parametrize("moves", [(True, False), (False, True), (False, False)])
def test_people_who_do_not_move_are_people(tmp_path, moves):
    """What does not move has no keys in files of `hp.export`: such people became 55 statics."""
    people = [motion_of(seed=seed) for seed in (5, 6)]
    still = np.zeros(16, dtype=int)
    people = [
        m if moving else m.with_frames(m.translation[still], m.rotations[still])
        for m, moving in zip(people, moves, strict=True)
    ]
    hp.export(hp.Sequence(tuple(people), hp.Scene()), tmp_path / "a.glb")
    sequence = quiet(tmp_path / "a.glb")
    for motion, asked in zip(sequence.motions, people, strict=True):
        assert off(motion, asked) < SINGLE
    assert not sequence.scene.statics
    first = next((k for k, moving in enumerate(moves) if moving), 0)
    assert off(read(tmp_path / "a.glb"), people[first]) < SINGLE


def test_people_of_other_clips_are_not_in_this_one(tmp_path):
    motions, builder = [motion_of(seed=5), motion_of(seed=6)], Builder()
    for index, motion in enumerate(motions):
        take = builder.animation(f"take {index}")
        add_person(builder, take, motion, BODY, prefix=f"p{index}:")
    path = builder.glb(tmp_path / "a.glb")
    for index, motion in enumerate(motions):
        (found,) = quiet(path, clip=f"take {index}").motions
        assert off(found, motion) < NEAR
        assert off(read(path, clip=f"take {index}"), motion) < NEAR


@pytest.mark.parametrize("frames", [None, (4, 14)])
def test_people_whose_keys_begin_and_end_at_different_times(tmp_path, frames):
    """Everyone is read at the same times, and holds still before and after their own keys."""
    early, late, builder = motion_of(16, seed=5), motion_of(12, seed=6), Builder()
    animation = builder.animation("take")
    for index, (motion, start) in enumerate(((early, 0), (late, 8))):
        options = {"start": start / 30.0, "prefix": f"p{index}:"}
        add_person(builder, animation, motion, BODY, **options)
    sequence = quiet(builder.glb(tmp_path / "a.glb"), frames=frames)
    for found, motion, start in zip(sequence.motions, (early, late), (0, 8), strict=True):
        rows = np.clip(np.arange(20) - start, 0, len(motion) - 1)[slice(*(frames or (None,)))]
        asked = motion.with_frames(motion.translation[rows], motion.rotations[rows])
        assert off(found, asked) < NEAR


def test_a_cabinet_with_a_skin_is_cut_at_its_door(tmp_path):
    """One mesh on two joints, in frames of their own: the door turns, the box stands."""
    builder = Builder()
    animation = builder.animation("take")
    add_person(builder, animation, motion_of(), BODY)
    corners = np.array([[0, 0, 0], [0.4, 0, 0], [0, 0.5, 0], [0, 0, 0.3]], dtype=float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    hinge = np.array([0.5, 0.2, 0.0])
    frame = rot.exp([0.3, 0.4, -0.5])  # of the door's joint at the bind pose
    places = np.concatenate([corners, corners + hinge])
    weights, joints = np.zeros((8, 4)), np.zeros((8, 4))
    weights[:, 0], weights[:, 1], joints[4:, 0], joints[:4, 1] = 0.9, 0.1, 1, 1
    inverse = np.tile(np.eye(4), (2, 1, 1))
    inverse[1, :3, :3] = rot.to_matrix(frame).T
    inverse[1, :3, 3] = -inverse[1, :3, :3] @ hinge
    attributes = {
        "POSITION": builder.accessor(places, "VEC3"),
        "JOINTS_0": builder.accessor(joints, "VEC4", 5121),
        "WEIGHTS_0": builder.accessor(weights, "VEC4"),
    }
    indices = builder.accessor(np.concatenate([faces, faces + 4]).reshape(-1, 1), "SCALAR", 5123)
    builder.json["meshes"] = [{"primitives": [{"attributes": attributes, "indices": indices}]}]
    box = builder.node(name="box", translation=[2.0, 0.0, 0.0])
    door = builder.node(box, name="door", translation=hinge.tolist())
    turns = rot.multiply(rot.exp(np.linspace(0, 1, 16)[:, None] * np.array([0.0, 1.0, 0.0])), frame)
    builder.animate(animation, door, "rotation", np.arange(16) / 30.0, turns)
    columns = builder.accessor(np.swapaxes(inverse, 1, 2).reshape(-1, 16), "MAT4")
    builder.json["skins"].append({"joints": [box, door], "inverseBindMatrices": columns})
    builder.node(name="cabinet", mesh=0, skin=1)
    builder.node(name="copy", mesh=0, scale=[-1.0, 2.0, 1.0], translation=[0.0, 0.0, 3.0])
    path = builder.glb(tmp_path / "a.glb")
    with pytest.warns(HalfPhysicsWarning, match="joins the parts of 'cabinet' is not known"):
        scene = (sequence := hp.load_sequence(path, ground=False, adapt=False)).scene
    assert sorted(scene.statics) == ["cabinet_box", "copy"]
    assert list(scene.objects) == ["cabinet_door"]
    file = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=float)  # file from world
    track, item = sequence.recorded["cabinet_door"], scene.objects["cabinet_door"]
    own = rot.rotate(rot.multiply(turns[9], rot.conjugate(frame)), corners) + hinge + [2.0, 0, 0]
    found = rot.rotate(track.quaternion[9], item.visual.vertices) + track.position[9]
    away = np.linalg.norm(found[:, None] - (own @ file)[None], axis=-1)
    assert max(away.min(axis=0).max(), away.min(axis=1).max()) < SINGLE
    copy = scene.statics["copy"]
    found = rot.rotate(copy.quaternion, copy.shape.vertices) + copy.position
    own = (places * [-1.0, 2.0, 1.0] + [0.0, 0.0, 3.0]) @ file
    away = np.linalg.norm(found[:, None] - own[None], axis=-1)
    assert max(away.min(axis=0).max(), away.min(axis=1).max()) < SINGLE
    assert copy.shape.volume > 0.0  # mirrored with its triangles the right way round


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_keys_at_no_even_rate_are_sampled(tmp_path):
    motion = motion_of(60)
    builder = Builder()
    animation = builder.animation("made by hand")
    add_person(builder, animation, motion, BODY)
    times = np.sort(np.random.default_rng(0).uniform(0.0, 2.0, 60)).astype(np.float32)
    for sampler in animation["samplers"]:
        sampler["input"] = builder.accessor(times[:, None], "SCALAR")
    path = builder.glb(tmp_path / "a.glb")
    with pytest.warns(HalfPhysicsWarning, match=r"no even rate: read at 30 fps \(fps=\)"):
        slow = hp.Motion.load(path)
    assert slow.fps == 30.0
    fast = read(path, fps=90.0)
    assert fast.fps == 90.0
    assert off(fast[::3], slow) < SINGLE

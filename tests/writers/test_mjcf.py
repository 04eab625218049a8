"""MJCF with keyframes, opened by MuJoCo."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.mjcf_person import addresses
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.result import ObjectTrack
from halfphysics.simulation.sequence import Sequence
from support.files.layouts import movement
from support.results import takes

#: MuJoCo's own kinematics of the same numbers: positions [m], rotations.
SAME = 1e-6


def opened(path):
    model = mujoco.MjModel.from_xml_path(str(path))
    return model, mujoco.MjData(model)


def at_key(model, data, k):
    mujoco.mj_resetDataKeyframe(model, data, k)
    mujoco.mj_forward(model, data)


def far(data, body, position, quaternion) -> float:
    """Difference of MuJoCo's body from a pose: the larger of [m] and of its matrix."""
    matrix = data.xmat[body].reshape(3, 3)
    turn = np.abs(matrix - rot.to_matrix(rot.normalize(quaternion))).max()
    return max(turn, np.abs(data.xpos[body] - position).max())


def written(what, path, **options):
    with pytest.warns(HalfPhysicsWarning, match="room, sheet: not convex"):
        hp.export(what, path, **options)
    return opened(path)


@pytest.mark.parametrize("people", [1, 2])
def test_every_frame_is_a_keyframe(tmp_path, people):
    result = takes.result(people)
    model, data = written(result, tmp_path / "a.xml")
    assert model.nkey == len(result.motion if people == 1 else result.people[0].motion)
    assert np.allclose(model.key_time, np.arange(model.nkey) / 30.0, atol=1e-12)
    joints = [p.body.joint_frames(p.motion) for p in result.people]
    for k in range(model.nkey):
        at_key(model, data, k)
        for person, (position, quaternion) in zip(result.people, joints, strict=True):
            bodies = addresses(model, f"{person.name}/").body
            for joint in range(55):
                assert far(data, bodies[joint], position[k, joint], quaternion[k, joint]) < SAME
        for name, track in result.objects.items():
            body = model.body("world/" if name == "world" else name).id
            assert far(data, body, track.position[k], track.quaternion[k]) < SAME, name
    # They moved: the test could fail.
    for name in ("ball", "lift", "cabinet/door"):
        track = result.objects[name]
        assert np.abs(np.hstack([track.position, track.quaternion])).std(axis=0).max() > 1e-3
    for name, static in result.scene.statics.items():
        assert far(data, model.body(name).id, static.position, static.quaternion) < SAME


def test_velocities_lead_to_the_frame_after(tmp_path):
    model, _ = written(takes.result(), tmp_path / "a.xml")
    for k in range(model.nkey - 1):
        qpos = model.key_qpos[k].copy()
        mujoco.mj_integratePos(model, qpos, model.key_qvel[k], 1.0 / 30.0)
        after = model.key_qpos[k + 1]
        quats = [model.jnt_qposadr[j] + 3 * (model.jnt_type[j] == 0) for j in range(model.njnt)
                 if model.jnt_type[j] in (0, 1)]  # fmt: skip
        for q in quats:
            qpos[q : q + 4] *= np.sign(qpos[q : q + 4] @ after[q : q + 4])
        assert np.abs(qpos - after).max() < SAME


def test_what_touches_is_what_touched(tmp_path):
    result = takes.result()
    model, data = written(result, tmp_path / "a.xml")
    scene = result.scene
    geoms = {mujoco.mjtGeom(int(t)).name.removeprefix("mjGEOM_").lower() for t in model.geom_type}
    assert geoms == {"plane", "cylinder", "box", "sphere", "capsule", "mesh"}
    for name, thing in scene.objects.items():
        body = model.body("world/" if name == "world" else name)
        touching = [g for g in np.flatnonzero(model.geom_bodyid == body.id)
                    if model.geom_contype[g]]  # fmt: skip
        assert len(touching) == len(thing.pieces)
        if name == "lift":
            assert body.mocapid[0] >= 0
            continue
        assert body.mass[0] == pytest.approx(thing.mass, rel=1e-12)
        assert np.allclose(body.ipos, thing.com, atol=1e-12)
        turn = rot.to_matrix(body.iquat)
        assert np.allclose(turn @ np.diag(body.inertia) @ turn.T, thing.inertia, rtol=1e-9)
    # Corners of the pieces are at the same places as in the object.
    at_key(model, data, 5)
    track = result.objects["pair"]
    corners = []
    for g in np.flatnonzero(model.geom_bodyid == model.body("pair").id):
        mesh = model.geom_dataid[g]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        own = model.mesh_vert[first : first + count].astype(float)
        corners.append(own @ data.geom_xmat[g].reshape(3, 3).T + data.geom_xpos[g])
    asked = takes.corner().vertices @ rot.to_matrix(track.quaternion[5]).T + track.position[5]
    found = np.vstack(corners)
    near = np.linalg.norm(found[:, None] - asked[None], axis=2)
    assert near.min(axis=0).max() < SAME
    assert near.min(axis=1).max() < SAME
    # Ignored pairs are excluded, and the plane keeps its place.
    pairs = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
    post, head = model.body("post").id, model.body("person/head").id
    for joint in JOINT_NAMES:
        pair = sorted((post, model.body(f"person/{joint}").id))
        assert tuple(pair) in pairs or tuple(pair[::-1]) in pairs
    ball = model.body("ball").id
    assert {(ball, head), (head, ball)} & pairs
    floor = next(g for g in range(model.ngeom) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE)
    normal = data.geom_xmat[floor].reshape(3, 3)[:, 2]
    plane = scene.statics["floor"]
    assert np.allclose(normal, rot.rotate(plane.quaternion, plane.shape.normal), atol=1e-9)
    assert normal @ data.geom_xpos[floor] == pytest.approx(plane.shape.offset)


def test_pairs_keep_a_friction_of_their_own(tmp_path):
    scene = takes.scene()
    scene.friction("ball", "lift", 0.0)
    scene.friction("cabinet", "ball", 0.25)
    scene.friction("person/head", "pair", 0.2)  # instead of what is said of all parts
    scene.friction("person", "pair", 1.5)
    scene.friction("floor", "step", 0.7)  # neither moves
    scene.friction("post", "person/head", 0.9)  # ignored
    model, _ = written(Sequence(hp.Motion(*movement(5), 30.0), scene), tmp_path / "a.xml")
    of = [model.body(int(b)).name for b in model.geom_bodyid]
    found = {}
    for k in range(model.npair):
        pair = sorted([of[model.pair_geom1[k]], of[model.pair_geom2[k]]])
        found.setdefault(tuple(pair), set()).add(tuple(model.pair_friction[k]))
    rest = (0.005, 0.0001, 0.0001)
    parts = {of[g] for g in range(model.ngeom) if of[g].startswith("person/")}
    assert len(parts) > 50
    assert found == {
        ("ball", "lift"): {(0.0, 0.0, *rest)},
        **{
            ("ball", link): {(0.25, 0.25, *rest)}
            for link in scene.articulated["cabinet"].link_names
        },
        **{("pair", part): {(1.5, 1.5, *rest)} for part in parts},
        ("pair", "person/head"): {(0.2, 0.2, *rest)},
    }


def test_stock_mujoco_steps_it(tmp_path):
    model, data = written(takes.result(), tmp_path / "a.xml")
    mujoco.mj_resetDataKeyframe(model, data, 0)
    start = data.body("ball").xpos.copy()
    for _ in range(50):
        mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all()
    assert not data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number
    assert np.linalg.norm(data.body("ball").xpos - start) > 0.05


def test_fewer_keyframes(tmp_path):
    result = takes.result()
    model, data = written(result, tmp_path / "a.xml", fps=10.0)
    assert model.nkey == 5
    values = result.joints["cabinet/hinge"]
    for k in range(5):
        at_key(model, data, k)
        assert model.key_time[k] == pytest.approx(k / 10.0)
        assert data.joint("cabinet/hinge").qpos[0] == pytest.approx(values[3 * k], abs=SAME)
        position, _ = result.people[0].body.joint_frames(result.motion)
        assert np.abs(data.body("person/head").xpos - position[3 * k, 15]).max() < SAME


def test_motions_and_sequences(tmp_path):
    motion = hp.Motion(*movement(), 30.0)
    hp.export(motion, tmp_path / "a.xml")
    model, data = opened(tmp_path / "a.xml")
    assert (model.nbody, model.nkey) == (56, len(motion))
    # An articulated object that was recorded by its links moves as they did.
    scene = takes.scene(meshes=False)
    links = scene.articulated["cabinet"].link_names
    turns = rot.exp(motion.rotations)
    tracks = {
        name: ObjectTrack(position=motion.translation + i, quaternion=turns[:, i])
        for i, name in enumerate(links)
    }
    hp.export(Sequence(motion, scene, recorded=tracks), tmp_path / "b.xml")
    model, data = opened(tmp_path / "b.xml")
    at_key(model, data, 4)
    for name, track in tracks.items():
        assert far(data, model.body(name).id, track.position[4], track.quaternion[4]) < SAME
    # An object without a recording keeps its start pose.
    hp.export(Sequence(motion, scene), tmp_path / "c.xml")
    model, data = opened(tmp_path / "c.xml")
    at_key(model, data, 4)
    assert data.joint("cabinet/slide").qpos[0] == pytest.approx(0.1)
    assert data.joint("cabinet/hinge").qpos[0] == pytest.approx(np.deg2rad(5.0))
    assert far(data, model.body("ball").id, scene.objects["ball"].position, [1, 0, 0, 0]) < SAME


def test_names_of_pieces_are_nobody_else_s(tmp_path):
    scene = hp.Scene()
    mesh = hp.Mesh(*hp.Box((0.2, 0.2, 0.2)).triangles())
    scene.add_object("ball", mesh, mass=1.0, position=(0.0, 2.0, 0.2))
    scene.add_static("ball#0", mesh, position=(0.0, 3.0, 0.2))
    hp.export(Sequence(hp.Motion(*movement(5), 30.0), scene), tmp_path / "a.xml")
    mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))


def test_what_cannot_be_written(tmp_path):
    motion = hp.Motion(*movement(), 30.0)
    with pytest.raises(FileError, match="does not exist"):
        hp.export(motion, tmp_path / "none" / "a.xml")
    thin = hp.Scene()
    thin.add_object("dust", hp.Sphere(1e-6), mass=1e-12, position=[0, 0, 9])
    with pytest.raises(InputError, match=r"a\.xml: MuJoCo cannot compile"):
        hp.export(Sequence(motion, thin), tmp_path / "a.xml")
    assert not list(tmp_path.iterdir())

"""A result in a viser scene: its nodes, their places, and which can be hidden and moved."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.viewer.bones import GRAIN
from halfphysics.viewer.figure import Figure, _gathered, moving_joints, shrunk, strongest
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.stage import Stage
from support.results.small_result import FRAMES, small_result


@pytest.fixture(scope="module")
def server():
    made = open_server("127.0.0.1", 0)
    yield made
    close_server(made)


@pytest.fixture(scope="module")
def stage(server):
    return Stage(server, small_result())


def bones(server, name):
    """Positions of the bones of a mesh, as a newly connected browser gets them."""
    buffer = server._websock_server.get_message_buffer()
    import msgspec

    found = {}
    for message in list(buffer.message_from_id.values()):
        data = getattr(message, "_data", None)
        read = msgspec.msgpack.decode(data) if data else {}
        if read.get("name") == name and "position" in read:
            found[read["bone_index"]] = read["position"]
    return np.array([found[k] for k in sorted(found)])


def test_nodes_and_layers(stage):
    assert len(stage) == FRAMES
    assert stage.path("person/0") == "/person/0"
    assert list(stage.layers) == ["body", "ghost", "objects", "scene"]
    assert [layer.visible for layer in stage.layers.values()] == [True] * 4
    assert stage.object("ball").name == "/object/ball"
    assert stage.static("wall").name == "/static/wall"


@pytest.mark.parametrize("frame", [0, 7, FRAMES - 1])
def test_a_frame_puts_everybody_where_they_were(server, stage, frame):
    followed = []
    stage.followers.append(followed.append)
    stage.show(frame)
    stage.followers.clear()
    assert followed == [frame] == [stage.frame]
    person = small_result().people[0]
    for kind, motion, figure in (
        ("person", person.motion, stage.people[0]),
        ("ghost", person.reference, stage.ghosts[0]),
    ):
        wanted = person.body.joints(motion)[frame][figure.joints]
        np.testing.assert_allclose(bones(server, f"/{kind}/0"), wanted, atol=GRAIN)
    ball = small_result().objects["ball"].position[frame]
    np.testing.assert_allclose(stage.object("ball").position, ball, atol=GRAIN)


def test_frames_beyond_the_ends_are_the_ends(stage):
    stage.show(999)
    assert stage.frame == FRAMES - 1
    stage.show(-5)
    assert stage.frame == 0


def test_what_is_hidden_is_not_sent_and_right_when_shown(server, stage):
    stage.show(0)
    ghost = stage.layers["ghost"]
    ghost.visible = False
    before = bones(server, "/ghost/0")
    stage.show(FRAMES - 1)
    np.testing.assert_array_equal(bones(server, "/ghost/0"), before)
    assert not stage.ghosts[0].handle.visible
    ghost.visible = True
    person = small_result().people[0]
    wanted = person.body.joints(person.reference)[-1][stage.ghosts[0].joints]
    np.testing.assert_allclose(bones(server, "/ghost/0"), wanted, atol=GRAIN)
    assert stage.ghosts[0].handle.visible


def test_layers_hide_their_parts(stage):
    for name, handle in (("objects", stage.object("ball")), ("scene", stage.static("wall"))):
        stage.layers[name].visible = False
        assert not handle.visible
        stage.layers[name].visible = True
        assert handle.visible


def test_live_poses_and_places(server):
    live = Stage(server, small_result(), "/live", (3.0, 0.0, 0.0), live=True)
    assert len(live.people[0].joints) == N_JOINTS
    body = live.people[0].body
    rotations = np.zeros((N_JOINTS, 3))
    rotations[JOINT_INDEX["left_index1"], 2] = 0.7
    from halfphysics.motion.pose import Pose

    positions, quaternions = body.joint_frames(Pose(np.array([1.0, 2.0, 3.0]), rotations))
    live.pose(0, positions, quaternions)
    np.testing.assert_allclose(bones(server, "/live/person/0"), positions, atol=GRAIN)
    live.place("ball", np.array([0.0, 1.0, 2.0]), np.array([1.0, 0, 0, 0]))
    np.testing.assert_array_equal(live.object("ball").position, [0.0, 1.0, 2.0])
    with pytest.raises(InputError, match="expected one of ball"):
        live.place("bal", np.zeros(3), np.array([1.0, 0, 0, 0]))
    live.visible = False
    assert not live.visible


def test_hiding_needs_a_node_of_its_own(server, stage):
    with pytest.raises(InputError, match="prefix"):
        stage.visible = False
    with pytest.raises(InputError, match="prefix"):
        Stage(server, small_result(), offset=(1.0, 0.0, 0.0))


def test_things_left_out_and_glass(server):
    made = Stage(server, small_result(), "/some", without=["static/bench"], faint=["static/wall"])
    assert made.static("wall").opacity < 0.5
    with pytest.raises(KeyError):
        made.static("bench")


def test_joints_that_stay_need_no_bone_and_the_skin_is_the_same(server):
    """Still fingers: skinned with fewer bones, every vertex is where all 55 bones put it."""
    person = small_result().people[0]
    _, quaternions = person.body.joint_frames(person.motion)
    joints = moving_joints(quaternions)
    assert 0 in joints
    assert len(joints) == 5  # pelvis, hips and shoulders
    weights = np.asarray(person.body.weights)
    merged = _gathered(weights, joints)
    np.testing.assert_allclose(merged.sum(axis=1), weights.sum(axis=1), atol=1e-9)
    positions, quaternions = (a[9] for a in person.body.joint_frames(person.motion))
    rest = np.asarray(person.body.rest_joints)

    def skinned(weights, joints):
        local = person.body.rest_vertices[:, None] - rest[joints]
        moved = rot.rotate(quaternions[joints], local) + positions[joints]
        return np.einsum("vj,vjk->vk", weights, moved)

    np.testing.assert_allclose(
        skinned(merged, joints), skinned(weights, np.arange(N_JOINTS)), atol=1e-9
    )


def test_a_joint_that_turns_once_has_its_bone():
    quaternions = np.zeros((4, N_JOINTS, 4))
    quaternions[..., 0] = 1.0
    assert list(moving_joints(quaternions)) == [0]
    elbow = JOINT_INDEX["left_elbow"]
    quaternions[2, elbow] = rot.exp(np.array([0.0, 0.0, 0.01]))
    quaternions[1] *= -1.0  # the same rotations
    hand = JOINT_INDEX["left_wrist"]
    assert list(moving_joints(quaternions)) == [0, elbow, hand]


def test_weights_keep_the_four_strongest():
    rng = np.random.default_rng(0)
    weights = rng.random((50, 55))
    kept = strongest(weights)
    np.testing.assert_allclose(kept.sum(axis=1), 1.0, rtol=1e-12)
    assert ((kept > 0).sum(axis=1) == 4).all()
    order = np.argsort(-weights, axis=1)
    assert (np.take_along_axis(kept, order[:, :4], axis=1) > 0).all()


def test_shrinking_a_cube_moves_its_faces_in():
    from halfphysics.geometry.shapes import Box

    vertices, faces = Box((2.0, 2.0, 2.0)).triangles()
    inner = shrunk(vertices, faces, 0.003)
    np.testing.assert_allclose(np.linalg.norm(vertices - inner, axis=1), 0.003, rtol=1e-9)
    assert (np.abs(inner) < 1.0).all()


def test_a_ghost_leaves_its_depth(server):
    from dataclasses import replace

    from halfphysics.render.result_meshes import Drawing

    body = Body.default()
    skin = replace(Drawing(small_result()).skin(0, True), vertices=body.rest_vertices)
    figure = Figure(server, "/glass", skin, body)
    assert [m.opacity for m in figure._meshes] == [0.0, skin.alpha]
    figure.visible = False
    assert [m.visible for m in figure._meshes] == [False, False]

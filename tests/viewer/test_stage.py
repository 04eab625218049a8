"""A result in a viser scene: its nodes, their places, and which can be hidden and moved."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from halfphysics.render.look import GHOST_ALPHA
from halfphysics.render.result_meshes import Drawing
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
        for name, handle in figure.handles.items():
            if handle.visible:
                found = bones(server, f"/{kind}/0/{name}")
                np.testing.assert_allclose(found, wanted[figure.bones_of(name)], atol=GRAIN)
    # The ghost is 12 cm from the body from frame 6 on.
    assert {h.visible for h in stage.ghosts[0].handles.values()} == {frame >= 6}
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
    before = bones(server, "/ghost/0/trunk")
    stage.show(FRAMES - 1)
    np.testing.assert_array_equal(bones(server, "/ghost/0/trunk"), before)
    assert not stage.ghosts[0].node.visible
    ghost.visible = True
    person = small_result().people[0]
    figure = stage.ghosts[0]
    wanted = person.body.joints(person.reference)[-1][figure.joints]
    found = bones(server, "/ghost/0/trunk")
    np.testing.assert_allclose(found, wanted[figure.bones_of("trunk")], atol=GRAIN)
    assert figure.node.visible


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
    for name in live.people[0].handles:
        wanted = positions[live.people[0].bones_of(name)]
        np.testing.assert_allclose(bones(server, f"/live/person/0/{name}"), wanted, atol=GRAIN)
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


def ghost(server, name):
    body = Body.default()
    return Figure(server, name, Drawing(small_result()).skin(0, True), body)


def test_parts_of_a_ghost_fade_with_their_distance(server):
    figure = ghost(server, "/faint")
    assert not any(handle.visible for handle in figure.handles.values())
    apart = dict.fromkeys(figure.handles, 0.005) | {"left-hand": 0.2, "trunk": 0.02}
    figure.fade(apart)
    shown = {name: h.opacity for name, h in figure.handles.items() if h.visible}
    assert shown == {"left-hand": GHOST_ALPHA, "trunk": pytest.approx(0.5 * GHOST_ALPHA)}
    figure.fade(dict.fromkeys(figure.handles, 0.0))
    assert not any(handle.visible for handle in figure.handles.values())


def test_a_part_that_appears_is_where_it_should_be(server):
    """Poses are not sent while a part is hidden: the present one is sent when it appears."""
    figure = ghost(server, "/late")
    person = small_result().people[0]
    positions, quaternions = (a[3] for a in person.body.joint_frames(person.motion))
    figure.pose(positions, quaternions)
    assert len(bones(server, "/late/trunk")) == 0
    figure.fade(dict.fromkeys(figure.handles, 1.0))
    wanted = positions[figure.bones_of("trunk")]
    np.testing.assert_allclose(bones(server, "/late/trunk"), wanted, atol=GRAIN)


def test_pieces_have_only_the_bones_that_move_them(server):
    figure = Figure(server, "/dressed", Drawing(small_result()).skin(0, False), Body.default())
    assert list(figure.handles) == ["shirt", "trousers", "skin", "shoes", "hair"]
    names = {n: {JOINT_NAMES[k] for k in figure.bones_of(n)} for n in figure.handles}
    assert {"left_ankle", "right_foot"} <= names["shoes"]
    assert not names["shoes"] & {"spine3", "left_wrist", "head"}
    assert "left_index3" in names["skin"]
    assert sum(map(len, names.values())) < 1.7 * N_JOINTS


def test_the_edges_of_statics_are_one_node(server):
    made = Stage(server, small_result(), "/lined")
    node = server.scene._handle_from_node_name["/lined/edges"]
    assert node.points.shape == (24, 2, 3)  # a wall and a bench
    made.layers["scene"].visible = False
    assert not node.visible

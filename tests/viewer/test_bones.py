"""Pose messages: short, complete, equal to those of viser's own setters."""

from __future__ import annotations

import contextlib
import dataclasses

import msgspec
import numpy as np
import pytest
import viser
import zstandard

from halfphysics.base import rotations as rot
from halfphysics.viewer.bones import GRAIN, Bones
from halfphysics.viewer.server import close_server, open_server

BONES = 7
#: A silence that shows that all has come, and how long to wait for something [s].
PAUSE, PATIENCE = 1.0, 60.0


@pytest.fixture(scope="module")
def server():
    made = open_server("127.0.0.1", 0)
    yield made
    close_server(made)


def mesh(server, name):
    rng = np.random.default_rng(0)
    rest = np.zeros((BONES, 4))
    rest[:, 0] = 1.0
    return server.scene.add_mesh_skinned(
        name,
        rng.random((30, 3)),
        rng.integers(0, 30, (20, 3)),
        bone_wxyzs=rest,
        bone_positions=np.zeros((BONES, 3)),
        skin_weights=rng.random((30, BONES)),
    )


def poses(count, seed=1):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, BONES, 3)), rot.exp(rng.normal(size=(count, BONES, 3)))


def sent(server, work):
    """The messages that `work` queues, as a browser reads them."""
    recorder = server.get_scene_serializer()
    start = len(recorder._messages)
    work()
    data = msgspec.msgpack.encode([m for _, m in recorder._messages[start:]])
    recorder.serialize()
    return msgspec.msgpack.decode(data)


def test_what_is_sent_is_what_the_setters_send(server):
    positions, quaternions = poses(3)
    read = {}
    for fast in (True, False):
        bones = Bones([mesh(server, "/same")], fast=fast)
        assert bones.fast == fast
        assert len(bones) == BONES

        def work(bones=bones):
            for p, q in zip(positions, quaternions, strict=True):
                bones.send(p, q)

        read[fast] = sent(server, work)
    assert len(read[True]) == 3 * BONES * 2

    def order(message):
        return message["type"], message["bone_index"]

    for k in range(3):
        part = slice(k * BONES * 2, (k + 1) * BONES * 2)
        assert sorted(read[True][part], key=order) == sorted(read[False][part], key=order)


def test_the_pose_arrives_within_the_grain(server):
    positions, quaternions = poses(1)
    bones = Bones([mesh(server, "/grain")])
    messages = sent(server, lambda: bones.send(positions[0], quaternions[0]))
    for field, wanted in (("position", positions[0]), ("wxyz", quaternions[0])):
        got = {m["bone_index"]: m[field] for m in messages if field in m}
        np.testing.assert_allclose([got[k] for k in range(BONES)], wanted, atol=0.5 * GRAIN + 1e-7)


@pytest.mark.parametrize("fast", [True, False])
def test_only_what_moved_is_sent(server, fast):
    positions, quaternions = poses(1)
    bones = Bones([mesh(server, "/moved")], fast=fast)
    assert bones.send(positions[0], quaternions[0]) == BONES
    assert sent(server, lambda: bones.send(positions[0], quaternions[0])) == []
    # The same rotations, named by the other quaternion.
    assert sent(server, lambda: bones.send(positions[0], -quaternions[0])) == []
    positions[0, 3, 1] += 0.01
    messages = sent(server, lambda: bones.send(positions[0], quaternions[0]))
    assert [(m["type"], m["bone_index"]) for m in messages] == [("SetBonePositionMessage", 3)]
    # Changes below the grain do not accumulate an error.
    start = positions[0, 5, 2]
    for _ in range(40):
        positions[0, 5, 2] += 0.1 * GRAIN
        bones.send(positions[0], quaternions[0])
    assert abs(bones._sent[5, 2] * GRAIN - start - 4 * GRAIN) <= GRAIN


def test_meshes_that_move_alike_get_the_same(server):
    positions, quaternions = poses(1)
    bones = Bones([mesh(server, "/a"), mesh(server, "/b")])
    messages = sent(server, lambda: bones.send(positions[0], quaternions[0]))
    a, b = ([m for m in messages if m["name"] == name] for name in ("/a", "/b"))
    assert [{**m, "name": ""} for m in a] == [{**m, "name": ""} for m in b]


def test_a_browser_that_comes_later_gets_the_last_pose_only(server):
    positions, quaternions = poses(5)
    bones = Bones([mesh(server, "/late")])
    for p, q in zip(positions, quaternions, strict=True):
        bones.send(p, q)
    kept = [
        m
        for m in server._websock_server.get_message_buffer().message_from_id.values()
        if type(m).__mro__[1].__name__ == "SetBonePositionMessage" and b"/late" in m._data
    ]
    assert len(kept) == BONES


@pytest.mark.parametrize("break_it", ["fields", "name", "interface", "window"])
def test_another_viser_gets_the_setters(server, monkeypatch, break_it):
    from viser import _messages

    handle = mesh(server, "/other")
    if break_it == "fields":

        @dataclasses.dataclass
        class Renamed:
            name: str
            bone: int
            xyz: tuple

        monkeypatch.setattr(_messages, "SetBonePositionMessage", Renamed)
    elif break_it == "name":
        monkeypatch.delattr(_messages, "SetBoneOrientationMessage")
    elif break_it == "interface":
        handle.bones[0]._impl.mesh_impl = object()
    else:
        buffer = server._websock_server.get_message_buffer()
        monkeypatch.setattr(buffer, "max_window_size", None)
    assert not Bones([handle]).fast


def test_the_setters_still_pose(server):
    positions, quaternions = poses(1)
    handle = mesh(server, "/slow")
    Bones([handle], fast=False).send(positions[0], quaternions[0])
    np.testing.assert_allclose([b.position for b in handle.bones], positions[0], atol=GRAIN)
    np.testing.assert_allclose([b.wxyz for b in handle.bones], quaternions[0], atol=GRAIN)


@pytest.mark.parametrize("fast", [True, False])
def test_a_mesh_that_is_gone_is_not_posed(server, fast):
    handle = mesh(server, "/gone")
    bones = Bones([handle], fast=fast)
    handle.remove()
    positions, quaternions = poses(1)
    with pytest.raises(RuntimeError, match="removed"):
        bones.send(positions[0], quaternions[0])


def test_a_connected_client_gets_whole_poses_and_few_bytes(server):
    """A client of its own over a real websocket: every update arrives in one piece."""
    from websockets.sync.client import connect

    figures = [Bones([mesh(server, f"/wire/{k}")]) for k in range(20)]  # 140 bones, 280 messages
    url = f"ws://127.0.0.1:{server.get_port()}"
    size = []
    with connect(url, subprotocols=[f"viser-v{viser.__version__}"], max_size=None,
                 compression=None, proxy=None) as socket:  # fmt: skip
        with contextlib.suppress(TimeoutError):  # the meshes have come, and nothing more does
            while True:
                socket.recv(timeout=PAUSE if size else PATIENCE)
                size.append(0)
        size.clear()
        for p, q in zip(*poses(12, seed=3), strict=True):
            with server.atomic():
                for bones in figures:
                    bones.send(p, q)
            data = socket.recv(timeout=PATIENCE)
            size.append(len(data))
            messages = unpacked(data)
            moved = [m for m in messages if m["name"].startswith("/wire/")]
            positions = [m for m in moved if "position" in m]
            assert len(positions) == 20 * BONES
            assert len(moved) == len(messages) == 2 * len(positions)
            firsts = {tuple(m["position"]) for m in positions if m["bone_index"] == 0}
            assert len(firsts) == 1, "parts of two poses in one"
            np.testing.assert_allclose(firsts.pop(), p[0], atol=GRAIN)
    # Unpacked, a message of viser's own is about 100 bytes.
    assert np.median(size) < 280 * 25


def unpacked(data):
    """The messages of what a browser receives at once."""
    length = int.from_bytes(data[:8], "little")
    packed = int.from_bytes(data[8:16], "little")
    raw = zstandard.ZstdDecompressor().decompress(data[16 : 16 + packed], length)
    return msgspec.msgpack.decode(raw)["messages"]

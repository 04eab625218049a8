"""The reel has in every frame what viser's own recording has then."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.viewer.reel import Recording, reel
from halfphysics.viewer.server import close_server, open_server
from support.reels import unpacked

FRAMES, SECONDS = 5, 0.1


@pytest.fixture(scope="module")
def recorded():
    """A frame that moves, an arrow that changes from frame 2 on and is hidden in frame 3."""
    server = open_server("127.0.0.1", 0)
    try:
        moving = server.scene.add_frame("/a", position=(0.0, 0.0, 0.0))
        twin = server.scene.add_frame("/b")
        still = server.scene.add_frame("/still", position=(1.0, 2.0, 3.0))
        arrows = server.scene.add_arrows("/arrows", np.zeros((1, 2, 3)), (255, 0, 0))
        recorder = server.get_scene_serializer()
        for k in range(FRAMES):
            moving.position = twin.position = (-k, 0.25 * k, 0.0)
            if k == 2:
                arrows.points = np.full((2, 2, 3), 7.0, dtype=np.float32)
            arrows.visible = k != 3
            recorder.insert_sleep(SECONDS)
        assert still.position[0] == 1.0
        return Recording(recorder.serialize())
    finally:
        close_server(server)


def test_numbers_are_those_of_every_frame(recorded):
    header, numbers, _ = unpacked(reel(recorded, FRAMES, SECONDS))
    assert header["frames"] == FRAMES
    found = {e["message"]["name"]: e for e in header["numbers"]}
    assert set(found) == {"/a", "/b"}  # what stands still is in the scene already
    for entry in found.values():
        assert entry["message"]["type"] == "SetPositionMessage"
        place = numbers[entry["columns"]].T
        frames = np.arange(FRAMES)
        expected = np.column_stack([-frames, 0.25 * frames, 0 * frames])
        np.testing.assert_array_equal(place, expected)  # whole multiples of the grain
    # Twins share their columns.
    assert found["/a"]["columns"] == found["/b"]["columns"]
    assert header["columns"] == 3


def test_other_values_change_in_the_frames_in_which_they_were_set(recorded):
    header, _, arrays = unpacked(reel(recorded, FRAMES, SECONDS))
    events = {e["field"]: e for e in header["events"]}
    assert events["visible"]["message"]["name"] == "/arrows"
    shown = dict(zip(events["visible"]["at"], events["visible"]["values"], strict=True))
    assert shown == {0: True, 3: False, 4: True}
    points = events["updates.points"]
    assert points["message"] == {"name": "/arrows", "owner": "", "type": "SceneNodeUpdateMessage"}
    assert points["at"] == [0, 2]
    for value, expected in zip(points["values"], (np.zeros(6), np.full(12, 7.0)), strict=True):
        data = arrays[value["start"] : value["start"] + value["bytes"]]
        np.testing.assert_array_equal(np.frombuffer(data, dtype=value["dtype"]), expected)


def test_a_recording_in_which_nothing_changes_is_empty():
    server = open_server("127.0.0.1", 0)
    try:
        server.scene.add_frame("/a", position=(1.0, 0.0, 0.0))
        recorder = server.get_scene_serializer()
        recorder.insert_sleep(SECONDS)
        header, numbers, arrays = unpacked(reel(Recording(recorder.serialize()), 1, SECONDS))
    finally:
        close_server(server)
    assert (header["numbers"], header["events"], numbers.size, arrays) == ([], [], 0, b"")

"""Results that were cut off anywhere."""

from __future__ import annotations

import random

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError
from halfphysics.formats.results import unfinished
from halfphysics.formats.results.result_file import is_result
from halfphysics.live import recording
from halfphysics.live.session import Session
from halfphysics.results.records import SceneRecord


def write_recording(path):
    """A recording of 40 frames in 4 blocks; returns the person's rotations."""
    session = Session(None)
    frames = [session.step() for _ in range(40)]
    scene = SceneRecord.of(session.simulator.world.scene)
    with path.open("wb") as file:
        file.write(unfinished.MAGIC)
        unfinished.write_document(file, unfinished.HEAD, recording._head(session.simulator))
        unfinished.write_document(file, unfinished.SCENE, dict(scene.document))
        for first in range(0, 40, 10):
            unfinished.write_frames(file, recording._fields(frames[first : first + 10]))
    return np.stack([frame.poses["person"].rotations for frame in frames])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The bytes of that recording, and the person's rotations."""
    path = tmp_path_factory.mktemp("recorded") / "out.npz.unfinished"
    rotations = write_recording(path)
    return path.read_bytes(), rotations


def load(tmp_path, data):
    path = tmp_path / "cut.unfinished"
    path.write_bytes(data)
    return hp.Result.load(path)


def test_all_of_it(recorded, tmp_path):
    data, rotations = recorded
    result = load(tmp_path, data)
    assert len(result) == 40
    np.testing.assert_array_equal(result.motion.rotations, rotations)
    assert is_result(tmp_path / "cut.unfinished")
    assert unfinished.is_unfinished(tmp_path / "cut.unfinished")
    assert not unfinished.is_unfinished(tmp_path)


def test_cut_anywhere_it_has_whole_blocks_or_says_so(recorded, tmp_path):
    data, _ = recorded
    found = set()
    for cut in random.Random(1).sample(range(len(data)), 40):
        try:
            found.add(len(load(tmp_path, data[:cut])))
        except FileError:
            found.add(0)
    assert found == {0, 10, 20, 30}
    assert len(load(tmp_path, data[:-1])) == 30


def test_a_wrong_byte_ends_it_there(recorded, tmp_path):
    data, _ = recorded
    last = bytearray(data)
    last[-100] ^= 1
    assert len(load(tmp_path, bytes(last))) == 30


@pytest.mark.parametrize(
    "data",
    [
        unfinished.MAGIC,
        unfinished.MAGIC + b"head" + b"\xff" * 8,
        unfinished.MAGIC + bytes(1000),
    ],
)
def test_damaged_from_the_start(tmp_path, data):
    with pytest.raises(FileError, match="unfinished result that cannot be read"):
        load(tmp_path, data)


def test_documents_of_strangers(tmp_path):
    path = tmp_path / "cut.unfinished"
    for head in ({}, {"fps": "x", "settings": {}, "people": []}, {"fps": 1, "people": 3}):
        with path.open("wb") as file:
            file.write(unfinished.MAGIC)
            unfinished.write_document(file, unfinished.HEAD, head)
            unfinished.write_document(file, unfinished.SCENE, {"version": 1})
            unfinished.write_frames(file, {"clearance": np.zeros(2), "names": np.array(["a"])})
        with pytest.raises(FileError):
            hp.Result.load(path)


def test_older_ones_know_no_overlaps(tmp_path, monkeypatch):
    """Nor whom weight corrected; they read as before."""
    write = unfinished.write_frames

    def as_before(file, fields):
        later = ("inside/", "breaches/")
        kept = {k: v for k, v in fields.items() if not k.startswith(later)}
        write(file, {k: v for k, v in kept.items() if not k.endswith("/corrected")})

    monkeypatch.setattr(unfinished, "write_frames", as_before)
    path = tmp_path / "out.npz.unfinished"
    write_recording(path)
    result = hp.Result.load(path)
    assert (len(result), len(result.inside), len(result.breaches)) == (40, 0, 0)
    assert not result.people[0].corrected.any()


def test_bodies_and_scenes_can_be_replaced(recorded, tmp_path):
    data, _ = recorded
    load(tmp_path, data)
    body, scene = hp.Body.default(stature=1.6), hp.Scene()
    result = hp.Result.load(tmp_path / "cut.unfinished", body=body, scene=scene)
    assert result.people[0].body is body
    assert result.scene is scene

"""The page with physics: complete, self-contained, refused where nobody moves."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import zlib

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.errors import FileError, InputError
from halfphysics.simulation.compile_world import compile_world
from halfphysics.simulation.sequence import Sequence
from halfphysics.viewer import core_files
from halfphysics.viewer.play_page import save_play_page


@pytest.fixture(scope="module")
def story():
    found = scenarios.load("kick_ball")
    return dataclasses.replace(found, motion=found.motion[:20])


@pytest.fixture(scope="module")
def page(story, tmp_path_factory):
    path = tmp_path_factory.mktemp("play") / "kick.html"
    assert save_play_page(story, path, title="a <kick>") == path
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def data(page):
    found = re.search(r'<script type="application/json" id="hp-data">(.*?)</script>', page, re.S)
    return json.loads(found[1])


def inflated(text):
    return zlib.decompress(base64.b64decode(text))


def numbers(text):
    """What `packed` packed: the bytes of 64-bit numbers stand apart."""
    planes = np.frombuffer(inflated(text), dtype=np.uint8).reshape(8, -1)
    return np.ascontiguousarray(planes.T).view("<f8").ravel()


def test_the_page_needs_nothing_from_outside(page):
    assert "<title>a &lt;kick&gt;</title>" in page
    assert re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)[^"']*""", page) == []
    assert not re.search(r"^(?:import|export) ", core_files.core_script(), re.M)
    assert "@import" not in page


def test_the_world_is_the_compiled_one_and_the_program_the_installed_one(data, story):
    wanted = compile_world(story.scene, body=story.body, settings=story.settings)
    assert inflated(data["play"]["world"]) == wanted
    assert inflated(data["play"]["wasm"])[:4] == b"\0asm"


def test_the_reference_is_there_to_the_bit(data, story):
    motion = story.motion
    play = data["play"]
    assert (play["frames"], play["fps"]) == (20, motion.fps)
    np.testing.assert_array_equal(numbers(play["translations"]), motion.translation.ravel())
    np.testing.assert_array_equal(numbers(play["rotations"]), motion.rotations.ravel())


def test_what_moves_and_what_can_be_turned(data):
    (ball,) = data["play"]["objects"]
    assert ball == {"name": "ball", "node": "/object/ball", "body": 55, "free": True,
                    "mass": 0.43, "friction": 0.6}  # fmt: skip
    (person,) = data["play"]["people"]
    assert np.shape(person["rest"]) == np.shape(person["tips"]) == (55, 3)
    joints = {joint for piece in person["pieces"] for joint in piece["joints"]}
    assert len(joints) == 55  # live: every joint has a bone
    assert data["play"]["stiffnessShown"] == 1.0
    assert [kind["kind"] for kind in data["play"]["kinds"]] == [0, 1, 3]  # alone: no other person


def test_links_and_two_people(tmp_path):
    door = scenarios.load("push_door")
    found = page_data(door, tmp_path / "door.html")
    names = [item["name"] for item in found["objects"]]
    assert any("/" in name for name in names)
    assert [item["body"] for item in found["objects"]] == list(range(55, 55 + len(names)))
    assert not any(item["free"] for item in found["objects"] if "/" in item["name"])
    two = scenarios.load("shake_hands")
    found = page_data(two, tmp_path / "two.html")
    assert len(found["people"]) == 2
    assert [kind["kind"] for kind in found["kinds"]] == [0, 1, 2, 3]
    rows = np.stack([m.translation for m in two.motions], axis=1)
    np.testing.assert_array_equal(numbers(found["translations"]), rows.ravel())


def page_data(sequence, path):
    text = save_play_page(sequence, path).read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="hp-data">(.*?)</script>', text, re.S)
    return json.loads(found[1])["play"]


def test_the_same_sequence_makes_the_same_page(story, page, tmp_path):
    again = save_play_page(story, tmp_path / "again.html", title="a <kick>")
    assert data_of(again.read_text(encoding="utf-8")) == data_of(page)


def data_of(text):
    return re.search(r'id="hp-data">(.*?)</script>', text, re.S)[1]


def test_nobody_moves_or_not_together(story, tmp_path):
    with pytest.raises(InputError, match="no motion"):
        save_play_page(Sequence((), story.scene, ()), tmp_path / "none.html")
    motion = story.motion
    pair = Sequence((motion, motion[:10]), story.scene, (story.body, story.body))
    with pytest.raises(InputError, match="20 frames at 30 fps, 10 frames"):
        save_play_page(pair, tmp_path / "pair.html")
    assert list(tmp_path.iterdir()) == []


def test_a_baseline_that_runs_in_python_is_refused(story, tmp_path):
    settings = hp.baselines.EngineKinematic()
    with pytest.raises(InputError, match="EngineKinematic"):
        save_play_page(dataclasses.replace(story, settings=settings), tmp_path / "no.html")
    assert list(tmp_path.iterdir()) == []


def test_without_the_core_for_browsers_the_way_out_is_said(story, tmp_path, monkeypatch):
    monkeypatch.setattr(core_files, "PROGRAM", "nothing.wasm")
    core_files.core_program.cache_clear()
    try:
        with pytest.raises(FileError, match=r"tools/build_wasm\.sh"):
            save_play_page(story, tmp_path / "no.html")
    finally:
        core_files.core_program.cache_clear()
    assert list(tmp_path.iterdir()) == []

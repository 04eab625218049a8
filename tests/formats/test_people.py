"""Several people in one file: who is read, which frames, and how gaps are filled."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.formats import registry
from halfphysics.formats.format import Format
from halfphysics.formats.people import SHARED, Track, chosen, filled, together
from support.files.layouts import UPRIGHT

#: Rotations agree to this [rad]: composed of two conversions in double precision.
TURN = 1e-12


def test_one_person_is_read_without_a_word():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert chosen("f", [Track("1", 3, 9)], "").name == "1"
        assert together("f", [Track("1", 3, 9)]) == ([Track("1", 3, 9)], 3, 9)


def test_who_is_there_longest_is_read_and_the_others_are_named():
    tracks = [Track("a", 0, 5), Track("b", 2, 30), Track("c", 10, 38)]
    with pytest.warns(HalfPhysicsWarning, match=r"of 3 people 'b' is read.*'a', 'c'"):
        assert chosen("f", tracks, "") is tracks[1]
    assert chosen("f", tracks, "c") is tracks[2]


def test_people_who_are_there_at_the_same_time_are_read_together():
    tracks = [Track("late", 40, 100), Track("long", 0, 100), Track("gone", 0, 20)]
    with pytest.warns(HalfPhysicsWarning, match=r"frames 40 to 100.*without 'gone'"):
        kept, start, stop = together("f", tracks)
    assert ([t.name for t in kept], start, stop) == (["late", "long"], 40, 100)


def test_shared_frames_are_never_fewer_than_promised():
    rng = np.random.default_rng(3)
    for _ in range(200):
        tracks = []
        for name in range(rng.integers(1, 7)):
            start = int(rng.integers(0, 100))
            tracks.append(Track(str(name), start, start + int(rng.integers(1, 100))))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            kept, start, stop = together("f", tracks)
        assert stop - start >= SHARED * max(map(len, tracks))
        assert all(t.start <= start and stop <= t.stop for t in kept)
        assert max(tracks, key=len) in kept


def test_errors_name_what_was_found():
    with pytest.raises(FileError, match="found nobody in it"):
        chosen("f", [], "")
    with pytest.raises(FileError, match="found nobody in it"):
        together("f", [])
    with pytest.raises(InputError, match=r"no 'anna', expected one of its 1 people"):
        chosen("f", [Track("anne", 0, 4)], "anna")
    with pytest.raises(FileError, match="not whole or do not increase"):
        filled("f", np.array([0, 2, 2]), np.zeros((3, 3)), np.zeros((3, 2, 3)))


def test_gaps_are_filled_along_the_shortest_turn():
    frames = np.array([4, 5, 9])
    places = np.array([[0.0, 0, 0], [1, 0, 0], [3, 4, 0]])
    # About one axis, 3.0 and -3.0 rad are 0.28 apart, by way of pi.
    turns = np.zeros((3, 1, 3))
    turns[:, 0, 2] = 0.5, 3.0, -3.0
    where, how = filled("f", frames, places, turns)
    assert where.tolist() == [[0, 0, 0], [1, 0, 0], [1.5, 1, 0], [2, 2, 0], [2.5, 3, 0], [3, 4, 0]]
    expected = np.linspace(3.0, 2 * np.pi - 3.0, 5)
    found = np.mod(how[1:, 0, 2], 2 * np.pi)
    assert np.abs(found - expected).max() < TURN
    assert how[0, 0, 2] == 0.5


def test_a_long_gap_is_told():
    with pytest.warns(HalfPhysicsWarning, match="7 frames are missing"):
        filled("f", np.array([0, 8]), np.zeros((2, 3)), np.zeros((2, 1, 3)))


def _load(source, options):
    own = {"anne": 40, "bert": 30}
    length, start = own[options.clip], {"anne": 0, "bert": 10}[options.clip]
    places = np.zeros((length, 3))
    places[:, 0] = (start + np.arange(length)) / 100.0
    upright = np.zeros((length, 55, 3))
    upright[:, 0] = UPRIGHT["z"]
    return hp.Motion(places[options.frames], upright[options.frames], 30.0)


@pytest.fixture
def tracked(tmp_path, monkeypatch):
    path = tmp_path / "two.tracks"
    path.write_bytes(b"tracks of two people")
    format = Format(
        name="tracks",
        expects="tracks",
        sniff=lambda source: source.head[:6] == b"tracks",
        load=_load,
        people=lambda source: [Track("anne", 0, 40), Track("bert", 10, 40)],
    )
    monkeypatch.setitem(registry.FORMATS, "tracks", format)
    return path


def test_a_tracked_file_gives_one_person_or_all(tracked):
    with pytest.warns(HalfPhysicsWarning, match="'anne' is read"):
        assert len(hp.Motion.load(tracked)) == 40
    assert len(hp.Motion.load(tracked, clip="bert", frames=(5, None))) == 25
    with pytest.warns(HalfPhysicsWarning, match="frames 10 to 40"):
        both = hp.load_sequence(tracked, frames=(2, 8)).motions
    # Frame 2 of those that both share is frame 12 of the video, for each.
    assert [motion.translation[0, 0] for motion in both] == [0.12, 0.12]
    assert [len(motion) for motion in both] == [6, 6]
    alone = hp.load_sequence(tracked, clip="bert")
    assert [len(motion) for motion in alone.motions] == [30]


def test_a_library_has_a_tracked_file_once(tracked):
    assert [clip.name for clip in hp.clips(tracked.parent)] == [None]


def test_only_people_of_the_file_can_be_named(tracked):
    with pytest.raises(InputError, match="no 'carl', expected one of its 2 people"):
        hp.load_sequence(tracked, clip="carl")


def test_a_format_without_people_is_as_before(monkeypatch, tracked):
    format = replace(registry.FORMATS["tracks"], people=None)
    monkeypatch.setitem(registry.FORMATS, "tracks", format)
    with pytest.raises(InputError, match="holds one motion only"):
        hp.Motion.load(tracked, clip="bert")

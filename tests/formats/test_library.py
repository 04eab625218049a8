"""Libraries of motions: folders, globs, files of many clips."""

from __future__ import annotations

import itertools
import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.formats import format as formats
from support.files.layouts import movement


@pytest.fixture
def library(tmp_path):
    motion = hp.Motion(*movement(), 30.0)
    for name in ("b/walk.npz", "a/run.npz", "a/deep/er/jump.npz"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        motion.save(path)
    (tmp_path / "README.txt").write_text("not a motion")
    (tmp_path / "a" / "shape.npz").write_bytes(b"")
    (tmp_path / "a" / "broken.npz").write_bytes(b"PK\x03\x04 and no more")
    (tmp_path / "a" / "evil.pkl").write_bytes(pickle.dumps(itertools.count))
    return tmp_path


def names(found, under):
    return [clip.path.relative_to(under).as_posix() for clip in found]


def test_folders_and_globs(library):
    assert names(hp.clips(library), library) == ["a/deep/er/jump.npz", "a/run.npz", "b/walk.npz"]
    assert names(hp.clips(library / "*" / "*.npz"), library) == ["a/run.npz", "b/walk.npz"]
    assert names(hp.clips(library / "**" / "j*"), library) == ["a/deep/er/jump.npz"]
    clip = next(hp.clips(library / "b" / "walk.npz"))
    assert (clip.format, clip.name) == ("amass-smplx", None)
    assert np.array_equal(clip.motion().rotations, movement()[1])
    assert len(clip.load(frames=(2, 8)).motion) == 6
    assert not clip.load().scene.objects


def test_nothing_of_that_name(library):
    with pytest.raises(hp.HalfPhysicsError, match="no file fits it as a pattern"):
        list(hp.clips(library / "*.bvh"))
    with pytest.raises(hp.HalfPhysicsError, match="damaged"):
        list(hp.clips(library / "a" / "broken.npz"))  # requested by name
    with pytest.raises(hp.HalfPhysicsError, match="no known motion format"):
        list(hp.clips(library / "README.txt"))


@pytest.mark.parametrize("motion", [np.zeros((1, 17, 3, 9)), [np.zeros(3), np.zeros(2)]])
def test_a_file_whose_clips_cannot_be_told_is_passed_over(library, motion):
    path = library / "a" / "results.npy"
    np.save(path, {"motion": motion, "lengths": np.array([9])}, allow_pickle=True)
    assert names(hp.clips(library), library) == ["a/deep/er/jump.npz", "a/run.npz", "b/walk.npz"]
    with pytest.raises(hp.HalfPhysicsError, match=r"results\.npy: field 'motion'.*expected"):
        list(hp.clips(path))


def test_files_are_opened_when_their_turn_comes(library, monkeypatch):
    opened = []
    plain = formats.Source.__init__

    def watched(self, path):
        opened.append(path.name)
        plain(self, path)

    monkeypatch.setattr(formats.Source, "__init__", watched)
    found = hp.clips(library)
    assert opened == []
    next(found)
    assert "walk.npz" not in opened

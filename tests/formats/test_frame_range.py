"""Frames that a file does not have: the message says how many there are."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.formats.format import Options
from halfphysics.formats.frame_range import in_range

FRAMES = 127


@pytest.fixture
def clip(tmp_path):
    rotations = np.zeros((FRAMES, 55, 3))
    rotations[:, 0, 0] = np.pi / 2  # upright
    motion = hp.Motion(np.full((FRAMES, 3), (0.0, 0.0, 0.9)), rotations, 30.0)
    motion.save(tmp_path / "walk.npz")
    return tmp_path / "walk.npz"


@pytest.mark.parametrize("read", [hp.Motion.load, hp.load_sequence])
@pytest.mark.parametrize(
    ("frames", "said"), [((500, 600), "500:600"), ((127, None), "127:"), ((3, 4), "3:4")]
)
def test_the_length_is_said(read, frames, said, clip):
    with pytest.raises(InputError) as caught:
        read(clip, frames=frames)
    assert str(caught.value).endswith(
        f"frames: found {said}, but {clip} has 127 frames, numbered from 0; expected at least 2 of "
        "them"
    )


def test_frames_beyond_the_end_are_those_that_are_there(clip):
    assert len(hp.Motion.load(clip, frames=(100, 600))) == 27
    assert len(hp.Motion.load(clip, frames=(-2, None))) == 2


def test_frames_are_whole_numbers_of_numpy_too(clip):
    assert len(hp.Motion.load(clip, frames=(np.int64(3), np.int32(10)))) == 7
    for wrong in [(1.5, 3), ("a", 3), (True, 3), (0, 3, 1), 3, slice(0, 3)]:
        with pytest.raises(InputError, match=r"frames: found .*whole numbers or None"):
            hp.Motion.load(clip, frames=wrong)


def test_other_errors_stay_as_they_are():
    asked = []

    def read(options):
        asked.append(options.frames)
        if options.frames == slice(None):
            warnings.warn("not heard", hp.HalfPhysicsWarning, stacklevel=1)
            return range(10)
        raise FileError("NaN in frame 3")

    for frames in (slice(None, 8), slice(2, 4)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with pytest.raises(FileError, match="NaN in frame 3"):
                in_range("f", Options(frames=frames), read, len)

    def never(options):
        asked.append(options.frames)
        raise FileError("damaged")

    asked.clear()
    with pytest.raises(FileError, match="damaged"):
        in_range("f", Options(frames=slice(90, 95)), never, len)
    with pytest.raises(FileError, match="damaged"):
        in_range("f", Options(), never, len)
    assert asked == [slice(90, 95), slice(None), slice(None)]

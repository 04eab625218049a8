"""Names and arrays of the clips of an npy file."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.errors import FileError
from halfphysics.formats.format import Options, Source
from halfphysics.formats.positions.clip_array import clip_names, clip_of


def written(tmp_path, *shape):
    path = tmp_path / "M00021.npy"
    np.save(path, np.arange(np.prod(shape, dtype=int), dtype=np.float64).reshape(shape))
    return Source(path)


@pytest.mark.parametrize("shape", [(4, 22, 3), (1, 4, 22, 3)])
def test_one_clip_has_the_name_of_its_file(tmp_path, shape):
    source = written(tmp_path, *shape)
    assert clip_names(source, 3) == ["M00021"]
    where, array = clip_of(source, Options(clip="M00021"), 3)
    assert where == str(source.path)
    assert np.array_equal(array.ravel(), np.arange(4 * 22 * 3))


def test_several_are_numbered(tmp_path):
    source = written(tmp_path, 3, 5, 263)
    assert clip_names(source, 2) == ["0", "1", "2"]
    where, array = clip_of(source, Options(clip="2"), 2)
    assert where.endswith("clip '2'")
    assert array[0, 0] == 2 * 5 * 263


def test_no_clips(tmp_path):
    assert clip_names(written(tmp_path, 0, 5, 263), 2) == []


def test_no_array(tmp_path):
    path = tmp_path / "a.json"
    path.write_text("{}")
    with pytest.raises(FileError, match="no array"):
        clip_of(Source(path), Options(), 3)


def test_clips_of_nothing_are_refused_before_they_are_counted(tmp_path):
    path = tmp_path / "a.npy"
    head = np.lib.format
    with path.open("wb") as file:
        shape = (10**10, 0, 22, 3)
        head.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": shape})
    with pytest.raises(FileError, match="expected frames"):
        clip_names(Source(path), 3)

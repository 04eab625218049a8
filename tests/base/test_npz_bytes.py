"""Archives in memory: readable by numpy, the same bytes each time, small and fast."""

from __future__ import annotations

import io
import time
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from halfphysics.base import npz_bytes as module
from halfphysics.base.npz_bytes import npz_bytes
from halfphysics.errors import InputError

ANY = st.one_of(
    hnp.arrays(
        st.sampled_from(["f8", "f4", "i4", "i8", "i1", "u1", "?", "U7", ">f8"]),
        hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=40),
    )
)


def read(data):
    with np.load(io.BytesIO(data), allow_pickle=False) as npz:
        return dict(npz)


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(st.dictionaries(st.text("abö/.", min_size=1, max_size=6), ANY, max_size=5))
def test_numpy_and_zipfile_read_it(arrays):
    data = npz_bytes(arrays)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == [f"{name}.npy" for name in arrays]
        for name, array in arrays.items():
            # Equal to numpy's bytes, header included.
            whole = io.BytesIO()
            np.save(whole, array)
            assert archive.read(f"{name}.npy") == whole.getvalue()
    for name, array in read(data).items():
        np.testing.assert_array_equal(array, arrays[name])


@pytest.mark.parametrize("size", [0, 1, 65_535, 65_536 - 128, 65_536, 200_000, 400_123])
@pytest.mark.parametrize("where", [None, 0, -1])
def test_blocks_of_zeros(size, where):
    array = np.zeros(size, np.int8)
    if where is not None and size:
        array[where] = 55
    np.testing.assert_array_equal(read(npz_bytes({"a": array}))["a"], array)


def test_other_orders_of_memory():
    array = np.arange(5000.0).reshape(50, 100)
    for one in (array.T, array[:, ::3], np.asfortranarray(array), array[::-1]):
        np.testing.assert_array_equal(read(npz_bytes({"a": one}))["a"], one)


def test_the_same_bytes_whatever_went_before(monkeypatch):
    """An array that was packed before is not packed again, and is not confused with another."""
    rng = np.random.default_rng(0)
    faces = rng.integers(0, 50, (9000, 3)).astype(np.int32)
    vertices = np.repeat(rng.normal(size=(50, 3)), 60, axis=0)
    arrays = {"faces": faces, "vertices": vertices, "zeros": np.zeros(100_000)}
    module._before.clear()
    first = npz_bytes(arrays)
    assert len(module._before) == 2
    assert npz_bytes(arrays) == first
    other = npz_bytes({**arrays, "faces": faces + 1})
    assert len(module._before) == 3
    module._before.clear()
    assert npz_bytes({**arrays, "faces": faces + 1}) == other
    monkeypatch.setattr(time, "time", lambda: 2e9)
    assert npz_bytes(arrays) == first


def test_what_is_remembered_is_bounded(monkeypatch):
    monkeypatch.setattr(module, "_REMEMBERED", 100_000)
    module._before.clear()
    for number in range(40):
        npz_bytes({"faces": np.full((1000, 3), number + 1, np.int32)})
    assert sum(map(len, module._before)) <= 100_000
    assert len(module._before) > 4


def test_what_packs_is_packed():
    rng = np.random.default_rng(0)
    motion = rng.normal(size=(200, 156))
    arrays = {
        "labels": np.zeros((200, 13_000), np.int8),
        "motion": motion,
        "still": np.where(np.arange(156) < 66, motion, 0.0),
        "faces": rng.integers(1, 3000, (5000, 3)).astype(np.int32),
        "name": np.array("cup"),
    }
    with zipfile.ZipFile(io.BytesIO(npz_bytes(arrays))) as archive:
        info = {i.filename.removesuffix(".npy"): i for i in archive.infolist()}
    assert info["labels"].compress_size < 0.005 * arrays["labels"].nbytes
    assert info["motion"].compress_type == zipfile.ZIP_STORED
    assert info["still"].compress_size < 0.5 * motion.nbytes
    assert info["faces"].compress_size < 0.6 * arrays["faces"].nbytes
    assert {i.date_time for i in info.values()} == {(1980, 1, 1, 0, 0, 0)}


def test_what_does_not_fit(monkeypatch):
    monkeypatch.setattr(module, "_LARGEST", 10_000)
    with pytest.raises(InputError, match=r"b: 16128 bytes of it do not fit.*shorter"):
        npz_bytes({"a": np.ones(3), "b": np.ones(2000)})
    # Each array begins within the limit, and the list of them after the last one does not.
    with pytest.raises(InputError, match=r"b: 6528 bytes of it do not fit.*shorter"):
        npz_bytes({"a": np.arange(800.0) ** 0.3, "b": np.arange(800.0) ** 0.7})


def test_no_objects():
    with pytest.raises(ValueError, match="Object arrays"):
        npz_bytes({"a": np.array([{}], dtype=object)})

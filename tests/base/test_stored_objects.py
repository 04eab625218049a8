"""Stored objects: joblib dumps, numpy object files, torch files; no code in them runs."""

from __future__ import annotations

import bz2
import gzip
import lzma
import pickle
import zlib

import numpy as np
import pytest

from halfphysics.base import stored_objects as stored
from halfphysics.base import torch_file
from halfphysics.errors import FileError
from support.files.dumps import (
    Inline,
    Named,
    Tensor,
    Wrapper,
    joblib_dump,
    npy_of,
    old_torch_bytes,
    pickled,
    torch_saved,
)
from support.files.wrong_files import Boom

# -- torch -------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(3, 4), (5,), (0, 2), ()])
def test_a_tensor_is_written(tmp_path, shape):
    array = np.random.default_rng(0).normal(size=shape).astype(np.float32)
    torch_file.write(tmp_path / "a.pt", array)
    read = stored.read(tmp_path / "a.pt")
    assert read.shape == shape
    assert read.dtype == np.float32
    assert np.array_equal(read, array)


def test_torch_tensors(tmp_path):
    numbers = np.arange(24.0)
    data = {
        "whole": Tensor("0", "DoubleStorage", 24, (4, 6), (6, 1)),
        "turned": Tensor("0", "DoubleStorage", 24, (6, 4), (1, 6)),
        "part": Tensor("0", "DoubleStorage", 24, (2, 3), (6, 1), 7),
        "none": Tensor("0", "DoubleStorage", 24, (0, 3), (3, 1)),
        "flags": Tensor("1", "BoolStorage", 3, (3,), (1,)),
        "list": [1, "two", (3.0, None)],
    }
    path = torch_saved(tmp_path / "a.pt", data, {"0": numbers, "1": np.array([1, 0, 1], "?")})
    read = stored.read(path)
    grid = numbers.reshape(4, 6)
    assert np.array_equal(read["whole"], grid)
    assert np.array_equal(read["turned"], grid.T)
    assert np.array_equal(read["part"], numbers[7:19].reshape(2, 6)[:, :3])
    assert read["none"].shape == (0, 3)
    assert read["flags"].tolist() == [True, False, True]
    assert read["list"] == [1, "two", (3.0, None)]
    big = torch_saved(
        tmp_path / "b.pt",
        Tensor("0", "FloatStorage", 3, (3,), (1,)),
        {"0": np.array([1, 2, 3], ">f4")},
        byteorder="big",
    )
    assert stored.read(big).tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    "tensor",
    [
        Tensor("0", "DoubleStorage", 4, (5,), (1,)),
        Tensor("0", "DoubleStorage", 4, (2, 2), (3, 1)),
        Tensor("0", "DoubleStorage", 4, (2,), (1,), 3),
        Tensor("0", "DoubleStorage", 4, (2,), (-1,), 3),
        Tensor("0", "DoubleStorage", 4, (2,), (1,), -1),
        Tensor("0", "DoubleStorage", 4, (10**9,), (0,)),
        Tensor("0", "DoubleStorage", 4, (2, 2), (1,)),
        Tensor("9", "DoubleStorage", 4, (2,), (1,)),
        Tensor("0", "QInt8Storage", 4, (2,), (1,)),
        Named("os", "system"),
        Named("torch", "load"),
    ],
    ids=range(11),
)
def test_torch_files_that_reach_outside(tmp_path, tensor):
    path = torch_saved(tmp_path / "a.pt", {"x": tensor}, {"0": np.arange(4.0)})
    with pytest.raises(FileError, match=r"a\.pt"):
        stored.read(path)


def test_old_torch_files(tmp_path):
    """Before torch 1.6: pickles in a row; two tensors are views of one storage."""
    numbers = np.arange(24.0, dtype=np.float32)
    data = {
        "turned": Tensor("0", "FloatStorage", 24, (6, 4), (1, 6)),
        "part": Tensor("0", "FloatStorage", 24, (2, 3), (6, 1), 7),
        "flags": Tensor("1", "BoolStorage", 3, (3,), (1,)),
        "n": 7,
    }
    good = old_torch_bytes(data, {"0": numbers, "1": np.array([True, False, True])})
    path = tmp_path / "old.pt"
    path.write_bytes(good)
    found = stored.read(path)
    assert np.array_equal(found["turned"], numbers.reshape(4, 6).T)
    assert np.array_equal(found["part"], numbers[7:19].reshape(2, 6)[:, :3])
    assert found["flags"].tolist() == [True, False, True]
    assert found["n"] == 7
    for length in np.linspace(1, len(good) - 1, 40).astype(int):
        path.write_bytes(good[:length])
        with pytest.raises(FileError, match=r"old\.pt"):
            stored.read(path)


def test_tensors_inside_other_pickles(tmp_path):
    """As TRAM has them: numpy's pickle, and the bytes of each storage within."""
    grid = np.arange(12.0, dtype=np.float32).reshape(3, 4)
    path = npy_of(tmp_path / "a.npy", {"grid": Inline(grid), "turned": Inline(grid.T), "n": 3})
    found = stored.read(path)
    assert np.array_equal(found["grid"], grid)
    assert np.array_equal(found["turned"], grid.T)
    assert found["n"] == 3


@pytest.mark.parametrize("inner", [b"", b"text", pickle.dumps(1), pickle.dumps({"a": 1})])
def test_bytes_that_are_no_storage(tmp_path, inner):
    """Whatever calls itself a storage, is none: one message, nothing run."""
    path = tmp_path / "a.pkl"
    call = pickle.GLOBAL + b"torch.storage\n_load_from_bytes\n"
    path.write_bytes(pickle.PROTO + b"\x02" + call + pickle.dumps((inner,), 2)[2:-1] + b"R.")
    with pytest.raises(FileError, match="torch"):
        stored.read(path)


def test_a_storage_within_a_storage_is_refused(tmp_path):
    """Each is read twice: nested, the time would double with every level."""
    path, inner = tmp_path / "a.pkl", pickled(Inline(np.zeros(2)))
    path.write_bytes(old_torch_bytes({"x": Inline(np.zeros(2))}, {}))
    with pytest.raises(FileError, match="_load_from_bytes"):
        stored.read(path)
    assert stored.read(_written(tmp_path / "b.pkl", inner)).tolist() == [0.0, 0.0]


def _written(path, data):
    path.write_bytes(data)
    return path


# -- joblib ------------------------------------------------------------------------------------


def joblib_data():
    grid = np.arange(12.0).reshape(3, 4)
    return {
        7: {
            "name": "sub1_box_003",
            "a": Wrapper(grid),
            "f": Wrapper(grid.T, "F"),
            "o": Wrapper(np.array(["x", None], dtype=object)),
            "after": [1, 2],
        }
    }


PACKED = {
    "plain": lambda b: b,
    "zlib": zlib.compress,
    "gzip": gzip.compress,
    "bz2": bz2.compress,
    "xz": lzma.compress,
    "lzma": lambda b: lzma.compress(b, lzma.FORMAT_ALONE),
}


@pytest.mark.parametrize("packed", PACKED)
@pytest.mark.parametrize("protocol", [2, 4])
def test_joblib_dumps(tmp_path, packed, protocol):
    path = tmp_path / "a.p"
    path.write_bytes(PACKED[packed](joblib_dump(joblib_data(), protocol)))
    read = stored.read(path)[7]
    assert np.array_equal(read["a"], np.arange(12.0).reshape(3, 4))
    assert np.array_equal(read["f"], read["a"].T)
    assert read["o"].tolist() == ["x", None]
    assert (read["name"], read["after"]) == ("sub1_box_003", [1, 2])


@pytest.mark.parametrize("packed", PACKED)
def test_truncated_dumps(tmp_path, packed):
    whole = PACKED[packed](joblib_dump(joblib_data()))
    path = tmp_path / "a.p"
    for length in range(1, len(whole) - 1, 7):
        path.write_bytes(whole[:length])
        with pytest.raises(FileError, match=r"a\.p"):
            stored.read(path)


def test_bombs(tmp_path, monkeypatch):
    path = tmp_path / "bomb.p"
    path.write_bytes(zlib.compress(bytes(20 * 2**20), 9))
    monkeypatch.setattr(stored, "MAX_BYTES", 2**20)
    with pytest.raises(FileError, match="expected at most"):
        stored.read(path)


def test_lz4_is_named(tmp_path):
    path = tmp_path / "a.p"
    path.write_bytes(b"\x04\x22M\x18" + bytes(30))
    with pytest.raises(FileError, match="lz4"):
        stored.read(path)


# -- numpy files of objects, and code that would run ------------------------------------------


def test_object_arrays(tmp_path):
    np.save(tmp_path / "a.npy", {"transl": np.ones((4, 3))}, allow_pickle=True)
    assert np.array_equal(stored.read(tmp_path / "a.npy")["transl"], np.ones((4, 3)))
    np.save(tmp_path / "b.npy", np.array([{"a": 1}, [2]], dtype=object), allow_pickle=True)
    assert stored.read(tmp_path / "b.npy").tolist() == [{"a": 1}, [2]]


@pytest.mark.parametrize("kind", ["pickle", "joblib", "npy", "torch", "object in joblib"])
def test_nothing_is_run(tmp_path, kind):
    mark, path = tmp_path / "was_run", tmp_path / "evil.p"
    boom = Boom(mark)
    if kind == "pickle":
        path.write_bytes(pickle.dumps(boom))
    elif kind == "joblib":
        path.write_bytes(joblib_dump({"x": boom}))
    elif kind == "object in joblib":
        path.write_bytes(joblib_dump({"x": Wrapper(np.array([boom], dtype=object))}))
    elif kind == "npy":
        path = tmp_path / "evil.npy"
        np.save(path, np.array([boom], dtype=object), allow_pickle=True)
    else:
        torch_saved(path, boom, {})
    with pytest.raises(FileError, match="unsafe or unknown content"):
        stored.read(path)
    assert not mark.exists()


def test_pickles_within_pickles_end(tmp_path):
    inner: object = Wrapper(np.array([1], dtype=object))
    body = joblib_dump({"x": inner})
    # Each wrapper's pickle holds the next wrapper.
    head = body[: body.index(pickle.BUILD) + 1]
    path = tmp_path / "deep.p"
    path.write_bytes(head * 50)
    with pytest.raises(FileError, match=r"deep\.p"):
        stored.read(path)

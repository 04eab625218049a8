"""Untrusted pickles: data is read, anything else is refused and nothing runs."""

from __future__ import annotations

import collections
import os
import pickle
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from halfphysics.base.restricted_pickle import load, loads
from halfphysics.errors import FileError
from support.files.model_files import chumpy, chumpy_select, chumpy_stand_in

GRID = np.arange(12.0).reshape(3, 4)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_data_comes_out_as_it_went_in(protocol: int) -> None:
    data = {
        "c": GRID,
        "fortran": np.asfortranarray(GRID),
        "big_endian": np.arange(3, dtype=">i4"),
        "none": np.zeros((0, 3)),
        "point": np.array(3.5),
        "text": np.array(["ab", "c"]),
        "bytes_array": np.array([b"abc"]),
        "scalar": np.float32(2.5),
        "bytes": b"\x00\xff",
        "bytearray": bytearray(b"xy"),
        "plain": [1, 2.5, None, True, "é", 1 << 80, 1j, (1, (2,)), {3}, frozenset([4])],
        "ordered": collections.OrderedDict(a=1, b=2),
        "default": collections.defaultdict(list, {"k": [1]}),
    }
    out = loads(pickle.dumps(data, protocol))
    assert list(out) == list(data)
    for key, value in data.items():
        if isinstance(value, np.ndarray):
            assert out[key].dtype == value.dtype
            np.testing.assert_array_equal(out[key], value)
        else:
            assert out[key] == value, key
    assert isinstance(out["scalar"], np.float32)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_arrays_of_objects_and_shared_objects(protocol: int) -> None:
    objects = np.empty((2, 2), dtype=object, order="F")
    # Arrays of equal shape: numpy would unfold them into more axes.
    objects[0, 0], objects[0, 1], objects[1, 0], objects[1, 1] = GRID, GRID + 1, "x", {"a": GRID}
    out = loads(pickle.dumps({"objects": objects, "again": GRID, "list": [GRID]}, protocol))
    assert out["objects"].shape == (2, 2)
    np.testing.assert_array_equal(out["objects"][0, 1], GRID + 1)
    assert out["objects"][1, 0] == "x"
    assert out["objects"][0, 0] is out["again"] is out["objects"][1, 1]["a"] is out["list"][0]


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_what_contains_itself_is_refused(protocol: int) -> None:
    """numpy would unfold it without end."""
    loop: list[Any] = [1.0]
    loop.append({"again": loop})
    for data in (loop, {"a": loop}):
        with pytest.raises(FileError, match="contains itself"):
            loads(pickle.dumps(data, protocol))


@pytest.mark.parametrize("kind", ["csc_matrix", "csr_matrix", "coo_matrix", "csc_array"])
def test_sparse_matrices_become_dense(kind: str) -> None:
    dense = np.where(np.random.default_rng(0).random((5, 8)) < 0.4, 2.5, 0.0)
    dense[2] = 0.0
    for protocol in (0, 2, 4):
        out = loads(pickle.dumps({"m": getattr(sp, kind)(dense)}, protocol))["m"]
        assert type(out) is np.ndarray
        np.testing.assert_array_equal(out, dense)


def test_sparse_repeats_add_up() -> None:
    twice = sp.coo_matrix(([1.0, 2.0], ([1, 1], [0, 0])), shape=(2, 2))
    np.testing.assert_array_equal(loads(pickle.dumps(twice)), [[0, 0], [3, 0]])


@pytest.mark.parametrize("protocol", [0, 1, 2, 4])
def test_chumpy_becomes_arrays_without_chumpy(protocol: int) -> None:
    with chumpy_stand_in():
        data = pickle.dumps(
            [chumpy(GRID), chumpy_select(GRID, np.array([11, 0]), (2, 1))], protocol
        )
    assert "chumpy" not in sys.modules
    out = loads(data)
    assert "chumpy" not in sys.modules
    np.testing.assert_array_equal(out[0], GRID)
    np.testing.assert_array_equal(out[1], [[11.0], [0.0]])


def test_unknown_chumpy_is_refused_by_name() -> None:
    with chumpy_stand_in():
        strange = chumpy(GRID)
        strange.__dict__ = {"left": 1, "right": 2}
        data = pickle.dumps(strange, 2)
    with pytest.raises(FileError, match=r"chumpy\.ch\.Ch"):
        loads(data)


def test_python_2_pickle() -> None:
    """Raw bytes as Python 2 wrote them: text opcodes with arbitrary bytes."""
    raw = struct.pack("<3d", 1.5, -2.0, 1e300)
    data = (
        b"\x80\x02}U\x01acnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85U\x01b\x87R"
        b"(K\x01K\x03\x85cnumpy\ndtype\nU\x02f8K\x00K\x01\x87R"
        b"(K\x03U\x01<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89U\x18" + raw + b"tbs."
    )
    np.testing.assert_array_equal(loads(data)["a"], [1.5, -2.0, 1e300])


class _Runs:
    """Pickles into a call of any function."""

    def __init__(self, function: Any, *args: Any) -> None:
        self.call = (function, args)

    def __reduce__(self) -> Any:
        return self.call


def _hostile(marker: Path) -> dict[str, bytes]:
    command = f"touch {marker}"
    python = f"open({str(marker)!r}, 'w')"
    return {
        "posix.system": pickle.dumps(_Runs(os.system, command)),
        "builtins.eval": pickle.dumps([GRID, _Runs(eval, python)]),
        "__builtin__.eval": pickle.dumps(_Runs(eval, python), 0),
        "builtins.getattr": pickle.dumps(_Runs(getattr, GRID, "dump")),
        "numpy.load": pickle.dumps(_Runs(np.load, "x")),
        "os.system": b"cos\nsystem\n(S'" + command.encode() + b"'\ntR.",
        "os.popen": b"(S'" + command.encode() + b"'\nios\npopen\n.",
        "dotted": pickle.dumps("x")[:2] + b"\x8c\x05numpy\x8c\x0bndarray.dump\x93.",
        "subprocess.Popen": b"csubprocess\nPopen\n(lp0\nS'touch'\naS'" + str(marker).encode()
        + b"'\natR.",
        "inside a sparse matrix": b"cscipy.sparse._csc\nos\n)R.",
        "inside chumpy": b"cchumpy.ch\nCh\n)\x81}S'x'\ncos\nsystem\n(S'" + command.encode()
        + b"'\ntRsb.",
        "persistent": b"Pos.system\n.",
        "persistent binary": b"K\x01Q.",
        "extension": b"\x82\x01.",
        "state of a class": b"cnumpy\nndarray\n}S'__setstate__'\ncnumpy\ndtype\nsb.",
        "state of a dict": b"}}S'a'\nK\x01sb.",
        "a class as data": b"cnumpy\nndarray\n.",
        "a function as data": b"K\x01cnumpy.core.multiarray\nscalar\n\x86.",
        "a class as a key": b"}cnumpy\nndarray\nK\x01s.",
        "bytes of a number": b"c__builtin__\nbytes\n(J\xff\xff\xff\x7ftR.",
        "object": b"c__builtin__\nobject\n)R.",
    }  # fmt: skip


@pytest.mark.parametrize("name", list(_hostile(Path("x"))))
def test_hostile_pickles_are_refused_and_do_nothing(name: str, tmp_path: Path) -> None:
    marker = tmp_path / "ran"
    data = _hostile(marker)[name]
    with pytest.raises(FileError, match=r"bad\.pkl") as caught:
        loads(data, "bad.pkl")
    assert not marker.exists()
    if "." in name:
        assert name.replace("__builtin__", "") in str(caught.value).replace("__builtin__", "")


def test_hostile_pickle_would_have_run(tmp_path: Path) -> None:
    """The plain unpickler does run the payload: the test above can fail."""
    marker = tmp_path / "ran"
    pickle.loads(_hostile(marker)["posix.system"])
    assert marker.exists()


@pytest.mark.parametrize(
    "data",
    [
        # Sizes that the file claims: 2^40 bytes, memo slot 2^31 - 1, shapes and pointers beyond.
        b"\x80\x05\x96" + struct.pack("<Q", 1 << 40) + b"abc.",
        b"\x80\x04\x8e" + struct.pack("<Q", 1 << 40) + b"abc.",
        pickle.dumps(GRID, 2).replace(b"K\x03K\x04\x86", b"J\xff\xff\xff\x7fK\x04\x86"),
        pickle.dumps(GRID, 2).replace(b"K\x03K\x04\x86", b"J\xff\xff\xff\xffK\x04\x86"),
        b"(" * 300_000 + b"t" * 300_000 + b".",
        b"\x80\x02" + b"]" * 200_000 + b"a" * 199_999 + b".",
    ],
)  # fmt: skip
def test_claimed_sizes_are_not_believed(data: bytes) -> None:
    with pytest.raises(FileError):
        loads(data)


def test_huge_memo_slot_costs_nothing() -> None:
    assert loads(b"\x80\x02K\x07r\xff\xff\xff\x7f.") == 7


def test_sparse_matrix_that_does_not_fit_itself() -> None:
    good = sp.csc_matrix(np.eye(3))
    for change in (
        {"indptr": np.array([0, 1, 2, 10**12])},
        {"indices": np.array([0, 1, 7], dtype=np.int32)},
        {"indices": np.array([0, 1, -1], dtype=np.int32)},
        {"_shape": (10**6, 10**6)},
    ):
        broken = good.copy()
        broken.__dict__.update(change)
        with pytest.raises(FileError, match="csc_matrix"):
            loads(pickle.dumps(broken))


def test_every_truncation_and_many_flipped_bytes_are_handled() -> None:
    data = pickle.dumps({"a": GRID, "s": sp.csc_matrix(np.eye(2)), "t": ("x", [1.5])}, 2)
    for end in range(len(data)):
        with pytest.raises(FileError):
            loads(data[:end])
    rng = np.random.default_rng(5)
    refused = 0
    for _ in range(3000):
        changed = bytearray(data)
        changed[rng.integers(len(data))] = rng.integers(256)
        try:
            loads(bytes(changed))
        except FileError:
            refused += 1
    assert refused > 500


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps({"a": GRID}))
    np.testing.assert_array_equal(load(path)["a"], GRID)
    with pytest.raises(FileError, match=r"missing\.pkl"):
        load(tmp_path / "missing.pkl")
    with path.open("wb") as handle:
        handle.truncate(5 * 2**30)
    with pytest.raises(FileError, match=r"5\.0 GiB"):
        load(path)

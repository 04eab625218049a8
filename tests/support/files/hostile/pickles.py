"""Programs of pickles that unfold, or that cost more with every step."""

from __future__ import annotations

import pickle
import struct
from pathlib import Path

import numpy as np

from support.files.hostile.attacks import ATTACKS, attack, written


def _pickled(opened_by: str, name: str, program: bytes) -> None:
    ATTACKS[opened_by][name] = lambda folder: written(folder / "a.pkl", b"\x80\x04" + program)


_FROZEN = b"cbuiltins\nfrozenset\n"
_ENCODE = b"c_codecs\nencode\n"


def text(text: str) -> bytes:
    raw = text.encode()
    return b"X" + struct.pack("<I", len(raw)) + raw


def _put(slot: int) -> bytes:
    return b"r" + struct.pack("<I", slot)


def _get(slot: int) -> bytes:
    return b"j" + struct.pack("<I", slot)


#: frozenset({a, frozenset({a})}) of the one before, 60 times: 2^60 ways down to the first.
_pickled(
    "motion",
    "frozensets_in_frozensets",
    b"(\x91" + _put(0) + b"0"
    + b"".join(
        b"(" + _get(k) + b"(" + _get(k) + b"K\x01\x91\x91" + _put(k + 1) + b"0"
        for k in range(60)
    )
    + _get(60) + b".",
)  # fmt: skip
_pickled(
    "motion",
    "frozensets_called",
    _FROZEN + _put(999) + b")R" + _put(0) + b"0"
    + b"".join(
        _get(999) + b"(" + _get(k) + _get(999) + b"(" + _get(k) + b"l\x85Rl\x85R" + _put(k + 1)
        + b"0"
        for k in range(60)
    )
    + _get(60) + b".",
)  # fmt: skip
#: A key of a dict that is a tuple of the one before twice, 100 times: its hash takes 2^100 steps.
_KEY = (
    b"K\x01" + _put(0) + b"0"
    + b"".join(_get(k) + _get(k) + b"\x86" + _put(k + 1) + b"0" for k in range(100))
    + _get(100)
)  # fmt: skip
_pickled("motion", "tuples_as_key", b"}" + _KEY + b"K\x01s.")
_pickled("motion", "tuples_as_keys", b"}(" + _KEY + b"K\x01u.")
_pickled("motion", "tuples_in_a_set", b"\x8f(" + _KEY + b"\x90.")
_pickled("motion", "tuples_in_a_dict_called", b"cbuiltins\ndict\n(" + _KEY + b"K\x01\x86l\x85R.")
#: A tuple in a tuple, 300,000 deep, as a key: the hash goes down on the stack of C.
_pickled("motion", "deep_tuple_as_key", b"})" + b"\x85" * 300_000 + b"K\x01s.")
#: Whole numbers of one hash: 60,000 of them take 2 * 10^9 comparisons.
_pickled(
    "motion",
    "keys_of_one_hash",
    b"}(" + b"".join(pickle.dumps(k * (2**61 - 1), 2)[2:-1] + b"N" for k in range(60_000)) + b"u.",
)
#: A list of 10^5 numbers, copied 10^5 times.
_BASE = b"](" + b"K\x01" * 100_000 + b"e" + _put(0) + b"0"
for _name, _kind in (("lists", b"list"), ("tuples", b"tuple")):
    _pickled(
        "motion",
        f"{_name}_by_squares",
        _BASE + b"cbuiltins\n" + _kind + b"\n" + _put(1) + b"0]("
        + (_get(1) + _get(0) + b"\x85R") * 100_000 + b"e.",
    )  # fmt: skip
_pickled(
    "motion",
    "tuples_made_new",
    _BASE + b"cbuiltins\ntuple\n" + _put(1) + b"0](" + (_get(1) + _get(0) + b"\x85\x81") * 100_000
    + b"e.",
)  # fmt: skip
_pickled(
    "motion",
    "encode_by_squares",
    text("x" * 100_000) + _put(0) + b"0" + _ENCODE + _put(1) + b"0]("
    + (_get(1) + _get(0) + b"\x85R") * 100_000 + b"e.",
)  # fmt: skip
_pickled(
    "motion",
    "bytearrays_by_squares",
    text("x" * 100_000) + _put(0) + b"0cbuiltins\nbytearray\n" + _put(1) + b"0]("
    + (_get(1) + _get(0) + b"\x85R") * 100_000 + b"e.",
)  # fmt: skip
#: Lists of references to lists of references: 10^12 numbers once somebody unfolds them.
UNFOLDS = (
    b"](" + b"K\x01" * 1000 + b"e" + _put(0) + b"0"
    + b"".join(b"](" + _get(k) * 1000 + b"e" + _put(k + 1) + b"0" for k in range(3))
    + _get(3)
)  # fmt: skip
_pickled("motion", "lists_that_unfold", b"}" + text("poses") + UNFOLDS + b"s.")
_pickled(
    "motion",
    "lists_that_unfold_as_fields",
    b"}("
    + b"".join(
        text(key) + (UNFOLDS if n == 0 else _get(3))
        for n, key in enumerate(("smpl_poses", "smpl_trans", "smpl_scaling"))
    )
    + b"u.",
)
#: One array of a megabyte, in a list a hundred thousand times.
_pickled(
    "motion",
    "an_array_many_times",
    b"}" + text("smpl_poses") + b"](" + pickle.dumps(np.zeros(2**17), 2)[2:-1] + _put(9999)
    + _get(9999) * 100_000 + b"es.",
)  # fmt: skip
#: The bytes of one array, made into an array again and again.
_STATE = pickle.dumps(bytes(2**20), 4)[2:-1]
_pickled(
    "motion",
    "arrays_of_the_same_bytes",
    _STATE + _put(8000) + b"0cnumpy.core.numeric\n_frombuffer\n" + _put(8001) + b"0"
    + pickle.dumps(np.dtype("u1"), 2)[2:-1] + _put(8002) + b"0]("
    + (_get(8001) + b"(" + _get(8000) + _get(8002) + b"J\x00\x00\x10\x00U\x01CtR") * 100_000
    + b"e.",
)  # fmt: skip
#: A text of letters that are no Latin, taken apart again and again: each letter is an object.
_pickled(
    "motion",
    "letters_taken_apart",
    text("\u2603" * 100_000) + _put(8000) + b"0cbuiltins\nlist\n" + _put(8001) + b"0]("
    + (_get(8001) + _get(8000) + b"\x85R") * 400 + b"e.",
)  # fmt: skip
#: Named so often that each naming costs a class.
_pickled("motion", "names_of_chumpy", b"](" + b"cchumpy.ch\nCh\n)\x81" * 100_000 + b"e.")
_pickled(
    "motion",
    "many_names_of_chumpy",
    b"](" + b"".join(b"cchumpy.ch\nC%d\n)\x81" % k for k in range(100_000)) + b"e.",
)


def _chumpy(state: bytes) -> bytes:
    return b"cchumpy.ch\nCh\n)\x81" + state + b"b"


#: chumpy arrays of lists that unfold, of one another, selections of selections.
_pickled("body", "chumpy_that_unfolds", _chumpy(b"}" + text("x") + UNFOLDS + b"s") + b".")
_pickled(
    "body",
    "chumpy_in_chumpy",
    pickle.dumps(np.zeros(2**19), 2)[2:-1] + _put(9999) + b"0"
    + b"".join(
        _chumpy(b"}" + text("x") + (_get(9999) if k == 0 else _get(10_000 + k - 1)) + b"s")
        + _put(10_000 + k) + b"0"
        for k in range(250)
    )
    + _get(10_249) + b".",
)  # fmt: skip
_pickled(
    "body",
    "chumpy_selections",
    pickle.dumps(np.zeros(2**19), 2)[2:-1] + _put(9999) + b"0"
    + pickle.dumps(np.zeros(2**19, np.int64), 2)[2:-1] + _put(9998) + b"0]("
    + (
        b"cchumpy.reordering\nSelect\n)\x81}(" + text("a") + _get(9999)
        + text("idxs") + _get(9998) + b"ub"
    ) * 5000
    + b"e.",
)  # fmt: skip


@attack("body")
def sparse_matrices_of_a_gigabyte(folder: Path) -> Path:
    import scipy.sparse as sp

    each = [sp.coo_matrix(([1.0], ([k], [0])), shape=(10_000, 10_000)) for k in range(30)]
    return written(folder / "a.pkl", pickle.dumps(each, 2))

"""Files that every loader refuses: each ends in one clear error and runs nothing.

A case is a name and a function that spoils the fields of a good file; how fields become a file is
the format's own task (`write`). Broken bytes are the same for all formats.
"""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning

Fields = dict[str, Any]
Case = tuple[str, Callable[[Fields], Any], str]


def without(key: str) -> Callable[[Fields], Any]:
    return lambda f: f.pop(key)


def put(key: str, value: Any) -> Callable[[Fields], Any]:
    return lambda f: f.__setitem__(key, value)


def changed(key: str, how: Callable[[np.ndarray], Any]) -> Callable[[Fields], Any]:
    return lambda f: f.__setitem__(key, how(np.array(f[key])))


def spoilt(key: str, index: Any, value: float) -> Callable[[Fields], Any]:
    """One number of a field replaced."""

    def spoil(array: np.ndarray) -> np.ndarray:
        array = array.astype(np.float64)
        array[index] = value
        return array

    return changed(key, spoil)


def uneven(key: str) -> Case:
    """Rows of different lengths, which are no array: for files that hold lists."""

    def spoil(array: np.ndarray) -> list[Any]:
        return [*array.tolist(), array[-1][:-1].tolist()]

    return f"{key} uneven", changed(key, spoil), rf"'{key}'.*expected"


def usual(key: str) -> list[Case]:
    """Faults of numbers per frame, `key` (T, n)."""
    return [
        (f"no {key}", without(key), rf"'{key}' is missing"),
        (f"{key} too wide", changed(key, lambda a: np.hstack([a, a])), rf"'{key}'.*expected"),
        (f"{key} too narrow", changed(key, lambda a: a[:, :-1]), rf"'{key}'.*expected"),
        (f"{key} flat", changed(key, lambda a: a.reshape(-1)), rf"'{key}'.*expected"),
        (f"{key} of text", changed(key, lambda a: a.astype(str)), rf"'{key}'.*expected"),
        (f"{key} NaN", spoilt(key, (3, 0), np.nan), rf"'{key}'.*NaN.*frame 3"),
        (f"{key} infinite", spoilt(key, (4, 1), np.inf), rf"'{key}'.*infinite.*frame 4"),
        (f"{key} too short", changed(key, lambda a: a[:-2]), "different length|frames"),
    ]


def refused(path: Path, message: str, **options: Any) -> None:
    """Loading ends in one error of ours, on one line, that names the file and says `message`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        with pytest.raises(HalfPhysicsError, match=f"(?s){message}") as caught:
            hp.load_sequence(path, **options)
    text = str(caught.value)
    assert path.name in text
    assert "\n" not in text


class Boom:
    """Runs a command when it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> Any:
        return (Path.touch, (self.mark,))


def hostile_is_refused(path: Path, fields: Fields, key: str, **options: Any) -> None:
    """A pickle with a call in place of a field: refused, nothing run."""
    mark = path.parent / "was_run"
    path.write_bytes(pickle.dumps({**fields, key: Boom(mark)}))
    refused(path, "unsafe or unknown content", **options)
    assert not mark.exists()


def broken_bytes_are_refused(good: Path, **options: Any) -> None:
    """Every truncation is an error of ours; every flipped byte is, or is harmless."""
    whole = good.read_bytes()
    path = good.with_name(f"broken{good.suffix}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        for length in np.linspace(0, len(whole) - 1, 24).astype(int):
            path.write_bytes(whole[:length])
            with pytest.raises(HalfPhysicsError):
                hp.Motion.load(path, **options)
        rng = np.random.default_rng(0)
        for _ in range(40):
            bad = bytearray(whole)
            bad[rng.integers(len(bad))] ^= 1 << rng.integers(8)
            path.write_bytes(bytes(bad))
            try:
                hp.Motion.load(path, **options)
            except HalfPhysicsError:
                continue

"""Shards as HDF5: a group for each sample, in it a group for each file, its arrays as datasets.

The same tar gives the same bytes: the file contains no times, and the version of the format is
fixed (HDF5 1.10).
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.json_files import text_of
from halfphysics.base.npz_bytes import packs
from halfphysics.errors import FileError, MissingDependencyError

if TYPE_CHECKING:
    import h5py

# Arrays of at least the first size are compressed, in chunks of about the second size [bytes].
_PACKED, _CHUNK = 4096, 1 << 20


def convert(read: Iterable[dict[str, Any]], path: Path) -> None:
    """Write samples into an HDF5 file, one at a time.

    Args:
        read: Samples as `reading.read` yields them from a tar.
        path: The file; an old one is replaced.

    Raises:
        MissingDependencyError: h5py is not installed.
        FileError: The tar is damaged.
        OSError: The file cannot be written.
    """
    h5 = _h5py()
    with _Sink(path) as sink:
        with h5.File(sink, "w", libver=("v110", "v110"), track_order=False) as file:
            for sample in read:
                _add(file, sample)
                if sink.error is not None:
                    break
        if sink.error is not None:
            raise sink.error


class _Sink(io.RawIOBase):
    """A file that hides write errors from the HDF5 library and keeps the first one.

    The library does not handle a full disk: it reports the error from destructors, prints, and
    crashes when the process ends. Here every write appears to succeed, and `convert` stops at the
    next sample.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("w+b", buffering=0)
        self.error: OSError | None = None

    def close(self) -> None:
        self._file.close()
        super().close()

    def write(self, data: Any) -> int:
        rest = memoryview(data)
        try:
            while self.error is None and len(rest):
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self.error = error
        return len(data)

    def truncate(self, size: int | None = None) -> int:
        try:
            return self._file.truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size or 0

    def readinto(self, buffer: Any) -> int:
        return self._file.readinto(buffer)

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()


def _add(file: h5py.File, sample: dict[str, Any]) -> None:
    group = file.create_group(sample.pop("key"))
    group.attrs["card"] = text_of(sample.pop("card"))
    for name, arrays in sample.items():
        part = group.create_group(name)
        for key, array in arrays.items():
            _put(part, key, array)


def _put(group: h5py.Group, key: str, array: NDArray[Any]) -> None:
    """Write a dataset, compressed where that is cheap, as in `npz_bytes`.

    A slash would create a group of the name before it, which may be a dataset itself ("body",
    "body/cup"): such keys are written with a colon, and an attribute keeps the original key.
    """
    options: dict[str, Any] = {}
    if array.dtype.kind == "U":  # HDF5 has no UTF-32 text
        array, options = array.astype(object), {"dtype": _h5py().string_dtype()}
    elif array.nbytes >= _PACKED and packs(array):
        rows = max(1, _CHUNK * len(array) // array.nbytes)
        options = {
            "chunks": (min(rows, len(array)), *array.shape[1:]),
            "compression": "gzip",
            "compression_opts": 1,
        }
    name = key.replace("/", ":")
    while name in group:
        name += "_"
    dataset = group.create_dataset(name, data=array, track_times=False, **options)
    if name != key:
        dataset.attrs["key"] = key


def samples(path: Path, parts: Collection[str] | None = None) -> Iterator[dict[str, Any]]:
    """The samples of an HDF5 shard, as `sweep.read` yields them."""
    with _opened(path) as file:
        for key in file:
            yield _sample(file[key], key, parts)


def keys(path: Path) -> list[str]:
    """The keys of the samples of an HDF5 shard."""
    with _opened(path) as file:
        return list(file)


def sample(path: Path, key: str) -> dict[str, Any]:
    """One sample of an HDF5 shard."""
    with _opened(path) as file:
        return _sample(file[key], key, None)


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    h5 = _h5py()
    try:
        with h5.File(path, "r") as file:
            yield file
    except (OSError, KeyError, RuntimeError, ValueError) as error:
        raise FileError(
            f"{path}: damaged, or no shard of a sweep ({error}). Delete it and run the sweep "
            "again in its folder: what is missing is made again"
        ) from None


def _sample(group: h5py.Group, key: str, parts: Collection[str] | None) -> dict[str, Any]:
    sample: dict[str, Any] = {"key": key}
    if parts is None or "card" in parts:
        sample["card"] = json.loads(group.attrs["card"])
    for name, part in group.items():
        if parts is None or name in parts:
            sample[name] = {its.attrs.get("key", key): _array(its) for key, its in part.items()}
    return sample


def _array(dataset: h5py.Dataset) -> NDArray[Any]:
    if dataset.dtype.kind == "O":
        return np.array(dataset.asstr()[()], dtype=np.str_)
    return np.asarray(dataset[()])


def check() -> None:
    """Check for h5py at the start, not when the first shard is sealed.

    Raises:
        MissingDependencyError: h5py is not installed.
    """
    _h5py()


def _h5py() -> Any:
    # The store has its own lock; many file systems of clusters support no file locks.
    os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
    try:
        import h5py
    except ImportError as error:
        raise MissingDependencyError(
            "HDF5 shards need h5py: pip install 'halfphysics[hdf5]' (or pip install h5py)"
        ) from error
    return h5py

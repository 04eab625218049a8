"""Files of `torch.save`, read and written without torch: tensors are numpy arrays here.

A zip of `NAME/data.pkl`, a pickle that names tensors, and `NAME/data/KEY`, their raw numbers.
"""

from __future__ import annotations

import pickle
import zipfile
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.atomic import atomic_write
from halfphysics.base.npz import DAMAGE, MAX_MEMBERS, MAX_RATIO
from halfphysics.base.pickle_budget import FREE_BYTES, spend
from halfphysics.base.pickle_placeholders import MAX_BYTES, Placeholder, Refused
from halfphysics.base.restricted_pickle import Guests, loads
from halfphysics.base.validation import shown
from halfphysics.errors import FileError

#: First number of a file of torch before 1.6, which is no zip archive.
OLD_MAGIC = 0x1950A86A20F9469CFC6C
_PICKLE = "/data.pkl"
_TYPES = {
    "DoubleStorage": "f8", "FloatStorage": "f4", "HalfStorage": "f2", "LongStorage": "i8",
    "IntStorage": "i4", "ShortStorage": "i2", "CharStorage": "i1", "ByteStorage": "u1",
    "BoolStorage": "?",
}  # fmt: skip


class _Storage(Placeholder):
    """Numbers (n,) that tensors are views of."""

    origin = "torch.storage"
    values: NDArray[Any]

    def resolve(self, settle: Any) -> NDArray[Any]:
        return self.values


def is_torch(path: Path) -> bool:
    """Whether a zip archive is a file of `torch.save`."""
    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.endswith(_PICKLE) for name in archive.namelist())
    except DAMAGE:
        return False


def read(path: Path) -> Any:
    """The data of a file of `torch.save`.

    Raises:
        FileError: It is damaged or absurdly large, or holds anything but data.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            size = path.stat().st_size
            total = sum(info.file_size for info in archive.infolist())
            # torch does not compress: so much comes of zeros that somebody packed again.
            most = min(MAX_BYTES, max(FREE_BYTES, MAX_RATIO * size))
            if total > most or len(archive.infolist()) > MAX_MEMBERS:
                raise FileError(
                    f"{path}: unpacks from {size / 2**20:.1f} MiB to {total / 2**20:.0f} MiB in "
                    f"{len(archive.infolist())} members, expected at most {most / 2**20:.0f} MiB "
                    f"in {MAX_MEMBERS}"
                )
            inner = next(name for name in archive.namelist() if name.endswith(_PICKLE))
            return _Reader(archive, inner.removesuffix(_PICKLE), path).data
    except DAMAGE as error:
        raise FileError(
            f"{path}: damaged or truncated torch file ({error}). Download or copy the file again"
        ) from None


class _Reader:
    def __init__(self, archive: zipfile.ZipFile, root: str, path: Path) -> None:
        self._archive, self._root = archive, root
        self._storages: dict[str, _Storage] = {}
        members = archive.namelist()
        order = f"{root}/byteorder"
        big = order in members and archive.read(order).strip() == b"big"
        self._order: Literal["<", ">"] = ">" if big else "<"
        types = {name: name for name in _TYPES}
        rebuild = {"_rebuild_tensor_v2": _tensor, "_rebuild_parameter": _parameter}
        guests = Guests(globals={"torch": types, "torch._utils": rebuild}, persistent=self._storage)
        #: The object that the file holds.
        self.data = loads(
            archive.read(f"{root}{_PICKLE}"), path, guests, on_disk=path.stat().st_size
        )

    def _storage(self, pid: Any) -> _Storage:
        kind, key = (pid[1], pid[2]) if isinstance(pid, tuple) and len(pid) >= 3 else (None, None)
        if kind not in _TYPES or pid[0] != "storage" or not isinstance(key, str):
            raise Refused("a persistent object that is no storage of numbers")
        if key not in self._storages:
            dtype = np.dtype(_TYPES[kind])
            raw = self._archive.read(f"{self._root}/data/{key}")
            spend(len(raw))
            values = np.frombuffer(raw, dtype.newbyteorder(self._order))
            self._storages[key] = _Storage()
            self._storages[key].values = values.astype(dtype)
        return self._storages[key]


def _tensor(storage: Any, offset: Any, size: Any, stride: Any, *rest: Any) -> NDArray[Any]:
    """torch._utils._rebuild_tensor_v2: a view of a storage, here a copy of it."""
    if not isinstance(storage, _Storage):
        raise Refused("a tensor of no storage")
    size, stride = tuple(int(n) for n in size), tuple(int(n) for n in stride)
    offset, values = int(offset), storage.values
    count = 1
    for n in size:
        count *= n
    last = offset + sum((n - 1) * step for n, step in zip(size, stride, strict=True))
    fits = min((*size, *stride, offset), default=0) >= 0 and len(size) <= 32
    # A step of zero repeats numbers: never more of them than there are.
    if not fits or count > len(values) or (count and last >= len(values)):
        raise ValueError(f"a tensor of shape {shown(size)} in a storage of {len(values)} numbers")
    steps = [step * values.itemsize for step in stride]
    if not count:
        return np.zeros(size, values.dtype)
    spend(count * values.itemsize)
    return np.lib.stride_tricks.as_strided(values[offset:], size, steps).copy()


def _parameter(data: Any, *rest: Any) -> Any:
    """torch._utils._rebuild_parameter: a tensor that was trained."""
    return data


def write(path: Path, array: NDArray[np.float32]) -> None:
    """Write one tensor of single precision, as `torch.save` does.

    Raises:
        FileError: The folder is missing or cannot be written; nothing is left behind.
    """
    numbers = np.array(array, dtype="<f4", order="C")
    strides = tuple(step // numbers.itemsize for step in numbers.strides)
    named = b"c%s\n%s\n"  # a global by name, which only the reader looks up
    storage = (
        b"(" + _plain("storage") + named % (b"torch", b"FloatStorage")
        + _plain("0") + _plain("cpu") + _plain(numbers.size) + b"tQ"
    )  # fmt: skip
    tensor = (
        b"\x80\x02" + named % (b"torch._utils", b"_rebuild_tensor_v2") + b"(" + storage
        + _plain(0) + _plain(numbers.shape) + _plain(strides) + _plain(False)
        + named % (b"collections", b"OrderedDict") + b")RtR."
    )  # fmt: skip
    with atomic_write(path) as handle, zipfile.ZipFile(handle, "w") as archive:
        for name, content in (
            (f"archive{_PICKLE}", tensor),
            ("archive/byteorder", b"little"),
            ("archive/data/0", numbers.tobytes()),
            ("archive/version", b"3\n"),
        ):
            info = zipfile.ZipInfo(name)  # of 1980: the bytes depend on the content only
            info.external_attr = 0o644 << 16
            archive.writestr(info, content)


def _plain(value: Any) -> bytes:
    """The opcodes that put a number, a string or a tuple of numbers on the stack."""
    return pickle.dumps(value, protocol=2)[2:-1]

"""Files of `torch.save`, read and written without torch: tensors are numpy arrays here.

A zip of `NAME/data.pkl`, a pickle that names tensors, and `NAME/data/KEY`, their raw numbers.

Before torch 1.6 it was no zip but pickles in a row: two numbers and a dict about the program, the
data, a list of keys; then for each key a count (8 bytes) and the raw numbers. Tensors in any other
pickle (numpy, joblib) still hold their storages as bytes of this form.
"""

from __future__ import annotations

import io
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
from halfphysics.base.restricted_pickle import Guests, load_from, loads
from halfphysics.base.validation import shown
from halfphysics.errors import FileError

#: First number of a file of torch before 1.6, which is no zip archive.
OLD_MAGIC = 0x1950A86A20F9469CFC6C
_PICKLE = "/data.pkl"
_TYPES = {
    "DoubleStorage": "f8", "FloatStorage": "f4", "HalfStorage": "f2", "LongStorage": "i8",
    "IntStorage": "i4", "ShortStorage": "i2", "CharStorage": "i1", "ByteStorage": "u1",
    "BoolStorage": "?", "BFloat16Storage": "u2",
}  # fmt: skip
#: The upper half of a number of single precision.
_BFLOAT16 = "BFloat16Storage"


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
        guests = Guests(globals=_GLOBALS, persistent=self._storage)
        #: The object that the file holds.
        self.data = loads(
            archive.read(f"{root}{_PICKLE}"), path, guests, on_disk=path.stat().st_size
        )

    def _storage(self, pid: Any) -> _Storage:
        kind, key = _named(pid)
        if key not in self._storages:
            raw = self._archive.read(f"{self._root}/data/{key}")
            spend(len(raw))
            self._storages[key] = _storage_of(kind, raw, self._order)
        return self._storages[key]


def _named(pid: Any) -> tuple[str, str]:
    """Type and key of the storage that a persistent id names."""
    kind, key = (pid[1], pid[2]) if isinstance(pid, tuple) and len(pid) >= 3 else (None, None)
    if not isinstance(kind, str) or kind not in _TYPES or pid[0] != "storage":
        raise Refused("a persistent object that is no storage of numbers")
    if not isinstance(key, str) or (len(pid) > 5 and pid[5] is not None):
        raise Refused("a persistent object that is no storage of numbers")
    return kind, key


def _storage_of(kind: str, raw: bytes, order: Literal["<", ">"]) -> _Storage:
    dtype = np.dtype(_TYPES[kind])
    values = np.frombuffer(raw, dtype.newbyteorder(order)).astype(dtype)
    if kind == _BFLOAT16:
        values = (values.astype(np.uint32) << 16).view(np.float32)
    storage = _Storage()
    storage.values = values
    return storage


def read_old(data: bytes, name: str = "torch storage") -> Any:
    """The data of a file before torch 1.6 in memory; messages call it `name`.

    Raises:
        FileError: It is damaged, or holds anything but data.
    """
    stream = io.BytesIO(data)
    found: dict[str, str] = {}
    storages: dict[str, _Storage] = {}

    def noted(pid: Any) -> _Storage:
        kind, key = _named(pid)
        found[key] = kind
        return _storage_of(kind, b"", "<")

    # The numbers come after the pickle that makes tensors of them: it is read twice.
    if load_from(stream, name) != OLD_MAGIC:
        raise FileError(f"{name}: not bytes of torch. Download or copy the file again")
    load_from(stream, name)
    load_from(stream, name)
    start = stream.tell()
    unmade = {"torch": _GLOBALS["torch"], "torch._utils": dict.fromkeys(_REBUILD, _unmade)}
    load_from(stream, name, Guests(globals=unmade, persistent=noted))
    try:
        for key in load_from(stream, name):
            size = int.from_bytes(stream.read(8), "little") * np.dtype(_TYPES[found[key]]).itemsize
            raw = stream.read(size)
            if len(raw) != size:
                raise ValueError(f"{len(raw)} bytes of {size} of a storage")
            storages[key] = _storage_of(found[key], raw, "<")
    except (KeyError, TypeError, ValueError) as error:
        raise FileError(
            f"{name}: damaged or truncated torch file ({error}). Download or copy the file again"
        ) from None
    stream.seek(start)
    guests = Guests(globals=_GLOBALS, persistent=lambda pid: storages[_named(pid)[1]])
    content = load_from(stream, name, guests)
    return content


def _inline(data: Any) -> _Storage:
    """torch.storage._load_from_bytes: a storage as the bytes of a file of its own."""
    if not isinstance(data, bytes):
        raise Refused("torch.storage._load_from_bytes of something that is no bytes")
    values = read_old(data)
    if not isinstance(values, np.ndarray):
        raise Refused("torch.storage._load_from_bytes of something that is no storage")
    storage = _Storage()
    storage.values = values
    return storage


def _no_persistent(pid: Any) -> Any:
    raise Refused("a persistent object")


def _unmade(*args: Any) -> None:
    return None


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


def _with_state(make: Any, kind: Any, args: Any, state: Any) -> Any:
    """torch._tensor._rebuild_from_type_v2: a tensor with attributes, which are left out."""
    if make not in _REBUILD.values() or not isinstance(args, tuple):
        raise Refused("torch._tensor._rebuild_from_type_v2 of something that is no tensor")
    return make(*args)


_REBUILD: dict[str, Any] = {"_rebuild_tensor_v2": _tensor, "_rebuild_parameter": _parameter}
_GLOBALS: dict[str, dict[str, Any]] = {
    "torch": {**{name: name for name in _TYPES}, "Size": tuple, "Tensor": "Tensor"},
    "torch._utils": _REBUILD,
    "torch._tensor": {"_rebuild_from_type_v2": _with_state},
    "torch.nn.parameter": {"Parameter": "Parameter"},
}
#: For pickles of other programs (numpy, joblib) that hold tensors.
INLINE = Guests(
    globals={**_GLOBALS, "torch.storage": {"_load_from_bytes": _inline}}, persistent=_no_persistent
)


def write(path: Path, data: Any) -> None:
    """Write a tensor, or a dict of tensors, of such dicts, numbers and strings, as `torch.save`.

    Arrays of whole numbers become tensors of 64 bits, all others of single precision.

    Raises:
        FileError: The folder is missing or cannot be written; nothing is left behind.
    """
    tensors: list[NDArray[Any]] = []
    content = b"\x80\x02" + _content(data, tensors) + b"."
    members = [(f"archive{_PICKLE}", content), ("archive/byteorder", b"little")]
    members += [(f"archive/data/{k}", numbers.tobytes()) for k, numbers in enumerate(tensors)]
    members += [("archive/version", b"3\n")]
    with atomic_write(path) as handle, zipfile.ZipFile(handle, "w") as archive:
        for name, raw in members:
            info = zipfile.ZipInfo(name)  # of 1980: the bytes depend on the content only
            info.external_attr = 0o644 << 16
            archive.writestr(info, raw)


def _content(value: Any, tensors: list[NDArray[Any]]) -> bytes:
    """The opcodes that put a value on the stack; its tensors are added to `tensors`."""
    if isinstance(value, dict):
        pairs = (_plain(key) + _content(own, tensors) for key, own in value.items())
        return b"}(" + b"".join(pairs) + b"u"
    if not isinstance(value, np.ndarray):
        return _plain(value)
    whole = value.dtype.kind in "iu"
    numbers = np.array(value, dtype="<i8" if whole else "<f4", order="C")
    strides = tuple(step // numbers.itemsize for step in numbers.strides)
    named = b"c%s\n%s\n"  # a global by name, which only the reader looks up
    storage = (
        b"(" + _plain("storage") + named % (b"torch", b"LongStorage" if whole else b"FloatStorage")
        + _plain(str(len(tensors))) + _plain("cpu") + _plain(numbers.size) + b"tQ"
    )  # fmt: skip
    tensors.append(numbers)
    return (
        named % (b"torch._utils", b"_rebuild_tensor_v2") + b"(" + storage
        + _plain(0) + _plain(numbers.shape) + _plain(strides) + _plain(False)
        + named % (b"collections", b"OrderedDict") + b")RtR"
    )  # fmt: skip


def _plain(value: Any) -> bytes:
    """The opcodes that put a number, a string or a tuple of numbers on the stack."""
    return pickle.dumps(value, protocol=2)[2:-1]

"""The bytes that torch.save and joblib.dump write, without torch and joblib."""

from __future__ import annotations

import io
import pickle
import zipfile
from pathlib import Path

import numpy as np


class Named:
    """Pickled as a name in a module that does not exist."""

    def __init__(self, module: str, name: str) -> None:
        self.module, self.name = module, name


class Tensor:
    def __init__(self, key: str, kind: str, count: int, size, stride, offset=0) -> None:
        self.key, self.kind, self.count = key, kind, count
        self.size, self.stride, self.offset = size, stride, offset


class Inline:
    """A tensor in a pickle that is not torch's own: the bytes of its storage are in the pickle."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = np.ascontiguousarray(array)


_KINDS = {"f8": "DoubleStorage", "f4": "FloatStorage", "i8": "LongStorage", "b1": "BoolStorage"}


def kind_of(array: np.ndarray) -> str:
    return _KINDS[array.dtype.str[1:]]


def _strides(array: np.ndarray) -> tuple[int, ...]:
    return tuple(step // array.itemsize for step in array.strides)


class _Pickler(pickle._Pickler):
    """Write as torch does: globals by name, storages as persistent objects."""

    def save(self, obj, save_persistent_id=True):
        if isinstance(obj, Named):
            self.write(pickle.GLOBAL + f"{obj.module}\n{obj.name}\n".encode())
        elif isinstance(obj, Tensor):
            self.save(Named("torch._utils", "_rebuild_tensor_v2"))
            self.write(pickle.MARK)
            storage = ("storage", Named("torch", obj.kind), obj.key, "cpu", obj.count)
            super().save(storage, save_persistent_id=False)
            self.write(pickle.BINPERSID)
            for item in (obj.offset, obj.size, obj.stride, False, {}):
                self.save(item)
            self.write(pickle.TUPLE + pickle.REDUCE)
        elif isinstance(obj, Inline):
            self.save(Named("torch._utils", "_rebuild_tensor_v2"))
            self.write(pickle.MARK)
            self.save(Named("torch.storage", "_load_from_bytes"))
            self.save((old_torch_bytes(_Root(obj.array), {"7": obj.array}),))
            self.write(pickle.REDUCE)
            for item in (0, obj.array.shape, _strides(obj.array), False, {}):
                self.save(item)
            self.write(pickle.TUPLE + pickle.REDUCE)
        elif isinstance(obj, _Root):
            kind, size = Named("torch", kind_of(obj.array)), obj.array.size
            super().save(("storage", kind, "7", "cpu", size, None), save_persistent_id=False)
            self.write(pickle.BINPERSID)
        else:
            super().save(obj, save_persistent_id)


class _Root:
    """A storage that is all that a file holds."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array


def pickled(data, protocol: int = 2) -> bytes:
    """A pickle that may hold `Inline` tensors."""
    buffer = io.BytesIO()
    _Pickler(buffer, protocol).dump(data)
    return buffer.getvalue()


def old_torch_bytes(data, storages: dict[str, np.ndarray]) -> bytes:
    """A file of torch before 1.6: pickles in a row, then the raw numbers."""
    about = {"protocol_version": 1001, "little_endian": True, "type_sizes": {"short": 2}}
    out = b"".join(pickled(part) for part in (0x1950A86A20F9469CFC6C, 1001, about, data))
    out += pickled(list(storages))
    for array in storages.values():
        out += array.size.to_bytes(8, "little") + array.tobytes()
    return out


def as_tensors(data, storages: dict[str, np.ndarray]):
    """Nested dicts of arrays as tensors of one storage each, which are added to `storages`."""
    if isinstance(data, dict):
        return {key: as_tensors(value, storages) for key, value in data.items()}
    if not isinstance(data, np.ndarray):
        return data
    array, key = np.ascontiguousarray(data), str(len(storages))
    storages[key] = array
    return Tensor(key, kind_of(array), array.size, array.shape, _strides(array))


def torch_dict(path: Path, data) -> Path:
    """`torch.save` of nested dicts of arrays."""
    storages: dict[str, np.ndarray] = {}
    tensors = as_tensors(data, storages)
    return torch_saved(path, tensors, storages)


def npy_of(path: Path, data) -> Path:
    """`numpy.save` of a dict that may hold `Inline` tensors."""
    with path.open("wb") as handle:
        header = {"descr": "|O", "fortran_order": False, "shape": ()}
        np.lib.format.write_array_header_1_0(handle, header)
        handle.write(pickled(np.array(data, dtype=object), 3))
    return path


def torch_saved(path: Path, data, storages, byteorder: str | None = "little") -> Path:
    buffer = io.BytesIO()
    _Pickler(buffer, 2).dump(data)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("clip/data.pkl", buffer.getvalue())
        for key, array in storages.items():
            archive.writestr(f"clip/data/{key}", array.tobytes())
        if byteorder is not None:
            archive.writestr("clip/byteorder", byteorder)
        archive.writestr("clip/version", "3\n")
    return path


class Wrapper:
    """An array as joblib writes it: its description, directly followed by its bytes."""

    def __init__(self, array: np.ndarray, order: str = "C") -> None:
        self.array, self.order = array, order


class _JoblibPickler(pickle._Pickler):
    def save(self, obj, save_persistent_id=True):
        if not isinstance(obj, Wrapper):
            super().save(obj, save_persistent_id)
            return
        self.write(pickle.GLOBAL + b"joblib.numpy_pickle\nNumpyArrayWrapper\n")
        self.write(pickle.EMPTY_TUPLE + pickle.NEWOBJ)
        state = {
            "subclass": np.ndarray,
            "shape": obj.array.shape,
            "order": obj.order,
            "dtype": obj.array.dtype,
            "allow_mmap": True,
            "numpy_array_alignment_bytes": 16,
        }
        super().save(state)
        self.write(pickle.BUILD)
        if self.proto >= 4:
            self.framer.commit_frame(force=True)
        if obj.array.dtype.hasobject:
            pickle.dump(obj.array, self.file, protocol=2)
            return
        self.file.write(b"\x05" + b"\xff" * 5 + obj.array.tobytes(order=obj.order))


def wrapped(data):
    """Nested dicts and lists with arrays as joblib writes them."""
    if isinstance(data, dict):
        return {key: wrapped(value) for key, value in data.items()}
    if isinstance(data, list):
        return [wrapped(value) for value in data]
    plain = isinstance(data, np.ndarray) and not data.dtype.hasobject and data.ndim > 0
    return Wrapper(data) if plain else data


def joblib_dump(data, protocol: int = 2) -> bytes:
    buffer = io.BytesIO()
    pickler = _JoblibPickler(buffer, protocol)
    pickler.file = buffer
    pickler.dump(data)
    return buffer.getvalue()

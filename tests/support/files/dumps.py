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
        else:
            super().save(obj, save_persistent_id)


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


def joblib_dump(data, protocol: int = 2) -> bytes:
    buffer = io.BytesIO()
    pickler = _JoblibPickler(buffer, protocol)
    pickler.file = buffer
    pickler.dump(data)
    return buffer.getvalue()

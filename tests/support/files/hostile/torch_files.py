"""Files of torch whose storages are shared, overlap or are not there."""

from __future__ import annotations

import pickle
import struct
import zipfile
from pathlib import Path

import numpy as np

from halfphysics.base.torch_file import OLD_MAGIC
from support.files.dumps import Tensor, torch_saved
from support.files.hostile.attacks import attack, written


def _torch(folder: Path, data, storages, kind=zipfile.ZIP_DEFLATED) -> Path:
    plain = torch_saved(folder / "plain.pt", data, storages)
    path = folder / "a.pt"
    with zipfile.ZipFile(plain) as old, zipfile.ZipFile(path, "w", kind, compresslevel=1) as new:
        for name in old.namelist():
            new.writestr(name, old.read(name))
    plain.unlink()
    return path


@attack("motion")
def torch_storage_of_zeros(folder: Path) -> Path:
    count = 2**27  # 512 MiB in half a megabyte
    tensor = Tensor("0", "FloatStorage", count, (count // 591, 591), (591, 1))
    return _torch(folder, tensor, {"0": np.zeros(count, "f4")})


@attack("motion")
def torch_tensors_of_one_storage(folder: Path) -> Path:
    count = 2**18
    whole = [Tensor("0", "FloatStorage", count, (count,), (1,)) for _ in range(20_000)]
    return _torch(folder, {"poses": whole}, {"0": np.zeros(count, "f4")}, zipfile.ZIP_STORED)


@attack("motion")
def torch_strides_that_overlap(folder: Path) -> Path:
    tensor = Tensor("0", "FloatStorage", 64, (2**20, 2**20), (0, 0))
    return _torch(folder, {"poses": tensor}, {"0": np.zeros(64, "f4")}, zipfile.ZIP_STORED)


@attack("motion")
def torch_sizes_that_lie(folder: Path) -> Path:
    tensor = Tensor("0", "FloatStorage", 2**40, (2**40,), (1,))
    return _torch(folder, {"poses": tensor}, {"0": np.zeros(64, "f4")}, zipfile.ZIP_STORED)


@attack("motion")
def torch_dimensions_by_the_thousand(folder: Path) -> Path:
    tensor = Tensor("0", "FloatStorage", 64, (1,) * 5000, (1,) * 5000)
    return _torch(folder, {"poses": tensor}, {"0": np.zeros(64, "f4")}, zipfile.ZIP_STORED)


@attack("motion")
def torch_storages_that_are_files_of_their_own(folder: Path) -> Path:
    """400 times the same bytes, each a file of a matrix of 32 MB of which nothing is stored."""
    import scipy.sparse as sp

    parts = (OLD_MAGIC, 1001, {}, sp.csc_matrix((2000, 2000)), [])
    inner = b"".join(pickle.dumps(part, 2) for part in parts)
    each = b"ctorch.storage\n_load_from_bytes\nh\x00\x85R"
    head = b"\x80\x03B" + struct.pack("<I", len(inner)) + inner + b"q\x000]("
    return written(folder / "a.pkl", head + 400 * each + b"e.")

"""npy and npz whose headers and directories lie."""

from __future__ import annotations

import io
import struct
import zipfile
from pathlib import Path

import numpy as np

from support.files.hostile.attacks import attack, written
from support.files.hostile.pickles import UNFOLDS, text


def _npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, array)
    return stream.getvalue()


def _amass(folder: Path, more: dict[str, bytes], without: tuple[str, ...] = ()) -> Path:
    path = folder / "a.npz"
    fields = {
        "trans": np.zeros((4, 3)), "poses": np.zeros((4, 165)), "betas": np.zeros(10),
        "gender": np.array("neutral"), "mocap_frame_rate": np.array(30.0),
    }  # fmt: skip
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for key, array in fields.items():
            if key not in more and key not in without:
                archive.writestr(f"{key}.npy", _npy(array))
        for key, content in more.items():
            archive.writestr(f"{key}.npy", content)
    return path


def _zeros(folder: Path, key: str, shape: tuple[int, ...]) -> Path:
    path = _amass(folder, {}, (key,))
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open(f"{key}.npy", "w", force_zip64=True) as stream,
    ):
        head = {"descr": "<f8", "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(stream, head)
        left = 8 * int(np.prod(shape))
        while left:
            left -= stream.write(bytes(min(left, 2**22)))
    return path


@attack("motion")
def npz_with_800_megabytes_of_betas(folder: Path) -> Path:
    return _zeros(folder, "betas", (100_000_000,))


@attack("motion")
def npz_with_200_megabytes_of_betas(folder: Path) -> Path:
    """Zeros that may be there, in a place where they may not."""
    return _zeros(folder, "betas", (25_000_000,))


@attack("motion")
def npz_with_200_megabytes_of_rate(folder: Path) -> Path:
    return _zeros(folder, "mocap_frame_rate", (25_000_000,))


@attack("motion")
def npz_with_200_megabytes_of_gender(folder: Path) -> Path:
    return _zeros(folder, "gender", (25_000_000,))


@attack("motion")
def npz_of_20_000_members(folder: Path) -> Path:
    return _amass(folder, {f"k{k:05}": _npy(np.zeros(1)) for k in range(20_000)})


@attack("motion")
def npz_of_one_member_4_096_times(folder: Path) -> Path:
    """4,096 lines of the directory for one array of 2 MB."""
    path = _amass(folder, {"big": _npy(np.zeros(2**18))})
    raw = path.read_bytes()
    first = raw.index(b"PK\x01\x02")
    end = raw.index(b"PK\x05\x06")
    last = raw.rindex(b"PK\x01\x02", 0, end)
    lines, line = raw[first:last], raw[last:end]
    many = b"".join(line[:46] + (b"%03x.npy" % k)[:7] + line[53:] for k in range(4096))
    directory = lines + many
    tail = struct.pack(
        "<4s4H2LH", b"PK\x05\x06", 0, 0, (5 + 4096) & 0xFFFF, 5 + 4096, len(directory), first, 0
    )
    return written(path, raw[:first] + directory + tail)


@attack("motion")
def npy_of_objects_that_unfold(folder: Path) -> Path:
    path = folder / "a.npy"
    head = b"{'descr': '|O', 'fortran_order': False, 'shape': (), }\n"
    magic = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
    return written(path, magic + b"\x80\x04}" + text("poses") + UNFOLDS + b"s.")


@attack("motion")
def npy_with_a_header_of_4_gigabytes(folder: Path) -> Path:
    return written(folder / "a.npy", b"\x93NUMPY\x02\x00\xff\xff\xff\xff" + b"{" * 60_000)

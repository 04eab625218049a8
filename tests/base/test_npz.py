"""Archives and arrays with false headers: each gives one message, for any data behind them."""

from __future__ import annotations

import struct
import zipfile

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError
from support.files.layouts import movement

_SIZE = 12 * 322 * 8


def header(descr="'<f8'", order="False", shape="(12, 322)"):
    return f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}"


WRONG = {
    "negative": header(shape="(-12, -322)"),
    "one negative": header(shape="(-1, 322)"),
    "beyond all numbers": header(shape=f"({'9' * 200}, {'9' * 200})"),
    "petabytes": header(shape="(10000000000000, 322)"),
    "truth": header(shape="(True, 322)"),
    "fractions": header(shape="(12.0, 322)"),
    "no shape": header(shape="12"),
    "no order": header(order="2"),
    "nothing": header("'<U0'"),
    "void": header("'V0'"),
    "columns": header("[('a', '<f8')]"),
    "objects": header("'|O'"),
    "no type": header("'blah'"),
    "no key": "{[]: 1}",
    "another dict": "{1: 2}",
    "open": "{",
    "deep": "(" * 300,
    "deeper": "-" * 5000 + "1",
    "binary": "\x00\xff\\",
}


def array(head, data=bytes(_SIZE)):
    text = head.encode("latin1") + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + data


@pytest.mark.parametrize("name", WRONG)
def test_headers_that_lie(tmp_path, name):
    path = tmp_path / "wrong.npy"
    path.write_bytes(array(WRONG[name]))
    refused(path)
    hp.Motion(*movement(), 30.0).save(tmp_path / "good.npz")
    with zipfile.ZipFile(tmp_path / "good.npz") as good:
        members = {key: good.read(key) for key in good.namelist()}
    for key in ("trans.npy", "poses.npy"):
        path = tmp_path / "wrong.npz"
        with zipfile.ZipFile(path, "w") as archive:
            for other, content in members.items():
                archive.writestr(other, array(WRONG[name]) if other == key else content)
        refused(path)


def refused(path):
    with pytest.raises(FileError) as caught:
        hp.Motion.load(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.filterwarnings("ignore::halfphysics.HalfPhysicsWarning")
@pytest.mark.parametrize(
    "kind", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
)
def test_bytes_changed_anywhere(tmp_path, kind):
    hp.Motion(*movement(4), 30.0).save(tmp_path / "good.npz")
    path = tmp_path / "wrong.npz"
    with zipfile.ZipFile(tmp_path / "good.npz") as good, zipfile.ZipFile(path, "w", kind) as same:
        for key in good.namelist():
            same.writestr(key, good.read(key))
    content = path.read_bytes()
    rng = np.random.default_rng(kind)
    said = []
    for trial in range(120):
        damaged = bytearray(content)
        first = 0 if trial % 2 else content.find(b"PK\x01\x02")  # else in the directory
        for place in rng.integers(first, len(damaged), 2):
            damaged[place] = rng.integers(256)
        path.write_bytes(damaged)
        try:
            hp.Motion.load(path)
        except FileError as error:
            said.append(str(error))
    assert len(said) > 30
    assert all(str(path) in message and "\n" not in message for message in said)


def test_a_text_called_a_pickle(tmp_path, shared_data):
    text = (shared_data / "motion" / "animdraw_dab.bvh").read_text()
    want = None
    for name in ("a.bvh", "a.pkl", "a.p", "a.pt", "a.npz", "a.txt"):
        (tmp_path / name).write_text(text, encoding="utf-8-sig" if name == "a.p" else "utf-8")
        with pytest.warns(hp.HalfPhysicsWarning, match="put on the default body"):
            motion = hp.Motion.load(tmp_path / name)
        want = motion.rotations if want is None else want
        assert np.array_equal(motion.rotations, want)


def test_an_array_larger_than_its_header_is_not_unpacked(tmp_path):
    import tracemalloc

    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("trans.npy", array(header(shape="(12, 3)"), bytes(2**26)))
        archive.writestr("poses.npy", array(header(shape="(12, 165)"), bytes(2**26)))
        archive.writestr("mocap_frame_rate.npy", array(header(shape="()"), struct.pack("d", 30)))
    tracemalloc.start()
    try:
        with pytest.raises(FileError, match="'trans' is damaged"):
            hp.Motion.load(path)
        assert tracemalloc.get_traced_memory()[1] < 2**24
    finally:
        tracemalloc.stop()


def test_an_archive_that_only_fills_the_memory(tmp_path, monkeypatch):
    from halfphysics.base import npz

    monkeypatch.setattr(npz, "SUSPICIOUS_BYTES", 2**20)
    path = tmp_path / "bomb.npz"
    poses = np.zeros((2000, 165))
    poses[:, 0] = np.pi / 2
    still = {"trans": np.tile([0.0, 0.0, 0.9], (2000, 1)), "poses": poses, "fps": 30.0}
    np.savez_compressed(path, **still)
    with pytest.raises(FileError, match="expected at most 200 times its size"):
        hp.Motion.load(path)
    np.savez(path, **still, gender="male")
    assert len(hp.Motion.load(path)) == 2000


def test_what_is_no_motion_is_described(tmp_path):
    (tmp_path / "a.npz").write_text("<html>404: not found</html>")
    with pytest.raises(FileError, match="a file that begins with b'<html>404"):
        hp.Motion.load(tmp_path / "a.npz")
    with zipfile.ZipFile(tmp_path / "b.npz", "w") as archive:
        archive.write(tmp_path / "a.npz")
    with pytest.raises(FileError, match="a zip archive without arrays"):
        hp.Motion.load(tmp_path / "b.npz")

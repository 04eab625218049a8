"""glTF files of strangers: no file outside their folder, no size believed, one message each."""

from __future__ import annotations

import base64
import json
import os
import struct
import time

import numpy as np
import pytest

from halfphysics.errors import FileError
from halfphysics.formats.gltf.accessors import rows, stored
from halfphysics.formats.gltf.container import Container
from support.files.gltf_rigs import Builder

TEXT = {"asset": {"version": "2.0"}}


def small() -> Builder:
    builder = Builder()
    builder.accessor(np.arange(12.0).reshape(4, 3), "VEC3")
    return builder


def test_embedded_and_external_buffers_are_the_same(tmp_path):
    asked = np.arange(12.0).reshape(4, 3)
    uri = "data:application/octet-stream;base64," + base64.b64encode(small().data).decode()
    for name in (uri, "b.bin"):
        container = Container(small().gltf(tmp_path / "a.gltf", name))
        assert np.array_equal(rows(container, 0, "VEC3", "x"), asked)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "b.bin").write_bytes(bytes(small().data))
    container = Container(small().gltf(tmp_path / "a.gltf", "sub/b.bin"))
    assert np.array_equal(rows(container, 0, "VEC3", "x"), asked)


@pytest.mark.parametrize(
    "uri",
    ["/etc/passwd", "../secret", "sub/../../secret", "file:///etc/passwd", "http://a.b/c.bin",
     "C:\\secret", "..\\secret", "%2e%2e/secret", "%2Fetc%2Fpasswd", "link", "", "a\0b", "."],
)  # fmt: skip
def test_nothing_outside_the_folder_is_read(tmp_path, uri):
    (tmp_path / "secret").write_bytes(b"s" * 48)
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "sub").mkdir()
    (folder / "link").symlink_to(tmp_path / "secret")
    builder = small()
    builder.json["buffers"][0] = {"byteLength": 48, "uri": uri}
    (folder / "a.gltf").write_text(json.dumps(builder.json))
    with pytest.raises(FileError, match=r"buffer 0: .*(own folder|no valid base64|cannot read)"):
        rows(Container(folder / "a.gltf"), 0, "VEC3", "x")


def test_a_pipe_and_a_missing_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for uri in ("pipe", "missing.bin"):
        builder = small()
        builder.json["buffers"][0] = {"byteLength": 48, "uri": uri}
        (tmp_path / "a.gltf").write_text(json.dumps(builder.json))
        with pytest.raises(FileError, match="is not beside it"):
            rows(Container(tmp_path / "a.gltf"), 0, "VEC3", "x")


@pytest.mark.parametrize(
    ("uri", "message"),
    [("data:,abc", "no valid base64"), ("data:x;base64,@@@", "no valid base64"),
     ("data:x;base64,AAAA", "found 3 bytes, its byteLength says 48"), (7, "expected text"),
     (None, "no binary part")],
)  # fmt: skip
def test_wrong_buffers(tmp_path, uri, message):
    builder = small()
    builder.json["buffers"][0] = {"byteLength": 48}
    if uri is not None:
        builder.json["buffers"][0]["uri"] = uri
    (tmp_path / "a.gltf").write_text(json.dumps(builder.json))
    with pytest.raises(FileError, match=message):
        rows(Container(tmp_path / "a.gltf"), 0, "VEC3", "x")


def test_text_that_is_wrong_deep_or_long(tmp_path):
    path = tmp_path / "a.gltf"
    for text, message in {
        "[" * 100_000: "not valid JSON",
        "[1, 2]": "no JSON object",
        '{"asset": 3}': "asset.version: found None",
        '{"asset": {"version": "2.0"}, "nodes': "not valid JSON",
    }.items():
        path.write_text(text)
        with pytest.raises(FileError, match=message):
            Container(path)
    with path.open("wb") as handle:  # a file of 1 GiB that takes no room on the disk
        handle.write(b"{")
        handle.truncate(2**30)
    start = time.process_time()
    with pytest.raises(FileError, match=r"1024 MiB of text, expected at most 128\. Export it as"):
        Container(path)
    assert time.process_time() - start < 1.0


def test_binary_headers_that_lie(tmp_path):
    path, text = tmp_path / "a.glb", json.dumps(TEXT).encode()
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON")
    for raw, message in (
        (head[:15], "ends in its header"),
        (struct.pack("<4sIII4s", b"glTF", 1, 99, 9, b"JSON"), "found version 1"),
        (struct.pack("<4sIII4s", b"glTF", 2, 99, 2**32 - 1, b"JSON"), "MiB of text"),
        (struct.pack("<4sIII4s", b"glTF", 2, 99, 60, b"JSON"), "truncated"),
        (head + text + struct.pack("<I4s", 2**31, b"BIN\0"), "a part of 2147483648 bytes"),
    ):
        path.write_bytes(raw)
        with pytest.raises(FileError, match=message):
            Container(path)
    path.write_bytes(head + text)
    assert Container(path).entries("nodes") == []


def test_strides_types_and_normalised_numbers(tmp_path):
    builder = Builder()
    packed = np.zeros(4, dtype=[("place", "<f4", 3), ("other", "<f4")])
    packed["place"] = np.arange(12.0).reshape(4, 3)
    builder.accessor(np.frombuffer(packed.tobytes(), np.uint8)[:, None], "SCALAR", 5121)
    builder.json["bufferViews"][0]["byteStride"] = 16
    builder.json["accessors"][0] |= {"type": "VEC3", "componentType": 5126, "count": 4}
    builder.accessor(np.array([[-32767, 0, 16384, 32767]]), "VEC4", 5122)
    builder.json["accessors"][1]["normalized"] = True
    container = Container(builder.glb(tmp_path / "a.glb"))
    assert np.array_equal(rows(container, 0, "VEC3", "x"), packed["place"])
    assert np.abs(rows(container, 1, "VEC4", "x") - [[-1, 0, 16384 / 32767, 1]]).max() < 1e-15
    assert stored(container, 1, "VEC4", "x").dtype == np.dtype("<i2")
    with pytest.raises(FileError, match="expected SCALAR"):
        rows(container, 0, "SCALAR", "x")
    with pytest.raises(FileError, match="accessors: found index 9"):
        rows(container, 9, "VEC3", "x")


def test_nan_is_told_with_its_row(tmp_path):
    builder = Builder()
    builder.accessor(np.array([[0.0], [np.nan]]), "SCALAR")
    with pytest.raises(FileError, match="the times: NaN or infinite numbers, the first in row 1"):
        rows(Container(builder.glb(tmp_path / "a.glb")), 0, "SCALAR", "the times")

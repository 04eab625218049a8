"""The text and the buffers of a glTF file: `.glb` (binary) or `.gltf` (JSON, buffers beside it).

    .glb:  magic "glTF", version 2, length | length, "JSON", text | length, "BIN\\0", bytes

Files come from strangers: a buffer of its own file must be in the folder of the glTF file, and no
size is believed before the bytes are there. Buffers are mapped, not read.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import shown
from halfphysics.errors import FileError

Bytes = NDArray[np.uint8]

MAGIC = b"glTF"
_JSON_CHUNK, _BIN_CHUNK = 0x4E4F534A, 0x004E4942
#: Text of a file that has its buffers in it; parsed, it takes some times as much [bytes].
_MOST_TEXT = 128 * 2**20
#: Accessors, views, skins: far above any scene of people.
_MOST_ENTRIES = 100_000
_EMBEDDED = "data:"


class Container:
    """A file; `document` is its JSON.

    Raises:
        FileError: It is damaged, not of version 2, too large, or its lists are no lists of objects.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._binary: Bytes | None = None
        self._known: dict[int, Bytes] = {}
        self._lists: dict[str, list[dict[str, Any]]] = {}  # those that have been looked at
        text = self._text()
        try:
            document = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise self.error(f"not valid JSON ({error}). Export it again") from None
        if not isinstance(document, dict):
            raise self.error("found no JSON object, expected the text of a glTF file")
        self.document: dict[str, Any] = document
        asset = document.get("asset")
        version = asset.get("version") if isinstance(asset, dict) else None
        if not isinstance(version, str) or not version.startswith("2."):
            raise self.error(f"asset.version: found {shown(version)}, expected '2.0'")
        needed = self.document.get("extensionsRequired", [])
        if isinstance(needed, list):
            packed = [n for n in needed if "compression" in str(n) or "quantization" in str(n)]
            if packed:
                raise self.error(f"needs {packed[0]}, which is not read. Export it uncompressed")

    def error(self, text: str) -> FileError:
        return FileError(f"{self.path}: {text}")

    def entries(self, key: str) -> list[dict[str, Any]]:
        """A list of the file: nodes, skins, animations, ...; empty if it has none."""
        if key in self._lists:
            return self._lists[key]
        found = self.document.get(key, [])
        if not isinstance(found, list) or not all(isinstance(entry, dict) for entry in found):
            raise self.error(f"{key}: found {shown(found)}, expected a list of objects")
        if len(found) > _MOST_ENTRIES:
            raise self.error(f"{key}: found {len(found)}, expected at most {_MOST_ENTRIES}")
        self._lists[key] = found
        return found

    def entry(self, key: str, index: Any) -> dict[str, Any]:
        """One entry of a list."""
        found = self.entries(key)
        if not is_index(index, len(found)):
            raise self.error(f"{key}: found index {shown(index)}, expected one below {len(found)}")
        entry: dict[str, Any] = found[index]
        return entry

    def buffer(self, index: Any) -> Bytes:
        """The bytes of a buffer.

        Raises:
            FileError: It is not there, shorter than it says, or outside the file's folder.
        """
        entry = self.entry("buffers", index)
        if index not in self._known:
            found = self._bytes(index, entry)
            size = entry.get("byteLength")
            if not is_index(size, len(found) + 1):
                raise self.error(
                    f"buffer {index}: found {len(found)} bytes, its byteLength says {shown(size)}. "
                    "Copy the file again"
                )
            self._known[index] = found[:size]
        return self._known[index]

    def _text(self) -> bytes:
        try:
            size = self.path.stat().st_size
            with self.path.open("rb") as handle:
                head = handle.read(20)
                if head[:4] != MAGIC:
                    if size > _MOST_TEXT:
                        raise self._too_long(size)
                    return head + handle.read()
                if len(head) < 20:
                    raise self.error("the file ends in its header. Copy it again")
                version, length, chunk, kind = struct.unpack("<IIII", head[4:])
                if version != 2:
                    raise self.error(f"found version {version} of glTF, expected 2. Export it anew")
                if chunk > _MOST_TEXT:
                    raise self._too_long(chunk)
                if kind != _JSON_CHUNK or length > size or 20 + chunk > size:
                    raise self.error(
                        f"damaged or truncated: {size} bytes, its header says {length}. Copy it "
                        "again"
                    )
                text = handle.read(chunk)
                rest = handle.read(8)
                if len(rest) == 8:
                    count, kind = struct.unpack("<II", rest)
                    if kind == _BIN_CHUNK:
                        self._binary = self._mapped(self.path, 28 + chunk, count)
                return text
        except OSError as error:
            raise self.error(f"cannot read: {error.strerror}") from None

    def _too_long(self, size: int) -> FileError:
        return self.error(
            f"{size / 2**20:.0f} MiB of text, expected at most {_MOST_TEXT // 2**20}. Export it as "
            ".glb"
        )

    def _bytes(self, index: int, entry: Mapping[str, Any]) -> Bytes:
        uri = entry.get("uri")
        if uri is None:
            if index != 0 or self._binary is None:
                raise self.error(f"buffer {index}: has no uri, and the file no binary part for it")
            return self._binary
        if not isinstance(uri, str):
            raise self.error(f"buffer {index}: uri: found {shown(uri)}, expected text")
        if uri.startswith(_EMBEDDED):
            head, comma, data = uri.partition(",")
            try:
                if not comma or not head.endswith(";base64"):
                    raise ValueError
                return np.frombuffer(base64.b64decode(data, validate=True), dtype=np.uint8)
            except (ValueError, binascii.Error):
                raise self.error(f"buffer {index}: its data URI is no valid base64") from None
        return self._beside(index, uri)

    def _beside(self, index: int, uri: str) -> Bytes:
        """A file in the folder of the glTF file, or below it."""
        name = unquote(uri)
        folder = self.path.resolve().parent
        parts = name.split("/")
        plain = not {"", "..", "."} & set(parts) and not {"\\", ":", "\0"} & set(name)
        try:
            path = (folder / name).resolve() if plain else None
            if path is None or not path.is_relative_to(folder):
                raise self.error(
                    f"buffer {index}: uri: found {shown(uri)}, expected a file in its own folder"
                )
            if not path.is_file():
                raise self.error(f"buffer {index}: {name} is not beside it. Copy it there")
            return self._mapped(path, 0, path.stat().st_size)
        except (OSError, ValueError) as error:
            raise self.error(f"buffer {index}: cannot read {shown(name)} ({error})") from None

    def _mapped(self, path: Path, start: int, count: int) -> Bytes:
        size = path.stat().st_size
        if start + count > size:
            raise self.error(
                f"damaged or truncated: a part of {count} bytes from {start} on, and the file has "
                f"{size}. Copy it again"
            )
        if count == 0:
            return np.zeros(0, dtype=np.uint8)
        return np.memmap(path, dtype=np.uint8, mode="r", offset=start, shape=(count,))

    @cached_property
    def name(self) -> str:
        """The file's name without its ending."""
        return self.path.stem


def is_index(value: Any, below: int) -> bool:
    """Whether a value of JSON is a whole number from 0 to before `below`."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < below

"""What a mesh file may ask for, before it is read: sizes that it claims, and other files.

The rule for other files (buffers of glTF): ordinary files in the folder of the mesh file or below
it, named by relative paths that do not lead out of it, also not by links. Materials and textures
are never opened. Nothing is fetched from the net.
"""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from halfphysics.errors import FileError

#: Bytes of a mesh file and of each file that it names.
_MOST_BYTES = 2**30
#: Numbers that glTF's accessors may claim in all, over those that its file can hold.
_REPEATS = 16
#: Nodes of a glTF scene, each counted as often as it is named.
_MOST_NODES = 100_000
_HEAD = 4096
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class FolderResolver:
    """Gives trimesh the files that a mesh file names, by the rule above.

    Args:
        path: The mesh file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._folder = path.resolve().parent

    def get(self, name: str) -> bytes:
        """The content of a file.

        Raises:
            FileError: The name leads out of the folder, or to no ordinary file.
        """
        plain = unquote(str(name)).replace("\\", "/")
        target = (self._folder / plain).resolve()
        if "://" in plain or plain.startswith("/") or not target.is_relative_to(self._folder):
            raise FileError(
                f"{self._path}: names {plain[:80]!r}, expected files in its own folder. Copy it "
                "there, or save the mesh as .glb"
            )
        if not target.is_file():
            kind = "a pipe, a device or a folder" if target.exists() else "not there"
            raise FileError(f"{self._path}: names {plain[:80]!r}, which is {kind}; put it back")
        if target.stat().st_size > _MOST_BYTES:
            raise FileError(f"{self._path}: names {plain[:80]!r}, which is too large")
        return target.read_bytes()

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def keys(self) -> list[str]:
        """Nothing is listed: files are asked for by name."""
        return []

    def namespaced(self, namespace: str) -> FolderResolver:
        """For archives, which are not read."""
        return self


def check_mesh_file(path: Path) -> None:
    """Refuse a file that claims more than it holds.

    Raises:
        FileError: It is too large, or its header promises what cannot be in it.
    """
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise FileError(
            f"{path}: {size / 2**30:.1f} GiB, expected at most {_MOST_BYTES / 2**30:.0f} GiB"
        )
    suffix = path.suffix.lower()
    with path.open("rb") as handle:
        head = handle.read(_HEAD)
    if suffix == ".ply":
        counts = [int(n) for n in re.findall(rb"element \w+ (\d{1,18})", head)]
        _check_counts(path, sum(counts), size)
    elif suffix == ".off":
        found = re.match(rb"\s*[A-Z]*OFF\s+(?:#[^\n]*\s+)*(\d{1,18})\s+(\d{1,18})", head)
        if found is not None:
            _check_counts(path, int(found[1]) + int(found[2]), size)
    elif suffix in (".glb", ".gltf"):
        _check_gltf(path, size)


def _check_counts(path: Path, count: int, size: int) -> None:
    """Every vertex and every face takes a byte at least."""
    if count > size:
        raise FileError(
            f"{path}: its header promises {count} vertices and faces in {size} bytes. It is "
            "damaged or truncated: copy the file again"
        )


def _check_gltf(path: Path, size: int) -> None:
    document = _document(path)
    # Claimed sizes and counts, whatever stands in their place.
    buffers = sum(_whole(b.get("byteLength")) for b in _dicts(document.get("buffers")))
    accessors = [
        _whole(a.get("count")) * _COMPONENTS.get(str(a.get("type")), 16)
        for a in _dicts(document.get("accessors"))
    ]
    used = 0
    for mesh in _dicts(document.get("meshes")):
        for primitive in _dicts(mesh.get("primitives")):
            attributes = primitive.get("attributes")
            named = list(attributes.values()) if isinstance(attributes, dict) else []
            for index in (primitive.get("indices"), *named):
                if isinstance(index, int) and 0 <= index < len(accessors):
                    used += accessors[index]
    most = _REPEATS * max(2**20, buffers if buffers <= _MOST_BYTES else 0, size)
    if buffers > _MOST_BYTES or max(used, sum(accessors)) > most:
        raise FileError(
            f"{path}: its accessors name {max(used, sum(accessors))} numbers of {buffers} bytes, "
            "expected each once. It is damaged"
        )
    _check_nodes(path, document)


def _check_nodes(path: Path, document: dict[str, Any]) -> None:
    """Nodes are trees: each has one parent at most."""
    nodes = _dicts(document.get("nodes"))
    children = [c for node in nodes for c in _list(node.get("children"))]
    numbers = [c for c in children if isinstance(c, int)]
    if len(set(numbers)) < len(children) or len(nodes) > _MOST_NODES:
        raise FileError(
            f"{path}: {len(nodes)} nodes, some of them in several places; expected trees of at "
            f"most {_MOST_NODES}"
        )
    parent = {c: k for k, node in enumerate(nodes) for c in _list(node.get("children"))}
    free = set(range(len(nodes))) - set(parent)
    reached, todo = set(free), list(free)
    while todo:
        for child in _list(nodes[todo.pop()].get("children")):
            if child not in reached and 0 <= child < len(nodes):
                reached.add(child)
                todo.append(child)
    if len(reached) < len(nodes):
        raise FileError(f"{path}: nodes are in a ring, expected trees")


def _document(path: Path) -> dict[str, Any]:
    """The JSON of a glTF file, or of the first chunk of a GLB file."""
    with path.open("rb") as handle:
        content = handle.read(20)
        if content[:4] == b"glTF":
            length = struct.unpack("<I", content[12:16])[0] if len(content) == 20 else 0
            content = handle.read(min(length, _MOST_BYTES))
        else:
            content += handle.read()
    try:
        document = json.loads(content)
    except (ValueError, RecursionError, MemoryError) as error:
        reason = str(error)[:120]
        raise FileError(
            f"{path}: cannot be read as a {path.suffix[1:]} mesh: its JSON: {reason}"
        ) from None
    if not isinstance(document, dict):
        raise FileError(
            f"{path}: cannot be read as a {path.suffix[1:]} mesh: its JSON is no object"
        )
    return document


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _dicts(value: Any) -> list[dict[str, Any]]:
    return [item if isinstance(item, dict) else {} for item in _list(value)]


def _whole(value: Any) -> int:
    return value if isinstance(value, int) and value >= 0 else 0

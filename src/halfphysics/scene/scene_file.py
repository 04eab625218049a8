"""Reads scene files, YAML or JSON, strictly. docs/scene-files.md describes the format."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base.document_entries import (
    Read,
    choice,
    flag,
    guarded,
    items,
    mapping,
    named_entries,
    number,
    sequence,
    text,
    vector,
)
from halfphysics.base.document_tree import Entry, plain_tree, read_tree
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import file_path
from halfphysics.errors import FileError, HalfPhysicsError, HalfPhysicsWarning
from halfphysics.geometry.shapes import (
    Box,
    Capsule,
    Cylinder,
    Mesh,
    Plane,
    Shape,
    Sphere,
)
from halfphysics.scene.scene import Scene
from halfphysics.scene.soft import Soft

if TYPE_CHECKING:
    pass

logger = logging.getLogger(__name__)

#: Version written into files; files of another version are refused.
VERSION = 1

SUFFIXES = (".yaml", ".yml", ".json")

#: Shape by its name in files, and the keys that its constructor takes.
SHAPES: dict[str, tuple[type[Shape], tuple[str, ...], tuple[str, ...]]] = {
    # name: class, required keys, optional keys
    "plane": (Plane, (), ("normal", "offset")),
    "box": (Box, ("size",), ()),
    "sphere": (Sphere, ("radius",), ()),
    "capsule": (Capsule, ("radius", "length"), ()),
    "cylinder": (Cylinder, ("radius", "length"), ()),
}
_MESH_KEYS = ("scale", "up", "sha256")
_PLACED_KEYS = ("position", "quaternion", "friction", "restitution")
_STATIC_KEYS = (*_PLACED_KEYS, "soft")
_OBJECT_KEYS = ("mass", "density", "com", *_STATIC_KEYS, "velocity", "angular_velocity", "start")
_MOVING_KEYS = ("positions", "quaternions", "fps", "loop", "friction", "restitution", "soft")
_ARTICULATED_KEYS = ("file", "xml", "sha256", *_PLACED_KEYS, "mass", "joints", "velocities")
_SCENE_KEYS = (
    "version",
    "gravity",
    "statics",
    "objects",
    "moving",
    "articulated",
    "friction",
    "ignore",
)
PIECE_KEYS = ("pieces", "threshold", "max_pieces")
_SOFT_TEXTS = ("material", "law")


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """The work behind `Scene.load`; see there."""
    clock = Stopwatch(logger)
    path = file_path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(
            f"{path}: found suffix {path.suffix!r}, expected a scene file {', '.join(SUFFIXES)}"
            "; add a single mesh with Scene().add_static(name, path)"
        )
    if not path.is_file():
        raise FileError(f"{path}: there is no such file, expected a scene ({', '.join(SUFFIXES)})")
    scene = _scene(read_tree(path, "statics, objects"), path.parent)
    clock.done("loaded %s: %d items", path, len(scene._items()))
    return scene


def scene_from_document(document: Mapping[str, Any], origin: Path) -> Scene:
    """The scene of plain data as `scene_document` gives it.

    Args:
        document: In the file's format; relative mesh paths are relative to `origin`'s folder.
        origin: The file of the document, for messages.

    Raises:
        FileError: As for a file.
    """
    return _scene(plain_tree(document, origin), origin.parent)


def _scene(tree: Entry, base: Path) -> Scene:
    root = mapping(tree, _SCENE_KEYS)
    if "version" in root:
        version = number(root["version"])
        if version != VERSION:
            raise root["version"].error(
                f"found version {version:g}, expected {VERSION}; a newer halfphysics may read it"
            )
    gravity = root.get("gravity")
    scene = guarded(gravity, Scene, _gravity(gravity)) if gravity else Scene()
    for name, entry in _named(root.get("statics")):
        _add(scene.add_static, name, entry, _STATIC_KEYS, base)
    for name, entry in _named(root.get("objects")):
        _add(scene.add_object, name, entry, _OBJECT_KEYS, base)
    for name, entry in _named(root.get("moving")):
        for key in ("positions", "fps"):
            if key not in named_entries(entry, "a kinematic object: shape or mesh, positions, fps"):
                raise entry.error(f"a kinematic object needs {key}")
        _add(scene.add_moving, name, entry, _MOVING_KEYS, base)
    for name, entry in _named(root.get("articulated")):
        _add_articulated(scene, name, entry, base)
    for entry in items(root.get("friction")):
        a, b, mu = sequence(entry, 3, "[name, name, coefficient]")
        guarded(entry, scene.friction, text(a), text(b), number(mu))
    for entry in items(root.get("ignore")):
        a, b = sequence(entry, 2, "[name, name]")
        guarded(entry, scene.ignore, text(a), text(b))
    return scene


def _add(
    add: Callable[..., Any], name: str, entry: Entry, keys: tuple[str, ...], base: Path
) -> None:
    given = named_entries(entry, "a thing of a scene: shape or mesh, and more")
    shape, mesh = given.get("shape"), given.get("mesh")
    if shape is None and mesh is None:
        sizes = [key for _, needed, optional in SHAPES.values() for key in (*needed, *optional)]
        mapping(entry, ("shape", "mesh", *dict.fromkeys(sizes), *_MESH_KEYS, *keys))
    if (shape is None) == (mesh is None):
        found = "neither" if shape is None else "both"
        raise entry.error(
            f"expected shape ({', '.join(SHAPES)}) or mesh (path of a file), found {found}"
        )
    if shape is not None:
        kind = choice(shape, tuple(SHAPES))
        cls, needed, optional = SHAPES[kind]
        mapping(entry, ("shape", *needed, *optional, *keys), f" for a {kind}")
        missing = [key for key in needed if key not in given]
        if missing:
            raise entry.error(f"a {kind} needs {' and '.join(missing)}")
        size = {key: _READ[key](given[key]) for key in (*needed, *optional) if key in given}
        options = {key: _READ[key](given[key]) for key in keys if key in given}
        guarded(entry, lambda: add(name, cls(**size), **options))
    elif mesh is not None:
        if "mass" in keys:  # of an object
            keys = (*keys, *PIECE_KEYS)
        mapping(entry, ("mesh", *_MESH_KEYS, *keys), " for a mesh")
        _add_mesh(add, name, entry, keys, base)


def _add_mesh(
    add: Callable[..., Any], name: str, entry: Entry, keys: tuple[str, ...], base: Path
) -> None:
    given: dict[str, Entry] = entry.value
    mesh = given["mesh"]
    options = {key: _READ[key](given[key]) for key in (*keys, "scale", "up") if key in given}
    source: Any = _written_out(mesh) if isinstance(mesh.value, dict) else base / text(mesh)
    try:
        added = add(name, source, **options)
    except HalfPhysicsError as error:
        # An error in a file is reported at the line of its path, other errors at that of the item.
        place = mesh if isinstance(error, FileError) else entry
        raise place.error(str(error)) from error
    if "sha256" in given and added.source is not None:
        noted = text(given["sha256"])
        if noted != added.source.sha256:
            warnings.warn(
                f"{mesh.file}, line {given['sha256'].line}, {given['sha256'].where}: "
                f"{source} has changed since this scene was written (its SHA-256 is "
                f"{added.source.sha256[:12]}..., noted is {noted[:12]}...)",
                HalfPhysicsWarning,
                stacklevel=6,
            )


def _add_articulated(scene: Scene, name: str, entry: Entry, base: Path) -> None:
    given = mapping(entry, _ARTICULATED_KEYS, " for an articulated object")
    if ("file" in given) == ("xml" in given):
        found = "both" if "file" in given else "neither"
        raise entry.error(f"expected file (path of MJCF or URDF) or xml (its text), found {found}")
    options = {key: _READ[key](given[key]) for key in (*_PLACED_KEYS, "mass") if key in given}
    for key in ("joints", "velocities"):
        if key in given:
            named = named_entries(given[key], "from joints to numbers")
            options[key] = {joint: _joint_value(value) for joint, value in named.items()}
    source = base / text(given["file"]) if "file" in given else text(given["xml"])
    added = guarded(entry, lambda: scene.add_articulated(name, source, **options))
    if "sha256" in given and added.source is not None:
        noted = text(given["sha256"])
        if noted != added.source.sha256:
            warnings.warn(
                f"{entry.file}: {source} has changed since this scene was written",
                HalfPhysicsWarning,
                stacklevel=5,
            )


def _joint_value(entry: Entry) -> Any:
    if isinstance(entry.value, list):
        return [number(child) for child in entry.value]
    return number(entry)


def _written_out(mesh: Entry) -> Mesh:
    arrays = mapping(mesh, ("vertices", "faces"))
    if len(arrays) != 2:
        raise mesh.error("a mesh written out needs vertices and faces")
    rows = (_rows(arrays["vertices"], float), _rows(arrays["faces"], int))
    return guarded(mesh, Mesh, *rows)


def _pieces(entry: Entry) -> str | list[Mesh]:
    if isinstance(entry.value, list):
        return [_written_out(piece) for piece in entry.value]
    return choice(entry, ("auto", "hull"))


def _soft(entry: Entry) -> str | dict[str, Any]:
    """A material's name, or the fields of a layer."""
    if not isinstance(entry.value, dict):
        return text(entry)
    given = mapping(entry, ("material", *(f.name for f in fields(Soft))), " for a soft layer")
    return {key: (text if key in _SOFT_TEXTS else number)(value) for key, value in given.items()}


def _named(entry: Entry | None) -> list[tuple[str, Entry]]:
    if entry is None or entry.value is None:
        return []
    return list(named_entries(entry, "from names to things").items())


def _gravity(entry: Entry) -> Any:
    return vector(3)(entry) if isinstance(entry.value, list) else number(entry)


def _rows(entry: Entry, kind: type) -> np.ndarray:
    rows = [vector(3)(row) for row in items(entry)]
    array = np.array(rows, dtype=np.float64).reshape(-1, 3)
    if kind is int:
        if (array != np.round(array)).any():
            raise entry.error("expected whole numbers (indices of vertices)")
        return array.astype(np.int64)
    return array


_READ: dict[str, Read] = {
    **dict.fromkeys(
        ("radius", "length", "offset", "mass", "density", "friction", "restitution", "scale"),
        number,
    ),
    **dict.fromkeys(
        ("size", "normal", "com", "position", "velocity", "angular_velocity"), vector(3)
    ),
    "quaternion": vector(4),
    "up": lambda entry: choice(entry, ("y", "z")),
    "start": lambda entry: choice(entry, ("awake", "asleep")),
    "fps": number,
    "loop": flag,
    "positions": lambda entry: np.array([vector(3)(row) for row in items(entry)]),
    "quaternions": lambda entry: np.array([vector(4)(row) for row in items(entry)]),
    "threshold": number,
    "max_pieces": number,
    "pieces": _pieces,
    "soft": _soft,
}

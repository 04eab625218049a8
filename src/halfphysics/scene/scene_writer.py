"""Writes scene files, YAML or JSON. docs/scene-files.md describes the format."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfphysics.base.atomic import atomic_write
from halfphysics.base.document_tree import check_readable, yaml_text
from halfphysics.base.validation import file_path
from halfphysics.errors import InputError
from halfphysics.geometry.convex_decomposition import USUAL
from halfphysics.geometry.shapes import Mesh, MeshSource
from halfphysics.scene.items import OBJECT_FRICTION, STATIC_FRICTION, Object, Static
from halfphysics.scene.scene_file import PIECE_KEYS, SHAPES, SUFFIXES, VERSION
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.scene.articulated import Articulated
    from halfphysics.scene.scene import Scene


def save_scene(scene: Scene, path: str | os.PathLike[str]) -> None:
    """The work behind `Scene.save`; see there."""
    path = file_path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: found suffix {path.suffix!r}, expected {', '.join(SUFFIXES)}")
    document = scene_document(scene, path.parent)
    written = _json_text(document) if path.suffix.lower() == ".json" else yaml_text(document)
    written = written.rstrip() + "\n"
    check_readable(path, written)
    with atomic_write(path) as handle:
        handle.write(written.encode())


def _json_text(document: dict[str, Any]) -> str:
    """JSON with a line for each item: numbers on lines of their own would be twice as long."""

    def group(value: Any) -> str:
        if not isinstance(value, dict):
            return json.dumps(value, ensure_ascii=False)
        lines = (f"  {json.dumps(k, ensure_ascii=False)}: {json.dumps(v, ensure_ascii=False)}"
                 for k, v in value.items())  # fmt: skip
        return "{\n" + ",\n".join(lines) + "\n }"

    return "{\n" + ",\n".join(f' "{k}": {group(v)}' for k, v in document.items()) + "\n}"


def scene_document(scene: Scene, base: Path | None = None) -> dict[str, Any]:
    """The scene as plain data in the file's format; mesh paths relative to `base` if given."""
    down = -scene.gravity[2]
    plain = down >= 0.0 and not scene.gravity[:2].any()
    document: dict[str, Any] = {
        "version": VERSION,
        "gravity": float(down) + 0.0 if plain else scene.gravity.tolist(),
        "statics": {name: _item(s, base) for name, s in scene.statics.items()},
        "objects": {
            name: _item(o, base) | _dynamics(o)
            for name, o in scene.objects.items()
            if not isinstance(o, KinematicObject)
        },
        "moving": {
            name: _item(o, base) | _trajectory(o)
            for name, o in scene.objects.items()
            if isinstance(o, KinematicObject)
        },
        "articulated": {n: _articulated(a, base) for n, a in scene.articulated.items()},
        "friction": [list(pair) for pair in scene.friction_pairs],
        "ignore": [list(pair) for pair in scene.ignored_pairs],
    }
    return {key: value for key, value in document.items() if value not in ({}, [])}


def _item(item: Static | Object, base: Path | None) -> dict[str, Any]:
    result: dict[str, Any] = {}
    shape = (item.visual if isinstance(item, Object) else None) or item.shape
    if isinstance(shape, Mesh):
        result |= _mesh(shape, item.source, base)
    else:
        kind = next(name for name, (cls, _, _) in SHAPES.items() if type(shape) is cls)
        _, needed, optional = SHAPES[kind]
        result["shape"] = kind
        for key in (*needed, *optional):
            value = getattr(shape, key)
            result[key] = list(value) if isinstance(value, tuple) else value
    pushed = isinstance(item, Object) and not isinstance(item, KinematicObject)
    default = OBJECT_FRICTION if pushed else STATIC_FRICTION
    if not isinstance(item, KinematicObject):
        result["position"] = item.position.tolist()
    if not isinstance(item, KinematicObject) and item.quaternion.tolist() != [1.0, 0.0, 0.0, 0.0]:
        result["quaternion"] = item.quaternion.tolist()
    if item.friction != default:
        result["friction"] = item.friction
    if item.restitution:
        result["restitution"] = item.restitution
    if item.soft is not None:
        result["soft"] = item.soft.document
    return result


def _trajectory(item: KinematicObject) -> dict[str, Any]:
    result: dict[str, Any] = {"fps": item.fps, "positions": item.positions.tolist()}
    if (item.quaternions != [1.0, 0.0, 0.0, 0.0]).any():
        result["quaternions"] = item.quaternions.tolist()
    if item.loop:
        result["loop"] = True
    return result


def _articulated(item: Articulated, base: Path | None) -> dict[str, Any]:
    result: dict[str, Any] = {}
    if item.source is not None:
        result["file"] = _relative(item.source.path, base)
        result["sha256"] = item.source.sha256
    else:
        result["xml"] = item.xml
    result["position"] = item.position.tolist()
    result["quaternion"] = item.quaternion.tolist()
    result |= {"friction": item.friction, "restitution": item.restitution}
    if item.given_mass is not None:
        result["mass"] = item.given_mass
    for key in ("joints", "velocities"):
        if getattr(item, key):
            result[key] = dict(getattr(item, key))
    return result


def _relative(path: str, base: Path | None) -> str:
    if base is not None:
        try:
            return Path(os.path.relpath(path, base.resolve())).as_posix()
        except ValueError:  # another drive: there is no relative path
            pass
    return Path(path).as_posix()


def _mesh(mesh: Mesh, source: MeshSource | None, base: Path | None) -> dict[str, Any]:
    if source is None:
        return {"mesh": {"vertices": mesh.vertices.tolist(), "faces": mesh.faces.tolist()}}
    return {
        "mesh": _relative(source.path, base),
        "scale": source.scale,
        "up": source.up,
        "sha256": source.sha256,
    }


def _dynamics(item: Object) -> dict[str, Any]:
    result: dict[str, Any] = {"mass": item.mass}
    if item.com.tolist() != item.filling.centre.tolist():
        result["com"] = item.com.tolist()
    cut = item.cut
    if item.decomposition is not None and cut.pieces == "given":
        pieces = item.decomposition.pieces
        result["pieces"] = [
            {"vertices": p.vertices.tolist(), "faces": p.faces.tolist()} for p in pieces
        ]
    elif item.visual is not None:
        for key in PIECE_KEYS:
            if getattr(cut, key) != getattr(USUAL, key):
                result[key] = getattr(cut, key)
    for key in ("velocity", "angular_velocity"):
        value = getattr(item, key).tolist()
        if any(value):
            result[key] = value
    if item.start != "awake":
        result["start"] = item.start
    return result

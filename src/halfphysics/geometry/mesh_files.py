"""Triangle meshes from files: whatever trimesh reads (OBJ, GLB, glTF, PLY, STL, OFF, ...)."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import progress as bars
from halfphysics.base.digests import sha256_of
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import file_path
from halfphysics.errors import FileError, InputError, MissingDependencyError
from halfphysics.geometry.mesh import Mesh, MeshSource
from halfphysics.geometry.mesh_file_checks import FolderResolver, check_mesh_file

logger = logging.getLogger(__name__)

#: Suffixes of the formats that are read, and those that name materials and textures.
FORMATS = ("obj", "glb", "gltf", "ply", "stl", "off")
_WITH_MATERIALS = ("obj", "glb", "gltf", "ply")
#: Triangles of one mesh: a scanned room has a few million.
MOST_TRIANGLES = 10_000_000

#: Suffixes of formats whose standard defines the up axis (y).
Y_UP_SUFFIXES = (".glb", ".gltf")

#: z-up from y-up: a quarter turn about x.
_Z_FROM_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def turned(mesh: Mesh, *, scale: float, up: str) -> Mesh:
    """The mesh in metres and z-up: vertices scaled, then turned if `up` is "y"."""
    if scale == 1.0 and up == "z":
        return mesh
    vertices = scale * mesh.vertices
    return Mesh(vertices @ _Z_FROM_Y.T if up == "y" else vertices, mesh.faces)


def load_mesh(
    path: str | os.PathLike[str], *, scale: float = 1.0, up: str | None = None
) -> tuple[Mesh, MeshSource]:
    """All triangles of a file as one mesh, scaled and turned to z-up, and where it came from.

    Files with several geometries are flattened with their transforms. `up` None: "y" for
    glTF (its standard says so), else "z".

    Raises:
        FileError: missing, unreadable or unknown file, no triangles, NaN vertices.
    """
    path = file_path(path)
    if not path.is_file():
        kind = "it is a folder" if path.is_dir() else "there is no such file"
        raise FileError(f"{path}: {kind}, expected a mesh{_similar(path)}")
    clock = Stopwatch(logger)
    trimesh = _trimesh()
    suffix = path.suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise FileError(
            f"{path}: unknown kind of mesh {path.suffix or '(no suffix)'!r}, expected one of "
            f"{', '.join(FORMATS)}. Convert it, for example to .glb"
        )
    if up is None:
        up = "y" if path.suffix.lower() in Y_UP_SUFFIXES else "z"
    try:
        check_mesh_file(path)
        digest = sha256_of(path)
        with path.open("rb") as stream, bars.bar(1, f"loading {path.name}", "file"):
            scene = trimesh.load(
                stream,
                file_type=suffix,
                resolver=FolderResolver(path),
                force="scene",
                process=False,
                # Looks are no part of a shape, and their files are more that may be wrong.
                **({"skip_materials": True} if suffix in _WITH_MATERIALS else {}),
            )
    except FileError:
        raise
    except Exception as error:  # readers of many formats, each with errors of its own
        reason = str(error).strip() or type(error).__name__
        raise FileError(f"{path}: cannot be read as a {suffix} mesh: {reason}") from error
    vertices, faces = flatten(scene, path)
    if not len(faces):
        raise FileError(
            f"{path}: found no triangles ({len(scene.geometry)} geometries), expected a "
            "triangle mesh; point clouds and curves have no surface to touch"
        )
    try:
        mesh = turned(Mesh(vertices, faces), scale=scale, up=up)
    except InputError as error:
        raise FileError(f"{path}: {error}") from None
    source = MeshSource(path=str(path.resolve()), sha256=digest, scale=scale, up=up)
    clock.done("loaded %s: %d triangles", path, len(mesh.faces))
    return mesh, source


def flatten(scene: Any, path: Path | None = None) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices (V, 3) and faces (F, 3) of all meshes of a `trimesh.Scene`, placed in it.

    Raises:
        FileError: The scene of the file at `path` names its meshes so often that they are more
            than `MOST_TRIANGLES`.
    """
    vertices, faces, count = [np.zeros((0, 3))], [np.zeros((0, 3), np.int32)], 0
    nodes = sorted(scene.graph.nodes_geometry)
    sizes = {name: len(getattr(g, "faces", ())) for name, g in scene.geometry.items()}
    total = sum(sizes[scene.graph[node][1]] for node in nodes)
    if path is not None and total > MOST_TRIANGLES:
        raise FileError(
            f"{path}: {total} triangles, expected at most {MOST_TRIANGLES}. Simplify it"
        )
    for node in nodes:
        transform, name = scene.graph[node]
        geometry = scene.geometry[name]
        own = getattr(geometry, "faces", None)
        if own is None or not len(own):
            continue
        placed = np.asarray(geometry.vertices) @ transform[:3, :3].T + transform[:3, 3]
        own = np.asarray(own, dtype=np.int32)
        if np.linalg.det(transform[:3, :3]) < 0.0:  # a mirror turns faces inside out
            own = own[:, ::-1]
        vertices.append(placed)
        faces.append(own + count)
        count += len(placed)
    return np.concatenate(vertices), np.concatenate(faces)


def _similar(path: Path) -> str:
    if not path.parent.is_dir():
        return f"; the folder {path.parent} does not exist"
    if not os.access(path.parent, os.R_OK):
        return ""
    names = [entry.name for entry in path.parent.iterdir() if entry.is_file()]
    return did_you_mean(path.name, names, form=lambda name: str(path.parent / name))


def _trimesh() -> Any:
    try:
        import trimesh
    except ImportError as error:
        raise MissingDependencyError(
            "reading mesh files needs trimesh: pip install trimesh pillow"
        ) from error
    return trimesh

"""Files that a URDF names as ROS does, `package://NAME/meshes/arm.stl`, found on the disk."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from halfphysics.errors import FileError, InputError

#: Beginnings of such names: of ROS, and of Gazebo.
SCHEMES = ("package", "model", "file")


def package_files(what: str, root: Any, folder: Path | None) -> Mapping[str, str]:
    """Name -> path of the meshes that a URDF names by package, as far as they are there.

    A package is a folder of its name above or beside the file; where there is none of the name, the
    file's own folder or the one that this is in (`robot/urdf/robot.urdf`: `robot`). Names are taken
    as written, else as a URI (`a%20b.stl`: `a b.stl`).

    Args:
        what: Name for messages.
        root: The root element.
        folder: The file's folder; None: it is text, without one.

    Raises:
        InputError: Text names a mesh by package.
        FileError: A mesh for contact is not there, or is outside its package. (Those for looks
            alone are not used.)
    """
    found: dict[str, str] = {}
    if any(e.get("strippath") == "true" for e in root.iter("compiler")):
        return found  # MuJoCo looks for the last part of the name, in the file's `meshdir`
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if folder is not None and _is_uri(name):
            path = next((p for p in _places(name, folder) if os.path.exists(p)), None)
            if path is not None:
                found[name] = str(path)
    for mesh in root.iterfind("link/collision/geometry/mesh"):
        name = mesh.get("filename", "")
        if not _is_uri(name) or name in found:
            continue
        if folder is None:
            raise InputError(
                f"{what}: found the mesh {name!r} in text that has no folder; give the path of a "
                "file instead"
            )
        raise FileError(f"{what}: the mesh {name!r} {_not_found(name, folder)}")
    return found


def _is_uri(name: str) -> bool:
    return name.partition("://")[0] in SCHEMES and "://" in name


def _parts(name: str) -> tuple[str, str]:
    """The package, and the path within it.

    No URL: `#`, `?` and `[` have no meaning in names of packages and files.
    """
    package, _, rest = name.partition("://")[2].partition("/")
    return package, rest.lstrip("/")


def _places(name: str, folder: Path) -> Iterator[Path]:
    """Where a file may be, the likeliest place first."""
    for spelling in dict.fromkeys((name, unquote(name))):
        package, rest = _parts(spelling)
        if name.startswith("file://"):
            yield Path("/", rest)
        elif not _leaves(package, rest):
            for above in (folder, *folder.parents):
                if above.name == package:
                    yield above / rest
                yield above / package / rest
            yield from (folder / rest, folder.parent / rest)


def _leaves(package: str, rest: str) -> bool:
    """Whether a path within a package ends outside it."""
    inside = os.path.normpath(rest)
    up = package == ".." or Path(inside).parts[:1] == ("..",)
    return up or bool(Path(inside).anchor)  # an anchor: of a drive


def _not_found(name: str, folder: Path) -> str:
    """The end of the message for a mesh that is at none of its places."""
    package, rest = _parts(unquote(name))
    if name.startswith("file://"):
        return (
            f"is not there; expected a file at {Path('/', rest)}. Put it there, or name it by its "
            "path from the URDF file"
        )
    if _leaves(package, rest):
        return (
            f"is outside its package {package!r}; expected a path without '..' that leaves it. "
            "Name it by the package that it is in"
        )
    return (
        f"is not there; expected the folder {package!r} with {rest!r} above or beside {folder}, or "
        f"{rest!r} in it or in the folder that it is in. Put it there, or name it by its path from "
        "the URDF file"
    )

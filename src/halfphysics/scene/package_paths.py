"""Files that a URDF names as ROS does, `package://NAME/meshes/arm.stl`, found on the disk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from halfphysics.errors import FileError, InputError

#: Beginnings of such names: of ROS, and of Gazebo.
SCHEMES = ("package", "model", "file")


def package_files(what: str, root: Any, folder: Path | None) -> Mapping[str, str]:
    """Name -> path of the meshes that a URDF names by package, as far as they are there.

    A package is a folder of its name above or beside the file; where there is none of the name, the
    file's own folder or the one that this is in (`robot/urdf/robot.urdf`: `robot`).

    Args:
        what: Name for messages.
        root: The root element.
        folder: The file's folder; None: it is text, without one.

    Raises:
        InputError: Text names a mesh by package. FileError: A mesh for contact is not there. (Those
            for looks alone are not used.)
    """
    found: dict[str, str] = {}
    if any(e.get("strippath") == "true" for e in root.iter("compiler")):
        return found  # MuJoCo looks for the last part of the name, in the file's `meshdir`
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if folder is not None and _is_uri(name):
            path = next((p for p in _places(name, folder) if p.exists()), None)
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
        package, rest = _parts(name)
        raise FileError(
            f"{what}: the mesh {name!r} is not there; expected the folder {package!r} with "
            f"{rest!r} above or beside {folder}, or {rest!r} in it or in the folder that it is in. "
            "Put it there, or name it by its path from the URDF file"
        )
    return found


def _is_uri(name: str) -> bool:
    return name.partition("://")[0] in SCHEMES and "://" in name


def _parts(name: str) -> tuple[str, str]:
    """The package, and the path within it."""
    given = urlsplit(name)
    return given.netloc, unquote(given.path).lstrip("/")


def _places(name: str, folder: Path) -> Iterator[Path]:
    """Where a file may be, the likeliest place first."""
    if name.startswith("file://"):
        yield Path(unquote(urlsplit(name).path))
        return
    package, rest = _parts(name)
    for above in (folder, *folder.parents):
        if above.name == package:
            yield above / rest
        yield above / package / rest
    yield from (folder / rest, folder.parent / rest)

"""Text of MJCF and URDF, checked before MuJoCo reads it, and the files that it names."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from halfphysics.base.validation import file_bytes
from halfphysics.errors import FileError, InputError
from halfphysics.geometry.mesh_queries import components

#: What an articulated object is made from, for messages.
SOURCES = "the path of a .xml or .urdf file, MJCF or URDF text, or a mujoco.MjSpec"
#: Links of one object, of which the largest humanoids have a hundred, and files that one includes.
_MOST_LINKS, _MOST_INCLUDES = 500, 100
#: Attributes that name files, and the folders in which they are.
_FILE_KEYS = (
    "file", "filename", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback",
)  # fmt: skip
_DIRS = ("meshdir", "texturedir", "assetdir")


def checked_xml(what: str, text: str, path: Path | None) -> Any:
    """The root element of a text, of the file `path` if it is one; `what`: name for messages.

    Raises:
        InputError: No MJCF or URDF, entities, macros, too many links, an include that leaves the
            file's folder, a file that is a pipe, or in URDF a link that moves without a mass.
        FileError: An included file is not there, or cannot be read.
    """
    where = f"{what}: {path}" if path is not None else what
    root = _plain(where, text)
    if root.tag not in ("mujoco", "robot"):
        raise InputError(f"{where}: found <{root.tag}>, expected <mujoco> (MJCF) or <robot> (URDF)")
    base = None if path is None else path.resolve().parent
    _check_size(where, root)
    check_files(where, named_files(root, base))
    _check_includes(what, where, root, base, [])
    if root.tag == "robot":
        _check_expanded(where, root)
        _check_masses(what, root)
    return root


def _plain(where: str, text: str) -> Any:
    """The root element of XML without entities."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(f"{where}: found XML entities, expected plain MJCF or URDF; remove them")
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InputError(f"{where}: not XML ({error}), expected {SOURCES}") from None


def _check_size(where: str, root: Any) -> None:
    links = sum(1 for element in root.iter() if element.tag in ("body", "link"))
    if links > _MOST_LINKS:
        raise InputError(
            f"{where}: found {links} links, expected at most {_MOST_LINKS}. Split it into several "
            "objects"
        )


def check_files(where: str, paths: Iterable[Path]) -> None:
    """Meshes and textures that it names are files: reading a pipe or a device never ends."""
    for path in paths:
        if _is_no_file(path):
            raise InputError(
                f"{where}: {path.name!r} is a pipe, a device or a folder, expected a file"
            )


def named_files(root: Any, base: Path | None) -> list[Path]:
    """Where the meshes and textures that a model names may be."""
    if base is None:
        return []
    folders = [
        base,
        *(base / e.get(key) for e in root.iter("compiler") for key in _DIRS if key in e.attrib),
    ]
    names = files_of(root)
    return [folder / name for folder in folders for n in names for name in (n, Path(n).name)]


def files_of(root: Any) -> list[str]:
    """The files that a model names, as it names them."""
    return [e.get(key) for e in root.iter() for key in _FILE_KEYS if e.get(key)]


def lost_files(xml: str) -> list[str]:
    """Meshes and textures that MJCF text names and that are nowhere; none of what is no MJCF.

    Of URDF not all that is named is read: what is for looks and for plugins may be missing.
    """
    try:
        root = checked_xml("model", xml, None)
    except InputError:
        return []
    if root.tag != "mujoco":
        return []
    found = {path.name for path in named_files(root, Path()) if _is_file(path)}
    names = {name for assets in root.iter("asset") for name in files_of(assets)}
    return sorted(name for name in names if Path(name).name not in found)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that no file has
        return False


def asset_bytes(paths: Iterable[Path]) -> int:
    """Size of the meshes and textures that a model names [bytes]."""
    total = 0
    for path in set(paths):
        with contextlib.suppress(OSError, ValueError):
            total += path.stat().st_size
    return total


def _is_no_file(path: Path) -> bool:
    try:
        return path.exists() and not path.is_file()
    except (OSError, ValueError):
        return True


def _check_includes(what: str, where: str, root: Any, base: Path | None, seen: list[Path]) -> None:
    for element in root.iter("include"):
        name = element.get("file", "")
        if base is None:
            raise InputError(
                f"{where}: found an include of {name!r} in text that has no folder; give the path "
                "of a file instead"
            )
        target = (base / name).resolve()
        if not target.is_relative_to(base):
            raise InputError(
                f"{where}: the include {name!r} leaves the folder {base}; expected files within "
                "it. Copy it there"
            )
        if not target.is_file():
            raise FileError(f"{where}: the included file {target} is not there; put it back")
        if target in seen or len(seen) > _MOST_INCLUDES:
            continue
        seen.append(target)
        inner = file_bytes(target).decode("utf-8", errors="replace")
        child = _plain(f"{where}: the included file {target}", inner)
        _check_includes(what, where, child, base, seen)


def _check_expanded(where: str, root: Any) -> None:
    """Macros of ROS are not URDF: what they say would be missing."""
    macro = next((e for e in root.iter() if "xacro}" in str(e.tag)), None)
    if macro is not None:
        raise InputError(
            f"{where}: found <xacro:{macro.tag.partition('}')[2]}>, expected URDF without macros; "
            "expand it first: xacro robot.urdf.xacro > robot.urdf"
        )


def _check_masses(what: str, root: Any) -> None:
    """What moves in a URDF says its mass: masses are never inferred from volumes.

    Links that are joined rigidly are one: one of them has to say it.
    """
    # Those of the robot itself: plugins of simulators have elements of the same names.
    links = root.findall("link")
    names = {name: k for k, name in enumerate(dict.fromkeys(str(e.get("name")) for e in links))}
    weighed = {str(e.get("name")) for e in links if e.find("inertial") is not None}
    rigid, moved = [], []
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None:
            continue
        ends = str(parent.get("link")), str(child.get("link"))
        if joint.get("type") != "fixed":
            moved.append(ends[1])
        elif ends[0] in names and ends[1] in names:
            rigid.append((names[ends[0]], names[ends[1]]))
    group = components(len(names), np.array(rigid, dtype=np.int64).reshape(-1, 2))
    heavy = {int(group[names[name]]) for name in weighed if name in names}
    for link in moved:
        if link in names and int(group[names[link]]) not in heavy:
            raise InputError(
                f"{what}: link {link!r} moves and has no <inertial>, expected its mass and "
                'inertia: <inertial><mass value="..."/><inertia ixx="..." .../></inertial>'
            )

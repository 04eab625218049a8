"""Files of animated scenes: the body with its skin, the objects, the room.

A new format is one file here with a function ``write(take, path)`` and one line below.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from halfphysics.base.validation import body as checked_body
from halfphysics.base.validation import file_path
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.writers.take import Exportable

__all__ = ["KINDS", "export", "is_kind"]

#: Suffix -> module of this package that writes such files.
KINDS: Mapping[str, str] = MappingProxyType(
    {
        ".glb": "gltf",
        ".gltf": "gltf",
        ".usd": "usd",
        ".usda": "usd",
        ".usdc": "usd",
        ".usdz": "usd",
        ".xml": "mjcf",
    }
)


def is_kind(path: Path) -> bool:
    """Whether `export` writes files of this suffix."""
    return path.suffix.lower() in KINDS


def export(
    what: Exportable,
    path: str | os.PathLike[str],
    *,
    body: Body | None = None,
    fps: float | None = None,
    colliders: bool = False,
) -> None:
    """Write an animated scene for other programs; the suffix selects the format.

    Args:
        what: A `Result` (simulated), a `Sequence` or a `Motion` (reference).
        path: The file; it appears whole or not at all.
        body: The body, if `what` has none; None: the default body.
        fps: Frame rate to write; None: that of the motion.
        colliders: Write bodies for physics engines, too (USD only): the convex hulls of people's
            parts as kinematic bodies that follow the animation, and the room and the objects.

    Raises:
        FileError: The folder does not exist or cannot be written.
        InputError: Another suffix, or `colliders` in a format that has none.
        MissingDependencyError: A package that the format needs is not installed (USD: usd-core).
    """
    from halfphysics.writers.take import take_of

    path = file_path(path)
    if not is_kind(path):
        raise InputError(
            f"{path}: found suffix {path.suffix!r}, expected one of {', '.join(KINDS)}. Motions "
            "alone are written by Motion.save"
        )
    if body is not None:
        checked_body(body, "joint_frames")
    kind = KINDS[path.suffix.lower()]
    if colliders and kind != "usd":
        raise InputError(
            f"{path}: colliders are written to USD only, found {path.suffix}. Leave out colliders, "
            "or write .usd"
        )
    module = importlib.import_module(f"{__name__}.{kind}")
    more = {"colliders": True} if colliders else {}
    module.write(take_of(what, body, fps=fps), path, **more)

"""Which format a motion is written in, and what of it a file of that format cannot hold."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from collections.abc import Sequence as Listing
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.base.axes import axes_of
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import body as checked_body
from halfphysics.base.validation import file_path
from halfphysics.errors import InputError
from halfphysics.formats import plain
from halfphysics.formats.amass import smpl as amass_smpl
from halfphysics.formats.amass import smplh as amass_smplh
from halfphysics.formats.amass import smplx as amass_smplx
from halfphysics.formats.format import Format
from halfphysics.formats.registry import FORMATS
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

logger = logging.getLogger(__name__)

__all__ = ["files_of", "losses", "save_motion", "save_people", "writer_of"]

#: Model -> format in which a motion without a file is written.
_BY_MODEL = {
    "smplx": amass_smplx.FORMAT.name,
    "smplh": amass_smplh.FORMAT.name,
    "smpl": amass_smpl.FORMAT.name,
}


def save_motion(
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    body: Body | None = None,
) -> None:
    """Implements `Motion.save`; see there."""
    clock = Stopwatch(logger)
    path = file_path(path)
    writer = writer_of(motion, path, format)
    _saving(writer)(_placed(motion, writer, body), path, body)
    clock.done("saved %s, %d frames", path, len(motion))


def save_people(
    motions: Listing[Motion],
    path: str | os.PathLike[str],
    bodies: Listing[Body | None],
    *,
    format: str | None = None,
) -> list[Path]:
    """Write people into one file where the format holds several, else each into one of their own.

    Args:
        motions: Of one or more people who were read from one file.
        path: Of files of their own each gets a number: `walk_1.npz`, `walk_2.npz`.
        bodies: Of each.
        format: None: as in `Motion.save`, by the first.

    Returns:
        The files written, one, or one a person.

    Raises:
        HalfPhysicsError: As `Motion.save`.
    """
    path = file_path(path)
    writer = writer_of(motions[0], path, format)
    if writer.save_people is not None:
        placed = [_placed(m, writer, b) for m, b in zip(motions, bodies, strict=True)]
        writer.save_people(placed, path, bodies)
        return [path]
    paths = files_of(motions, path, format)
    for motion, own, body in zip(motions, paths, bodies, strict=True):
        save_motion(motion, own, format=writer.name, body=body)
    return paths


def files_of(motions: Listing[Motion], path: Path, format: str | None) -> list[Path]:
    """The files that `save_people` writes."""
    if len(motions) == 1 or writer_of(motions[0], path, format).save_people is not None:
        return [path]
    return [path.with_name(f"{path.stem}_{k + 1}{path.suffix}") for k in range(len(motions))]


def losses(
    motion: Motion,
    path: str | os.PathLike[str],
    format: str | None = None,
    body: Body | None = None,
) -> list[str]:
    """The parts of a motion, and of its body, that the file of `save_motion` cannot hold, one line
    each."""
    writer = writer_of(motion, file_path(path), format)
    lost = list(writer.loses(motion))
    if body is not None and body.given_bones is not None and not writer.tells_bones:
        lost.append(
            f"the person's own bones (stature {body.stature:.2f} m): on another body feet are "
            "higher or lower (a result file keeps the body)"
        )
    metadata = motion.origin
    template = None if metadata is None else metadata.fields.get("template")
    if motion.holds:
        lost.append("what the hands hold, and the motion as recorded (a result file keeps both)")
    if template is not None and metadata is not None and metadata.format != writer.name:
        lost.append(f"the subject's own shape: keep the template {template} beside it")
    return lost


def writer_of(motion: Motion, path: Path, format: str | None) -> Format:
    """The format that `save_motion` writes.

    Raises:
        InputError: The format is unknown or read-only.
    """
    if format is not None and (not isinstance(format, str) or format not in FORMATS):
        raise InputError(f"format: found {format!r}, expected one of {_writable()}")
    writer = _by_suffix(motion, path) if format is None else FORMATS[format]
    _saving(writer)  # raises InputError for a read-only format
    return writer


def _saving(writer: Format) -> Callable[[Motion, Path, Body | None], None]:
    """The function that writes files of a format; raises InputError if it is read-only."""
    if writer.save is None:
        raise InputError(f"format: '{writer.name}' can only be read, expected one of {_writable()}")
    return writer.save


def _writable() -> str:
    return ", ".join(name for name, known in FORMATS.items() if known.save)


def _by_suffix(motion: Motion, path: Path) -> Format:
    """The format of the motion's file where it is written, else that of its model, of plain
    parameters, or the first one with this suffix."""
    from halfphysics.writers import KINDS

    own = FORMATS.get(motion.origin.format) if motion.origin is not None else None
    if own is not None and own.instead:
        own = FORMATS[own.instead]
    suffix = path.suffix.lower()
    usual = FORMATS[_BY_MODEL[motion.model]]
    if own is not None and own.save and (suffix in own.suffixes or not suffix):
        return own
    if not suffix:
        return usual
    for known in (usual, plain.FORMAT, *FORMATS.values()):
        if known.save and suffix in known.suffixes:
            return known
    written = sorted({s for known in FORMATS.values() if known.save for s in known.suffixes})
    raise InputError(
        f"{path}: found suffix {path.suffix!r}, expected one of {', '.join(written)} (animated "
        f"scenes, by halfphysics.export: {', '.join(KINDS)}), or name the format with format="
    )


def _placed(motion: Motion, writer: Format, body: Body | None) -> Motion:
    """The motion with `translation` as the files of a format define it."""
    if body is not None:
        checked_body(body, "joint_frames")
    own = motion.origin is not None and motion.origin.format == writer.name
    if own or writer.up is None or (motion.axes == axes_of(writer.up)).all():
        return motion
    if body is None:
        raise InputError(
            f"format: '{writer.name}' has {writer.up} up and the motion came from a file with "
            "another axis up: what its translation is there depends on the pelvis of the body at "
            "rest. Say whose motion it is with body="
        )
    return motion.rebased(body, writer.up)

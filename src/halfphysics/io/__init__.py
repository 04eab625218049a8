"""Files: the registry of motion formats. A new format is one file here and one line below."""

from __future__ import annotations

import os
from pathlib import Path

from halfphysics.errors import FileError, InputError
from halfphysics.io import amass_smpl, amass_smplh, amass_smplx
from halfphysics.io.formats import Format, Options, Source
from halfphysics.motion import GENDERS, MODELS, Motion
from halfphysics.validation import file_path, frame_rate, shown

__all__ = ["FORMATS", "Format", "Options", "Source", "load_motion", "save_motion"]

#: Every motion format, tried in this order.
FORMATS: dict[str, Format] = {
    format.name: format
    for format in (
        amass_smplx.FORMAT,
        amass_smplh.FORMAT,
        amass_smpl.FORMAT,
    )
}

#: What a motion that came from no file is written as.
_BY_MODEL = {
    "smplx": amass_smplx.FORMAT.name,
    "smplh": amass_smplh.FORMAT.name,
    "smpl": amass_smpl.FORMAT.name,
}


def load_motion(
    path: str | os.PathLike[str],
    *,
    fps: float | None = None,
    up: str | None = None,
    hands: str | None = None,
    model: str | os.PathLike[str] | None = None,
    gender: str | None = None,
    frames: tuple[int | None, int | None] | None = None,
) -> Motion:
    """The work behind `Motion.load`; see there."""
    if up not in (None, "z", "y"):
        raise InputError(f"up: found {up!r}, expected 'z' or 'y'")
    if hands not in (None, "flat", "mean"):
        raise InputError(f"hands: found {hands!r}, expected 'flat' or 'mean'")
    if fps is not None:
        fps = frame_rate(fps)
    if model is not None and str(model) not in MODELS and not Path(model).exists():
        raise InputError(
            f"model: found '{model}', expected one of {', '.join(MODELS)} or the path of a "
            "body-model file that exists"
        )
    if gender is not None and gender not in GENDERS:
        raise InputError(f"gender: found {gender!r}, expected one of {', '.join(GENDERS)}")
    pair = isinstance(frames, list | tuple) and len(frames) == 2
    if frames is not None and not (pair and all(isinstance(i, int | None) for i in frames)):
        raise InputError(
            f"frames: found {shown(frames)}, expected (start, stop), whole numbers or None"
        )
    source = Source(path)
    options = Options(
        fps=fps,
        up=up,
        hands=hands,
        model=model,
        gender=gender,
        frames=slice(*frames) if frames else slice(None),
    )
    for format in FORMATS.values():
        if format.sniff(source):
            return format.load(source, options)
    if source.npz is not None and {"v_template", "J_regressor"} & set(source.npz):
        raise FileError(
            f"{source.path}: this is a body model, expected a motion. Load it with Body.load"
        )
    found = (
        "a file that is not an .npz archive"
        if source.npz is None
        else f"an .npz with {source.npz.describe() or 'no arrays'}"
    )
    known = "; ".join(f"{format.name}: {format.expects}" for format in FORMATS.values())
    raise FileError(
        f"{source.path}: no known motion format. Found {found}. Expected one of: {known}"
    )


def save_motion(motion: Motion, path: str | os.PathLike[str], *, format: str | None = None) -> None:
    """The work behind `Motion.save`; see there."""
    if format is None:
        own = FORMATS.get(motion.origin.format) if motion.origin is not None else None
        writer = own if own is not None and own.save else FORMATS[_BY_MODEL[motion.model]]
    elif format in FORMATS:
        writer = FORMATS[format]
    else:
        raise InputError(f"format: found {format!r}, expected one of {', '.join(FORMATS)}")
    if writer.save is None:
        writable = ", ".join(name for name, known in FORMATS.items() if known.save)
        raise InputError(f"format: '{writer.name}' can only be read, expected one of {writable}")
    writer.save(motion, file_path(path))

"""The body of a recorded subject: the user's own SMPL-X model with the subject's own template."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.body.model_paths import gender_of
from halfphysics.errors import FileError
from halfphysics.formats.datasets.assets import find
from halfphysics.formats.format import Options, Source
from halfphysics.motion.motion import MODELS


def model_names(gender: str) -> tuple[str, ...]:
    """Possible paths of an SMPL-X file below a folder of models."""
    files = [f"SMPLX_{gender.upper()}{suffix}" for suffix in (".npz", ".pkl")]
    return tuple(f"{base}{file}" for base in ("", "smplx/", "models/smplx/") for file in files)


def named_model(options: Options) -> Path | None:
    """The file or folder that the caller named with `model=`."""
    if options.model is None or str(options.model) in MODELS:
        return None
    return Path(os.fspath(options.model))


def subject_body(
    source: Source, options: Options, *, gender: str, template: Iterable[str]
) -> Body | None:
    """The body, or None with a warning that names the missing file and the folders searched.

    Args:
        source, options: Source and options of the clip.
        gender: Gender of the subject, which the model must have.
        template: Names of the template (.ply or .obj) below the folders of assets.

    Raises:
        FileError, InputError: The model or the template cannot be used.
    """
    try:
        mesh = find(source, options, template, "the subject's own template for its body")
        named = named_model(options)
        if named is None:
            what = "the SMPL-X model of the subject's gender for its body"
            named = find(source, options, model_names(gender), what)
    except FileError as error:
        warn(f"{error}. Without it Sequence.body is None")
        return None
    said = gender_of(named) if named.is_file() else None
    if said is not None and said != gender:
        warn(
            f"{source.path}: model: found {named}, which is {said} by its name, expected the "
            f"{gender} one: the subject's template is made for it. Sequence.body is None"
        )
        return None
    return Body.load(named, gender=gender, model="smplx", v_template=mesh)

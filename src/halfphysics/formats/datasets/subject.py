"""The body of a recorded subject whose data set brings a template of its own."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.body.model_paths import gender_of
from halfphysics.errors import FileError, InputError
from halfphysics.formats.datasets.assets import find
from halfphysics.formats.datasets.size_from_motion import body_by_motion
from halfphysics.formats.datasets.template_body import template_body
from halfphysics.formats.format import Options, Source
from halfphysics.motion.motion import MODELS, Motion

if TYPE_CHECKING:
    from halfphysics.results.result import ObjectTrack


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
    source: Source,
    options: Options,
    *,
    motion: Motion,
    tracks: Mapping[str, ObjectTrack],
    template: Iterable[str],
) -> Body | None:
    """The subject's body.

    With the template and the user's SMPL-X model it is that model with the template; with the
    template alone the free body with its size (`template_body`); without a template the free body
    with the size that the motion tells (`size_from_motion`).

    Args:
        source, options: Source and options of the clip.
        motion: The subject's motion; the model must have its gender.
        tracks: Recorded poses of the objects.
        template: Names of the template (.ply or .obj) below the folders of assets.

    Returns:
        The body; None, with a warning: the size is not known.

    Raises:
        FileError, InputError: The model or the template cannot be used.
    """
    gender, named = motion.gender, named_model(options)
    try:
        mesh = find(source, options, template, "the subject's own template for its body")
    except FileError as error:
        return body_by_motion(str(error), motion, tracks)
    if named is None:
        try:
            what = "the SMPL-X model of the subject's gender for its body"
            named = find(source, options, model_names(gender), what)
        except FileError as error:
            return _sized(mesh, str(error))
    said = gender_of(named) if named.is_file() else None
    if said is not None and said != gender:
        warn(
            f"{source.path}: model: found {named}, which is {said} by its name, expected the "
            f"{gender} one: the subject's template is made for it. Sequence.body is None"
        )
        return None
    return Body.load(named, gender=gender, model="smplx", v_template=mesh)


def body_of_betas(
    options: Options, motion: Motion, tracks: Mapping[str, ObjectTrack], why: str
) -> Body | None:
    """The person's body by the user's model, or the free body with the size that the motion tells.

    Args:
        options: The caller's; `model` names the model file, or a folder of them.
        motion: The person's motion, with the betas.
        tracks: Recorded poses of the objects.
        why: Begins the message where no model is named: which file does not say the size.
    """
    named = named_model(options)
    if named is None:
        return body_by_motion(why, motion, tracks)
    folder = named.is_dir()
    return Body.load(
        named,
        motion.betas,
        gender=motion.gender if folder else None,
        model=motion.model if folder else None,
    )


def _sized(mesh: Path, why: str) -> Body | None:
    """The free body with the size of a template; None, with a warning: it is no person."""
    try:
        body = template_body(mesh)
    except InputError as error:
        warn(f"{why}. Without it Sequence.body is None, for its size is not known either: {error}")
        return None
    warn(
        f"{why}. Without it Sequence.body is the default body with the template's size: stature "
        f"{body.stature:.2f} m"
    )
    return body

"""From the fields of a file to a `Motion`, shared by all formats but AMASS.

The module of a format maps the fields; the rules (axes rotated once, hands, shape, frame rate,
gender, warnings) are here.
"""

from __future__ import annotations

import os
from collections.abc import Container, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of, turned
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError, InputError
from halfphysics.formats.format import Options
from halfphysics.formats.speed_check import warn_of_speed
from halfphysics.motion import skeleton
from halfphysics.motion.file_metadata import FileMetadata
from halfphysics.motion.motion import GENDERS, MODELS, Motion
from halfphysics.motion.smplx_names import one_shape

Array = NDArray[np.float64]

_HANDS = list(skeleton.LEFT_HAND_JOINTS + skeleton.RIGHT_HAND_JOINTS)
# No joint turns more than three times about one axis; degrees read as radians do.
_DEGREES = 20.0
# Bounds on the mean component of the trunk's direction along an axis: upright above, across below.
_UPRIGHT, _ACROSS = 0.8, 0.3


def rotations_of(parts: Mapping[tuple[int, ...], Array]) -> Array:
    """Rotations (T, 55, 3) of joints -> axis-angle (T, 3 n) or (T, n, 3); others are zero."""
    frames = len(next(iter(parts.values())))
    full = np.zeros((frames, skeleton.N_JOINTS, 3))
    for joints, part in parts.items():
        full[:, list(joints)] = np.asarray(part).reshape(len(part), len(joints), 3)
    return full


def own_name(name: str, known: Container[str]) -> str:
    """The name of a clip, with a number if it is in `known` already: "walk#2"."""
    again, new = 2, name
    while new in known:
        new, again = f"{name}#{again}", again + 1
    return new


def same_length(where: str, lengths: Mapping[str, int]) -> int:
    """The number of frames that all fields have.

    Raises:
        FileError: The lengths differ.
    """
    if len(set(lengths.values())) > 1:
        raise FileError(
            f"{where}: fields of different length: found {dict(lengths)}, expected as many rows in "
            "each as there are frames"
        )
    return next(iter(lengths.values()))


def warn_of_degrees(where: str, rotations: Array) -> bool:
    """Warn of rotations (T, J, 3) that cannot be radians; returns whether it warned."""
    largest = float(np.abs(rotations[:, 1:]).max(initial=0.0))
    if largest > _DEGREES:
        warn(
            f"{where}: a joint is turned by {largest:.0f} rad; expected axis-angle in radians. "
            "Are these degrees?"
        )
    return largest > _DEGREES


def warn_of_axes(where: str, rotations: Array, up: str) -> None:
    """Warn of a body that is upright along the other axis throughout the motion."""
    if not len(rotations):
        return  # Motion raises the error
    spine = rot.to_matrix(rot.exp(rotations[:, 0]))[:, :, 1].mean(axis=0)
    # How much the trunk stands along the axis that is up in the file; rows of AXES are the world's.
    along = float(axes_of(up)[2] @ spine)
    other = "z" if up != "z" else "y"
    if float(axes_of(other)[2] @ spine) > _UPRIGHT and abs(along) < _ACROSS:
        warn(
            f"{where}: read with {up} up, and the body stands along {other} all the time. If it "
            f"should not lie, say up={other!r}"
        )


def mean_hands(path: str | os.PathLike[str] | None, gender: str) -> Array:
    """The relaxed hand (30, 3) of the user's body-model file.

    Raises:
        InputError: No file was named: only a licensed model file has its mean hand.
    """
    if path is None or str(path) in MODELS:
        raise InputError(
            "hands: 'mean' hands need the body-model file they were made with, found none. Name "
            "it with model=, for example model='SMPLX_NEUTRAL.npz'"
        )
    from halfphysics.body.body import Body

    # The clip's gender selects a file in a folder; a named file is used for any gender.
    mean = Body.load(path, gender=gender if os.path.isdir(path) else None).hands_mean
    if mean is None:
        raise FileError(f"{path}: this body model has no mean hands, expected SMPL-X or SMPL-H")
    return np.asarray(mean, dtype=np.float64).reshape(30, 3)


def motion_of(
    where: str,
    options: Options,
    *,
    format: str,
    translation: Array,
    rotations: Array,
    fps: float | None,
    up: Literal["y", "z", "-y"],
    model: str,
    gender: str | None = None,
    betas: ArrayLike | None = None,
    hands: Literal["flat", "mean", "unsaid"] | None = "flat",
    fields: Mapping[str, Any] | None = None,
    per_frame: Mapping[str, NDArray[Any]] | None = None,
) -> Motion:
    """A motion from the fields of a file, in the file's axes; the caller's options take precedence.

    Args:
        where: Name of the file or clip in messages.
        options: The caller's options; `frames` are cut already.
        format: Name of the format.
        translation: Translation of the SMPL origin (T, 3) [m], file axes.
        rotations: Axis-angle (T, 55, 3) [rad], file axes.
        fps: None if the file does not state it.
        up: The axis that is up in the format; "-y": y is down.
        model: "smplx", "smplh" or "smpl".
        gender: Any spelling; None if the file does not state it: neutral, with a warning.
        betas: (n,), (1, n) or equal rows (T, n); None or empty if the file has none.
        hands: Meaning of zero fingers; "unsaid": the caller must state it; None: the file has no
            fingers.
        fields, per_frame: Further data for the format's writer; see `FileMetadata`.

    Raises:
        FileError: The motion is impossible, or a value that the caller must state is missing.
        InputError: An option does not fit the file.
    """
    same_length(where, {"translation": len(translation), "rotations": len(rotations)})
    fps = _fps(where, options, fps)
    gender = _gender(where, options, gender)
    if options.model is not None and str(options.model) in MODELS:
        model = str(options.model)
    degrees = warn_of_degrees(where, rotations)
    warn_of_axes(where, rotations, options.up or up)
    mean = mean_hands(options.model, gender) if _hands_mean(where, options, hands) else None
    if mean is not None:
        rotations = np.array(rotations)
        rotations[:, _HANDS] += mean
    shape = None if betas is None else _shape(where, betas, len(translation))
    axes = axes_of(options.up or up)
    if (options.up or up) != "z":
        translation, rotations = turned(translation, rotations, axes)
    metadata = FileMetadata(
        format=format,
        fields={**(fields or {}), "hands_mean": mean},
        per_frame=dict(per_frame or {}),
    )
    try:
        motion = Motion(
            translation, rotations, fps, shape, gender, model, axes=axes, origin=metadata
        )
    except InputError as error:
        raise FileError(f"{where}: {error}") from None
    if not degrees:
        warn_of_speed(where, motion)
    return motion


def _fps(where: str, options: Options, fps: float | None) -> float:
    """The frame rate of the options, else that of the file."""
    fps = fps if options.fps is None else options.fps
    if fps is None:
        raise FileError(
            f"{where}: files of this format do not say their frame rate. Say it with fps=, for "
            "example fps=30"
        )
    return fps


def _shape(where: str, betas: ArrayLike, frames: int) -> Array | None:
    try:
        return one_shape("betas", betas, frames)
    except (InputError, ValueError) as error:
        raise FileError(f"{where}: field '{error}'") from None


def _gender(where: str, options: Options, gender: str | None) -> str:
    """The gender of the options, else of the file, else neutral with a warning."""
    if gender is None and options.gender is None:
        warn(f"{where}: does not say a gender: taken as neutral. Say it with gender=")
    gender = options.gender or (gender or "neutral").strip().lower()
    if gender not in GENDERS:
        raise FileError(
            f"{where}: gender: found {gender!r}, expected one of {', '.join(GENDERS)}. Say it with "
            "gender="
        )
    return gender


def _hands_mean(where: str, options: Options, hands: str | None) -> bool:
    """Whether zero fingers mean the model's mean hand; `hands` as in `motion_of`."""
    if options.hands is not None and hands is None:
        raise InputError(
            f"hands: found {options.hands!r}, but {where} has no fingers. Leave it out"
        )
    if hands == "unsaid" and options.hands is None:
        raise FileError(
            f"{where}: files of this format do not say whether zero fingers are a flat hand or "
            "the model's relaxed one. Say hands='flat', or hands='mean' with model= (the "
            "body-model file)"
        )
    return (options.hands or hands) == "mean"


def own_fields(motion: Motion) -> Mapping[str, Any]:
    """The further fields of a motion's file (`FileMetadata.fields`), empty without a file."""
    return motion.origin.fields if motion.origin is not None else {}


def file_parameters(motion: Motion, format: str) -> tuple[Array, Array, Mapping[str, Any]]:
    """Translation and rotations as the files of a format have them, for its writer.

    Returns:
        Translation (T, 3) and rotations (T, 55, 3) with the axes and hands of the
        motion's file, and the `FileMetadata.fields` (empty if the file is of another format).
    """
    translation, rotations = motion.in_file_axes()
    own = motion.origin if motion.origin and motion.origin.format == format else None
    fields: Mapping[str, Any] = own.fields if own else {}
    if fields.get("hands_mean") is not None:
        rotations[:, _HANDS] -= fields["hands_mean"]
    return translation, rotations, fields


def lost_joints(motion: Motion, held: Sequence[int]) -> tuple[str, ...]:
    """The rotations of a motion that a file with only these joints omits, for `Format.loses`."""
    lost = [j for j in range(skeleton.N_JOINTS) if j not in held and motion.rotations[:, j].any()]
    groups = {"the fingers": _HANDS, "jaw and eyes": skeleton.FACE_JOINTS}
    lines = []
    for name, joints in groups.items():
        if set(joints) & set(lost) and not set(joints) & set(held):
            lines.append(name)
            lost = [j for j in lost if j not in joints]
    if lost:
        lines.append(f"rotations of {', '.join(skeleton.JOINT_NAMES[j] for j in lost)}")
    return tuple(lines)


def lost_rate(motion: Motion, fps: float) -> tuple[str, ...]:
    """The line for `Format.loses` if the file has no frame rate and readers take `fps`."""
    if motion.fps == fps:
        return ()
    return (f"the frame rate {motion.fps:g}: readers take {fps:g}; say --to-fps {fps:g}",)


def lost_model(motion: Motion, model: str = "smplx") -> tuple[str, ...]:
    """The line for `Format.loses` if readers take a model other than the motion's."""
    if motion.model == model:
        return ()
    return (f"the model {motion.model!r} that the shape is of: readers take {model!r}",)

"""From the fields of a file to a `Motion`, shared by all formats.

The module of a format maps the fields; the rules (axes rotated once, hands, shape, frame rate,
gender, units, warnings) are here.
"""

from __future__ import annotations

import os
from collections.abc import Container, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.axes import axes_of, turned
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError, InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Options
from halfphysics.formats.gender_names import gender_named
from halfphysics.formats.speed_check import is_rest_pose, rest_pose_first, warn_of_speed
from halfphysics.formats.units_check import in_radians, unit_of
from halfphysics.motion import skeleton
from halfphysics.motion.file_metadata import FileMetadata
from halfphysics.motion.motion import GENDERS, MODELS, Motion
from halfphysics.motion.possible import MAX_SPEED
from halfphysics.motion.smplx_names import one_shape

Array = NDArray[np.float64]

_HANDS = list(skeleton.LEFT_HAND_JOINTS + skeleton.RIGHT_HAND_JOINTS)
#: Taken where neither file nor format says a frame rate: that of most video and most data sets.
USUAL_FPS = 30.0


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


def kept_rows(record: Record, key: str, total: int, frames: slice) -> dict[str, NDArray[Any]]:
    """A field with a row for each of `total` frames, to be written back, as `per_frame` of
    `motion_of`; a single row, or numbers without rows, are every frame's. Empty without the field.

    Warns:
        HalfPhysicsWarning: It has another number of rows, and is not kept.
    """
    if key not in record:
        return {}
    shape = record.shape(key)
    if len(shape) == 1:
        return {key: np.tile(record.numbers(key, None), (len(range(total)[frames]), 1))}
    count = shape[0] if shape else 0
    if count not in (1, total):
        warn(
            f"{record.where}: field '{key}': found {count} rows for {total} frames, expected one "
            "for each: it is not kept"
        )
        return {}
    if count == total:
        return {key: record.numbers(key, None, *shape[1:2], frames=frames)}
    rows = record.numbers(key, None, *shape[1:2])
    return {key: np.repeat(rows, len(range(total)[frames]), axis=0)}


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
    world: tuple[Array, Array] | None = None,
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
        fps: None if neither the file nor the format states it: 30, with a warning.
        up: The axis that is up in the format; "-y": y is down.
        model: "smplx", "smplh" or "smpl".
        gender: Any spelling; None if the file does not state it: neutral, with a warning.
        betas: (n,), (1, n) or equal rows (T, n); None or empty if the file has none.
        hands: Meaning of zero fingers; "unsaid": flat, with a warning; None: the file has no
            fingers.
        world: Rotation (3, 3) and place (3,) [m] of the file's frame in the data set's world, in
            which `up` is up; None: the file is in that world.
        fields, per_frame: Further data for the format's writer; see `FileMetadata`. `per_frame` has
            as many rows as there are frames.

    Raises:
        FileError: The motion is impossible.
        InputError: An option does not fit the file.
    """
    lengths = {"translation": len(translation), "rotations": len(rotations)}
    same_length(where, {**lengths, **{key: len(rows) for key, rows in (per_frame or {}).items()}})
    fps = rate_of(where, options, fps)
    gender = _gender(where, options, gender)
    if options.model is not None and str(options.model) in MODELS:
        model = str(options.model)
    mean = _mean_hands(where, options, gender, hands)
    shape = None if betas is None else shape_of(where, betas, len(translation))
    return made(
        where,
        options,
        format=format,
        translation=translation,
        rotations=rotations,
        fps=fps,
        up=options.up or up,
        betas=shape,
        gender=gender,
        model=model,
        mean=mean,
        fields=fields or {},
        per_frame=per_frame or {},
        world=world,
    )


def made(
    where: str,
    options: Options,
    *,
    format: str,
    translation: Array,
    rotations: Array,
    fps: float,
    up: str,
    betas: Array | None,
    gender: str,
    model: str,
    mean: Array | None,
    fields: Mapping[str, Any],
    per_frame: Mapping[str, NDArray[Any]],
    world: tuple[Array, Array] | None = None,
    quick: bool = False,
) -> Motion:
    """The motion of checked fields in the file's axes, in metres and radians by their content.

    Args:
        mean: The relaxed hand (30, 3) that zero fingers mean; None: a flat hand.
        world: As in `motion_of`.
        quick: It was looked at before, as what a result file holds.

    Raises:
        FileError: The motion is impossible.
    """
    doubtful = quick
    if not quick:
        rotations, doubtful = in_radians(where, rotations)
    own: dict[str, Any] = {"hands_mean": mean}
    if mean is not None:
        rotations = np.array(rotations)
        rotations[:, _HANDS] += mean
    axes = axes_of(up)
    if world is not None:
        own["world"], axes = world[0], axes @ world[0]
    if up != "z" or world is not None:
        translation, rotations = turned(translation, rotations, axes)
    unit = options.unit
    if unit == 1.0 and not doubtful:
        unit = unit_of(where, translation, rotations, fps, axes)
    if unit != 1.0:
        translation = unit * translation
        own["unit"] = unit
    if world is not None:
        translation = translation + axes_of(up) @ world[1]
    metadata = FileMetadata(format=format, fields={**fields, **own}, per_frame=dict(per_frame))
    try:
        motion = Motion(
            translation, rotations, fps, betas, gender, model, axes=axes, origin=metadata
        )
    except InputError as error:
        jump = len(translation) > 1 and np.linalg.norm(translation[1] - translation[0]) * fps
        if jump > MAX_SPEED and is_rest_pose(rotations[0]):
            cause = rest_pose_first(options.frames.start or 0)
            raise FileError(f"{where}: {error}. {cause}") from None
        raise FileError(f"{where}: {error}") from None
    if not doubtful:
        warn_of_speed(where, motion, options.frames.start or 0)
    return motion


def rate_of(where: str, options: Options, fps: float | None) -> float:
    """The frame rate of the options, else that of the file, else the usual one with a warning."""
    fps = fps if options.fps is None else options.fps
    if fps is None:
        warn(f"{where}: does not say its frame rate: taken as {USUAL_FPS:g}. Say it with fps=")
        return USUAL_FPS
    return fps


def shape_of(where: str, betas: ArrayLike, frames: int) -> Array | None:
    """One shape (n,) from betas (n,), (1, n) or equal rows (T, n); None: there is none."""
    try:
        return one_shape("betas", betas, frames)
    except InputError as error:
        raise FileError(f"{where}: field 'betas': {str(error).removeprefix('betas: ')}") from None
    except ValueError as error:
        raise FileError(f"{where}: field 'betas': {error}; expected numbers") from None


def _gender(where: str, options: Options, gender: str | None) -> str:
    """The gender of the options, else of the file, else neutral with a warning."""
    if gender is None and options.gender is None:
        warn(f"{where}: does not say a gender: taken as neutral. Say it with gender=")
    gender = options.gender or gender_named(gender or "neutral")
    if gender not in GENDERS:
        raise FileError(
            f"{where}: gender: found {gender!r}, expected one of {', '.join(GENDERS)}. Say it with "
            "gender="
        )
    return gender


def _mean_hands(where: str, options: Options, gender: str, hands: str | None) -> Array | None:
    """What is added to the fingers (30, 3); None: nothing. `hands` as in `motion_of`."""
    if options.hands is not None and hands is None:
        raise InputError(
            f"hands: found {options.hands!r}, but {where} has no fingers. Leave it out"
        )
    if hands == "unsaid":
        warn_of_hands(where, options)
    return mean_hands(options.model, gender) if (options.hands or hands) == "mean" else None


def warn_of_hands(where: str, options: Options) -> None:
    """Say that a file does not say what zero fingers mean, where the caller does not."""
    if options.hands is None:
        warn(
            f"{where}: does not say whether zero fingers are a flat hand or the model's relaxed "
            "one: taken as flat. Say hands='flat', or hands='mean' with model= (the body-model "
            "file)"
        )


def own_fields(motion: Motion) -> Mapping[str, Any]:
    """The further fields of a motion's file (`FileMetadata.fields`), empty without a file."""
    return motion.origin.fields if motion.origin is not None else {}


def file_parameters(motion: Motion, format: str) -> tuple[Array, Array, Mapping[str, Any]]:
    """Translation and rotations as the files of a format have them, for its writer.

    Returns:
        Translation (T, 3) and rotations (T, 55, 3) with the axes, unit and hands of the
        motion's file, and the `FileMetadata.fields` (empty if the file is of another format).
    """
    translation, rotations = motion.in_file_axes()
    own = motion.origin if motion.origin and motion.origin.format == format else None
    fields: Mapping[str, Any] = own.fields if own else {}
    if fields.get("hands_mean") is not None:
        rotations[:, _HANDS] -= fields["hands_mean"]
    return translation / fields.get("unit", 1.0), rotations, fields


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
    return (f"the frame rate {motion.fps:g}: readers take {fps:g}; say motion.resample({fps:g})",)


def lost_model(motion: Motion, model: str = "smplx") -> tuple[str, ...]:
    """The line for `Format.loses` if readers take a model other than the motion's."""
    if motion.model == model:
        return ()
    return (f"the model {motion.model!r} that the shape is of: readers take {model!r}",)


def lost_gender(motion: Motion) -> tuple[str, ...]:
    """The line for `Format.loses` if readers take the neutral model."""
    return () if motion.gender == "neutral" else (f"the gender {motion.gender!r}",)


def lost_betas(motion: Motion, held: int) -> tuple[str, ...]:
    """The line for `Format.loses` if the file has only so many betas."""
    if motion.betas is None or not motion.betas[held:].any():
        return ()
    return (f"betas beyond the first {held}",)

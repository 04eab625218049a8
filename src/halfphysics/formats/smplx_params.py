"""From a dictionary with the names of the `smplx` package to translation and rotations.

`global_orient, body_pose, transl`, and where there are any `betas, left_hand_pose, right_hand_pose,
jaw_pose, leye_pose, reye_pose, expression`, in any shape in which people store them:

- T frames first, one frame without an axis for it, or an axis of length one before;
- axis-angle, matrices or 6D (`rotation_forms`);
- `body_pose` of 21 joints (SMPL-X, SMPL-H) or 23 (SMPL, whose last two are rigid hands);
- hands of 45 numbers, or 6 to 24 principal components, which the model file expands.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from collections.abc import Sequence as Listing
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import as_array
from halfphysics.base.reader_warnings import warn
from halfphysics.body.model_files import read_hands
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.subject import named_model
from halfphysics.formats.format import Options
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.rotation_forms import SIX, numbers_of, rows_of, vectors, widths
from halfphysics.motion import skeleton
from halfphysics.motion.motion import MODELS
from halfphysics.motion.smplx_names import PARTS

Array = NDArray[np.float64]

NEEDED = ("global_orient", "body_pose")
#: Names of the translation, the first one that is there.
TRANSLATION = ("transl", "trans", "translation")
_HANDS = ("left_hand_pose", "right_hand_pose")
_MODEL = ("model", "model_type", "surface_model_type")
_BODY, _SMPL_BODY, _FINGERS = 21, 23, 15
_KNEES = [skeleton.JOINT_INDEX["left_knee"], skeleton.JOINT_INDEX["right_knee"]]


class Parts(NamedTuple):
    """A person's parameters in the axes of the file, all frames.

    Attributes:
        translation: (T, 3) [m].
        rotations: Axis-angle (T, 55, 3) [rad].
        betas: (n,), the mean over the frames; None: there are none.
        model: "smplx", "smplh" or "smpl".
        hands: What zero fingers mean: "mean" for principal components that the model file
            expanded, "unsaid" for fingers that are bent, "flat" for others; None: no fingers.
    """

    translation: Array
    rotations: Array
    betas: Array | None
    model: str
    hands: Literal["flat", "mean", "unsaid"] | None


def is_params(fields: object) -> bool:
    """Whether these are parameters of the `smplx` package: a mapping with two of three names."""
    if not hasattr(fields, "keys"):
        return False
    return len({*NEEDED, TRANSLATION[0]} & set(fields.keys())) >= 2


def stacked(frames: Listing[Mapping[str, Any]]) -> dict[str, Any]:
    """Fields of a list of frames: each with an axis for them before."""
    fields: dict[str, Any] = {}
    for key in frames[0]:
        if any(key not in frame for frame in frames):
            continue
        values = [frame[key] for frame in frames]
        single = all(isinstance(value, int | float) for value in values)
        same = single and all(value == values[0] for value in values)
        if isinstance(values[0], str | bytes) or same:  # of all frames, such as their rate
            fields[key] = values[0]
            continue
        try:
            fields[key] = np.stack([as_array(value) for value in values])
        except ValueError:
            fields[key] = np.zeros(0)  # of different shapes: named where it is needed
    return fields


def parts_of(record: Record, options: Options, *, columns: bool = False) -> Parts:
    """The parameters of one person.

    Args:
        record: The fields.
        options: The caller's; `model` names the file that expands principal components.
        columns: 6D of two vectors after each other are columns, not rows as of pytorch3d.

    Warns:
        HalfPhysicsWarning: What 6D was taken for, or hands that stay flat.

    Raises:
        FileError: A field is missing or has another shape.
    """
    key = next((key for key in TRANSLATION if key in record), TRANSLATION[0])
    record.raw(key, "(T, 3)")
    translation = _translation(record, key)
    frames = len(translation)
    raw = {
        part: rows_of(record, part, frames, _allowed(part, len(joints)))
        for part, joints in PARTS.items()
        if part not in _HANDS and (part in NEEDED or _has(record, part))
    }
    wide = raw["body_pose"].shape[1] in widths(_SMPL_BODY)
    count = {part: len(joints) for part, joints in PARTS.items()}
    count["body_pose"] = _SMPL_BODY if wide else _BODY
    full = _turns(record, raw, count, columns)
    if not columns and raw["body_pose"].shape[1] == SIX * count["body_pose"]:
        # Knees bend one way only: inverse matrices bend them the other way.
        columns = bool(full[:, _KNEES, 0].mean() < 0.0)
        warn(
            f"{record.where}: rotations are 6D: taken as the first two "
            f"{'columns' if columns else 'rows'} of matrices, by which way the knees bend"
        )
        full = _turns(record, raw, count, columns)
    hands = _hands(record, options, full, columns)
    model = _model(record, wide, hands)
    return Parts(translation, full, mean_shape(record, "betas", frames), model, hands)


def _turns(
    record: Record, raw: Mapping[str, Array], count: Mapping[str, int], columns: bool
) -> Array:
    """Rotations (T, 55, 3) of rows of numbers by part; fingers are zero."""
    full = np.zeros((len(raw["body_pose"]), skeleton.N_JOINTS, 3))
    for part, rows in raw.items():
        turns = vectors(record, part, rows, count[part], columns=columns)
        full[:, list(PARTS[part])] = turns[:, : len(PARTS[part])]
    return full


def _has(record: Record, key: str) -> bool:
    return key in record and record.raw(key) is not None and math.prod(record.shape(key)) > 0


def _translation(record: Record, key: str) -> Array:
    array = numbers_of(record, key)
    rows = max((1, *array.shape[:-1]))
    if array.size == 0 or array.shape[-1:] != (3,) or array.size != 3 * rows:
        raise record.error(key, f"found shape {array.shape}, expected numbers of (T, 3)")
    return array.reshape(-1, 3)


def _allowed(part: str, joints: int) -> tuple[int, ...]:
    if part != "body_pose":
        return widths(joints)
    return (*widths(_BODY), *widths(_SMPL_BODY))


def _hands(
    record: Record, options: Options, full: Array, columns: bool
) -> Literal["flat", "mean", "unsaid"] | None:
    """Put the fingers into `full` (T, 55, 3); what zero fingers mean."""
    frames = len(full)
    there = [key for key in _HANDS if _has(record, key)]
    if not there:
        return None
    model, components = named_model(options), 0
    for side, key in enumerate(_HANDS):
        if key not in there:
            continue
        whole = widths(_FINGERS)
        rows = rows_of(record, key, frames, (*range(1, whole[0]), *whole))
        fingers = list(PARTS[key])
        if rows.shape[1] in whole:
            full[:, fingers] = vectors(record, key, rows, _FINGERS, columns=columns)
        elif model is not None:
            components = rows.shape[1]
            axes = read_hands(model, gender_of(record, options) if model.is_dir() else None)[1]
            full[:, fingers] = (rows @ axes[side, :components]).reshape(frames, _FINGERS, 3)
        else:
            components = rows.shape[1]
    if components and model is None:
        warn(
            f"{record.where}: hands are {components} principal components, which only the SMPL-X "
            "model file expands: fingers stay flat. Name it with model="
        )
        return "flat"
    if components:
        return "mean"
    return "unsaid" if full[:, 25:].any() else "flat"


def gender_of(record: Record, options: Options) -> str:
    """The gender of the options, else of the file, else neutral."""
    return options.gender or said_gender(record) or "neutral"


def _model(record: Record, wide: bool, hands: str | None) -> str:
    """The model that the file names, else the one that has these joints."""
    for key in _MODEL:
        if key in record and isinstance(record.raw(key), str | bytes | np.ndarray):
            said = record.text(key).lower()
            if said in MODELS:
                return said
    if wide:
        return "smpl" if hands is None else "smplh"
    return "smplx"

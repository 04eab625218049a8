"""MDM `sample##_rep##_smpl_params.npy`: SMPL's rotations as MDM fits them to its joints.

numpy.save of a dict: `thetas` (24, 6, T), the first two ROWS of every joint's rotation matrix (as
pytorch3d has it; HumanML3D's own six numbers are columns), `root_translation` (3, T), the POSITION
of the pelvis [m] and not SMPL's translation, `motion` (25, 6, T), which is both, `vertices`
(6890, 3, T), `faces`, `text`, `length`. y up, 20 fps, neutral SMPL, shape zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import (
    own_fields,
    same_length,
)
from halfphysics.formats.pelvis_place import lost_by_pelvis, motion_by_pelvis
from halfphysics.formats.positions.layouts import FPS
from halfphysics.formats.positions.written_joints import write_array
from halfphysics.formats.written_people import written
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

NAME = "mdm-smpl"
_KEYS = {"thetas", "root_translation"}
#: Rows shorter than this, or pairs this close to parallel, are no rotation.
_LEAST = 1e-3


def matrices_of_rows(rows: Array) -> Array:
    """Rotation matrices (..., 3, 3) whose first two rows are given (..., 6), made orthogonal.

    Raises:
        ValueError: Two rows are zero or parallel.
    """
    first, second = rows[..., :3], rows[..., 3:]
    length = np.linalg.norm(first, axis=-1, keepdims=True)
    x = first / np.maximum(length, 1e-12)
    y = second - x * (x * second).sum(axis=-1, keepdims=True)
    left = np.linalg.norm(y, axis=-1, keepdims=True)
    if min(length.min(), left.min()) < _LEAST:
        raise ValueError("two rows are zero or parallel")
    y = y / left
    return np.stack([x, y, np.cross(x, y)], axis=-2)


def turned_parts(
    where: str,
    options: Options,
    rows: Array,
    pelvis: Array,
    *,
    format: str,
    fields: Mapping[str, Any],
) -> Motion:
    """A motion from rows of matrices (T, 24, 6) and positions of the pelvis (T, 3) [m]."""
    try:
        turns = rot.matrix_to_rotvec(matrices_of_rows(rows[:, :22]))
    except ValueError as error:
        raise FileError(f"{where}: no rotations of six numbers: {error}") from None
    return motion_by_pelvis(
        where, options, turns, pelvis, format=format, up="y", fps=FPS, fields=fields
    )


def _sniff(source: Source) -> bool:
    data = source.data
    return isinstance(data, dict) and data.keys() >= _KEYS


def _load(source: Source, options: Options) -> Motion:
    record = Record(source.path, source.data)
    rows = record.array("thetas", 24, 6, None)
    pelvis = record.array("root_translation", 3, None)
    same_length(record.where, {"thetas": rows.shape[2], "root_translation": pelvis.shape[1]})
    text = {"text": record.text("text")} if "text" in record else {}
    return turned_parts(
        record.where,
        options,
        np.moveaxis(rows, 2, 0)[options.frames],
        pelvis.T[options.frames],
        format=NAME,
        fields=text,
    )


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    person = written([motion], NAME, [body])["0"]
    matrices = rot.rotvec_to_matrix(person.smpl().reshape(len(motion), 24, 3))
    rows = np.moveaxis(matrices[..., :2, :].reshape(len(motion), 24, 6), 0, -1)
    pelvis = (person.translation + person.rest[0]).T
    whole = np.zeros((25, 6, len(motion)))
    whole[:24], whole[24, :3] = rows, pelvis
    said = own_fields(motion).get("text", "") if motion.origin else ""
    said = {"text": said, "length": len(motion)}
    write_array(path, {"motion": whole, "thetas": rows, "root_translation": pelvis, **said})


def _loses(motion: Motion) -> tuple[str, ...]:
    return lost_by_pelvis(motion, FPS)


FORMAT = Format(
    name=NAME,
    about="SMPL parameters that MDM fits to its joints (sample##_rep##_smpl_params.npy)",
    expects="pickled .npy with thetas (24, 6, T) and root_translation (3, T)",
    invents="hands, frame rate (20), the pelvis of SMPL at rest without model=",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".npy",),
    up="y",
    loses=_loses,
)

"""Fingers that are told relative to the relaxed hand of SMPL-X, also as principal components.

`smplx.create` makes such hands by default (`flat_hand_mean=False`, `use_pca=True`): the first n
principal components, added to the mean hand. Both are in the licensed model file only.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.body.model_files import read_hands
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.subject import named_model
from halfphysics.formats.format import Options
from halfphysics.motion import skeleton

Array = NDArray[np.float64]

HANDS: Mapping[str, tuple[int, ...]] = {
    "left_hand_pose": skeleton.LEFT_HAND_JOINTS,
    "right_hand_pose": skeleton.RIGHT_HAND_JOINTS,
}
_FULL = 45


def relaxed_fingers(
    record: Record, options: Options, gender: str, hands: Mapping[str, Array]
) -> tuple[dict[tuple[int, ...], Array], Literal["flat", "mean"]]:
    """Rotations of the fingers, and what zero means in them, for `motion_of`.

    Args:
        record: The file, for messages.
        options: The caller's; `model` names the model file.
        gender: Selects a file, where `model` is a folder.
        hands: Keys of `HANDS` -> components (T, n), or rotations (T, 45).

    Returns:
        Joints -> (T, 45), and "mean". Without the model "flat", and zeros for components.

    Warns:
        HalfPhysicsWarning: The model is needed and was not named.

    Raises:
        FileError: More than 45 columns, or a model without hands.
    """
    model = named_model(options)
    counts = {key: part.shape[1] for key, part in hands.items()}
    for key, count in counts.items():
        if not 0 < count <= _FULL:
            raise record.error(key, f"found {count} columns, expected 1 to {_FULL}")
    axes = None if model is None else read_hands(model, gender if model.is_dir() else None)[1]
    parts: dict[tuple[int, ...], Array] = {}
    for side, (key, joints) in enumerate(HANDS.items()):
        if key not in hands:
            continue
        part = hands[key]
        if counts[key] < _FULL:
            still = np.zeros((len(part), _FULL))
            part = still if axes is None else part @ axes[side, : counts[key]]
        parts[joints] = part
    if model is None and hands and options.hands is None:
        fewest = min(counts.values())
        what = f"{fewest} principal components" if fewest < _FULL else "rotations"
        then = "stay flat" if fewest < _FULL else "are taken as on a flat one"
        warn(
            f"{record.where}: hands are {what} about the relaxed hand of SMPL-X, which only the "
            f"model file has: fingers {then}. Name it with model="
        )
    return parts, "flat" if model is None else "mean"

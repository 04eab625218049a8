"""SMPL's rotations with the place of the pelvis instead of SMPL's translation: MDM's fits, EDGE.

The pelvis of SMPL at rest is in the licensed model: `model=` names it. Without it, that of the
default body is taken, so that its pelvis is where the file has it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.formats.datasets.subject import named_model
from halfphysics.formats.format import Options
from halfphysics.formats.motion_builder import (
    lost_gender,
    lost_joints,
    lost_model,
    lost_rate,
    motion_of,
    rotations_of,
)
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]


def motion_by_pelvis(
    where: str,
    options: Options,
    turns: Array,
    pelvis: Array,
    *,
    format: str,
    up: Literal["y", "z", "-y"],
    fps: float,
    fields: Mapping[str, Any],
) -> Motion:
    """A motion whose pelvis is where the file has it: neutral SMPL of shape zero.

    Args:
        where: Name of the file in messages.
        options: The caller's; `frames` are cut already.
        turns: Axis-angle (T, 22, 3) of SMPL's joints but the hands [rad], in the axes of the file.
        pelvis: Places (T, 3) [m], in the axes of the file.
        format: Name of the format.
        up: The axis that is up in the file.
        fps: The rate that the format has; files do not say theirs.
        fields: Further data for the format's writer.

    Warns:
        HalfPhysicsWarning: What is not in the file.
    """
    model = named_model(options)
    invented = {"hands": "hands"}
    if options.fps is None:
        invented["fps"] = f"the rate ({fps:g} fps)"
    if model is None:
        body, invented["translation"] = Body.default(), "the pelvis of SMPL at rest"
    else:
        folder = model.is_dir()
        body = Body.load(
            model, gender="neutral" if folder else None, model="smpl" if folder else None
        )
    warn(f"{where}: not in the file: {', '.join(invented.values())}")
    return motion_of(
        where,
        options,
        format=format,
        translation=pelvis - np.asarray(body.rest_joints)[0],
        rotations=rotations_of({skeleton.SMPL_JOINTS: turns}),
        fps=fps,
        up=up,
        model="smpl",
        gender="neutral",
        hands=None,
        fields={**fields, "invented": invented, "rest": np.asarray(body.rest_joints)},
    )


def lost_by_pelvis(motion: Motion, fps: float) -> tuple[str, ...]:
    """What files of these formats, which readers take at `fps`, cannot hold: `Format.loses`."""
    lost = [*lost_joints(motion, skeleton.SMPL_JOINTS), *lost_model(motion, "smpl")]
    if motion.betas is not None and motion.betas.any():
        lost.append("the shape (betas)")
    return (*lost, *lost_gender(motion), *lost_rate(motion, fps))

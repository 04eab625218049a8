"""Whether a motion and a body belong to the same model."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.body.body import FREE, Body
from halfphysics.errors import HalfPhysicsWarning, MismatchError

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion


def check_match(motion: Motion, body: Body, allow_mismatch: bool = False) -> None:
    """Refuse a motion and a body whose betas belong to different models.

    The default body fits every motion, but does not take over its betas.

    Args:
        motion: Its `model`, `gender` and `betas` are compared.
        body: Its `model` and `gender` are compared.
        allow_mismatch: Accept any model and gender.

    Warns:
        HalfPhysicsWarning: The body is the default one, without a person's bones, and the motion
            has a shape of its own.

    Raises:
        MismatchError: Model or gender differ.
    """
    if body.model == FREE:
        if body.given_bones is not None:
            return
        if motion.betas is not None and np.any(motion.betas):
            warnings.warn(
                f"the motion's betas are {motion.model} {motion.gender}'s and the default body "
                "has its own: its shape is used as it is. Only stature and bones carry over: "
                "Body.default(stature=...) or (bones=...) [m]; or load the motion's model with "
                "Body.load",
                HalfPhysicsWarning,
                stacklevel=3,
            )
        return
    if allow_mismatch:
        return
    unknown = (None, "", "unknown")
    same_gender = motion.gender == body.gender or motion.gender in unknown or body.gender in unknown
    if motion.model == body.model and same_gender:
        return
    name = "" if body.source is None else f" ({body.source.path})"
    raise MismatchError(
        f"the motion is of {motion.model} {motion.gender}, the body{name} of {body.model} "
        f"{body.gender}: betas do not carry over. Load the motion's model (Body.load(folder, "
        f"betas=motion.betas, gender='{motion.gender}', model='{motion.model}')), use "
        "Body.default(), or keep this body and its shape with allow_mismatch=True"
    )

"""What no motion of a person is: a root faster than anybody, joints turned many times about."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError

Array = NDArray[np.float64]

#: Highest speed of a person's root [m/s]; beyond it the unit or the file is wrong.
MAX_SPEED = 50.0
#: An axis-angle component beyond this is no angle of a joint in radians: it is more than a turn.
_TURN = 2.0 * np.pi
#: Beyond this it is suspicious [rad]; so many joints make it certain: in degrees most bend more.
SUSPICIOUS, _CERTAIN = 20.0, 4
#: Rotation vectors may be of any size, and some are left a few turns too long: the class itself
#: refuses what goes beyond this [rad], five turns of a joint, or arms that hang, in degrees.
_REFUSED = 30.0
# Joints of limbs and trunk: fingers and face may be noise.
_BODY = slice(1, 22)


def check_speed(translation: Array, fps: float) -> None:
    """Refuse a root that is faster than a person: a wrong unit, a wrong rate or a cut.

    Raises:
        InputError: It is faster than MAX_SPEED.
    """
    speed = np.linalg.norm(np.diff(translation, axis=0), axis=1) * fps
    if speed.max() > MAX_SPEED:
        i = int(np.argmax(speed))
        raise InputError(
            f"translation: the root moves at {speed[i]:.3g} m/s between frames {i} and {i + 1} "
            f"({fps:g} fps), expected under {MAX_SPEED:g}. Is it in metres and the fps right? "
            "Where the clip has a cut, split it there (Motion.load(..., frames=(start, stop)))"
        )


def are_degrees(rotations: Array, beyond_all: float = SUSPICIOUS) -> bool:
    """Whether axis-angle (T, 55, 3) must be in degrees: several joints are turned too far, and the
    largest component is beyond `beyond_all`."""
    if float(np.abs(rotations[:, 1:]).max(initial=0.0)) <= beyond_all:
        return False
    beyond = (np.abs(rotations[:, _BODY]) > _TURN).any(axis=(0, 2))
    return int(beyond.sum()) >= _CERTAIN


def check_radians(rotations: Array) -> None:
    """Refuse axis-angle (T, 55, 3) in degrees.

    Raises:
        InputError: It can only be in degrees.
    """
    if are_degrees(rotations, _REFUSED):
        largest = float(np.abs(rotations[:, 1:]).max())
        raise InputError(
            f"rotations: joints are turned by up to {largest:.0f} rad, expected axis-angle in "
            "radians. Are these degrees? numpy.radians(rotations) turns them into radians"
        )

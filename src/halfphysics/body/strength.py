"""Strength: limits of the force and torques that the drive may exert, with human defaults."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.motion.joint_groups import ROOT_FORCE, JointValues, joint_values

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

_FINGERS = ("index", "middle", "ring", "pinky")
_STANDARD_GRAVITY = 9.80665
#: Force of the ground on a standing person beyond the own weight, in body weights: an isometric
#: mid-thigh pull reaches about 2.5 body weights on the ground (Comfort et al. 2019, Strength
#: Cond J 41), one of which is the person's own.
ROOT_BODY_WEIGHTS = 1.5

#: Peak isometric torques of healthy adults, averaged over the joint's main directions [N m].
HUMAN: JointValues = JointValues(
    {
        # Turning the whole body on its feet: the root's force at a third of a metre.
        "pelvis": 300.0,
        # Trunk extension 200 to 300: Keller and Roy 2002, J Spinal Disord Tech 15.
        "trunk": 250.0,
        # Neck extension 25 to 40: Vasavada et al. 2001, Spine 26.
        "head": 30.0,
        # Scapular elevation and protraction transmit the load of the shoulder, at its lever arm.
        "left_collar": 100.0,
        "right_collar": 100.0,
        # Shoulder 60 to 90 and elbow flexion 60 to 70: Holzbaur et al. 2007, J Biomech 40.
        "left_shoulder": 80.0,
        "right_shoulder": 80.0,
        "left_elbow": 65.0,
        "right_elbow": 65.0,
        # Wrist 10 to 15: Delp et al. 1996, J Biomech 29.
        "left_wrist": 12.0,
        "right_wrist": 12.0,
        # Hip extension 200 to 300, knee extension 200 to 250: Anderson et al. 2007, J Biomech 40.
        "left_hip": 250.0,
        "right_hip": 250.0,
        "left_knee": 220.0,
        "right_knee": 220.0,
        # Plantar flexion 120 to 150: Anderson et al. 2007.
        "left_ankle": 140.0,
        "right_ankle": 140.0,
        # Toes, all together 10 to 20: Goldmann and Brueggemann 2012, J Anat 221.
        "left_foot": 15.0,
        "right_foot": 15.0,
        # Along a finger, so that a closed hand grips with some 20 N a side and holds still.
        **{
            f"{side}_{finger}{k}": torque
            for side in ("left", "right")
            for finger in _FINGERS
            for k, torque in ((1, 0.8), (2, 0.4), (3, 0.2))
        },
        # A thumb bears what four fingers press against it with: a third of a tip pinch of 50 to
        # 80 N (Mathiowetz et al. 1985, Arch Phys Med Rehabil 66) at the lengths of its bones.
        **{
            f"{side}_thumb{k}": torque
            for side in ("left", "right")
            for k, torque in ((1, 2.4), (2, 1.2), (3, 0.6))
        },
    }
)


def checked_strength(value: Any) -> str | JointValues | None:
    """`Settings.strength` as it is kept: None, "human", or limits by joint [N m].

    Raises:
        InputError: Anything else.
    """
    if value is None:
        return None
    if isinstance(value, str):
        if value == "human":
            return value
        raise InputError(
            f"Settings.strength is {value!r}; expected None, 'human', or a mapping from joints or "
            "groups of them to limits [N m]"
        )
    return joint_values(
        value, "Settings.strength", extra=(ROOT_FORCE,), unit=f"N m; N of {ROOT_FORCE!r}"
    )


def limits_of(strength: str | Mapping[str, float], body: Body) -> tuple[float, Array]:
    """Limits of a person's drive: force on the root [N] and torque of all joints (55,) [N m].

    Row 0 is the torque on the root's rotation; inf: no limit.
    """
    if isinstance(strength, str):
        mass = sum(part.mass for part in body.variant.parts)
        return ROOT_BODY_WEIGHTS * mass * _STANDARD_GRAVITY, HUMAN.resolve(np.inf)
    given = dict(strength)
    force = given.pop(ROOT_FORCE, np.inf)
    torque = JointValues(given).resolve(np.inf)
    return force, torque

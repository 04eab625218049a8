"""How a motion may drive the body, in half-physics and its baselines, and what goes with that."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.settings import Settings

#: How a motion may drive the body.
Mode = Literal[
    "velocity",
    "torque",
    "positions",
    "interpolated",
    "kinematic",
    "engine_kinematic",
    "engine_velocity",
]

#: Modes in which the person's pose is set and not driven, and how the core calls them.
FORCED: Mapping[Mode, int] = {"kinematic": 1, "positions": 2, "interpolated": 3}

#: Modes that run in MuJoCo instead of the native core.
ENGINE_MODES: frozenset[Mode] = frozenset({"engine_kinematic", "engine_velocity"})

#: What neither knows: field of `Settings`, the value it must have, and why where poses are set.
_WITHOUT = (
    ("root", "stay", "nobody leaves the reference"),
    ("self_contact", False, "nobody gives way"),
    ("strength", None, "nothing is exerted"),
    ("internal_forces", False, "no force acts on the person"),
    ("joint_damping", 0.0, "no force acts on the person"),
)


def check_mode(settings: Settings) -> None:
    """Refuse what the mode of `settings` cannot heed, where poses are set and in MuJoCo.

    Raises:
        InputError: A return to the reference, contact with oneself, a limit of strength, forces on
            joints; in MuJoCo stiffness by joint.
    """
    mode = settings.mode
    if mode not in FORCED and mode not in ENGINE_MODES:
        return
    for name, only, why in _WITHOUT:
        found = getattr(settings, name)
        if found != only:
            said = f"sets the person's pose: {why}" if mode in FORCED else f"MuJoCo has no {name}"
            raise InputError(
                f"Settings.{name} is {found!r} with mode={mode!r}: {said}; expected {only!r}, "
                "or mode='velocity'"
            )
    if mode in ENGINE_MODES and isinstance(settings.stiffness, Mapping):
        raise no_stiffness(mode)


def no_stiffness(mode: Mode) -> InputError:
    """The error of who asks for stiffness by joint or over time in MuJoCo."""
    return InputError(
        f"stiffness: found one by joint or over time with mode={mode!r}, which is plain MuJoCo "
        "without joint stiffness; leave it out, or use mode='velocity'"
    )

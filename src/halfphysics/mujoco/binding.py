"""Takes over the people of a compiled MuJoCo model: `bind`."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

from halfphysics.base.validation import several
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.mujoco.attach import Human
from halfphysics.mujoco.control import Control
from halfphysics.settings import Settings

#: Longest step for which the drive is accurate [s] (docs/physics.md, "The drive").
LONGEST_STEP = 1.0 / 240.0


def bind(
    model: Any, data: Any, humans: Human | Sequence[Human], *, settings: Settings | None = None
) -> Control:
    """Take over people in a compiled model, to be stepped together.

    Args:
        model, data: The `mujoco.MjModel` that the spec compiled to, and its `mujoco.MjData`.
        humans: What `attach` returned, one per person; people touch each other, too.
        settings: Of all of them. See `Settings`; `substeps` and `record` do not apply (a substep is
            a timestep of the model), friction is that of the geoms.

    Raises:
        InputError: Nobody, somebody twice, another model, data of another model, or geoms that
            cannot be touched.
    """
    return bound(model, data, several(humans), settings)


def bound(model: Any, data: Any, humans: Sequence[Human], settings: Settings | None) -> Control:
    """`bind`; two calls below the user's line, for warnings."""
    settings = Settings() if settings is None else settings
    _check_settings(settings)
    _check_humans(humans)
    _check_world(model, data)
    if model.opt.timestep > LONGEST_STEP + 1e-12:
        warnings.warn(
            f"bind: the model's timestep is {model.opt.timestep:g} s; the drive wants at most "
            f"{LONGEST_STEP:g} s (model.opt.timestep)",
            HalfPhysicsWarning,
            stacklevel=3,
        )
    control = Control(model, data, humans, settings)
    unseen = [h.prefix for h in humans if not model.body_geomnum[_part(model, h)]]
    if unseen:
        warnings.warn(
            f"bind: the compiler has discarded the geoms of {', '.join(map(repr, unseen))}: they "
            "push and are pushed, but cameras and rangefinders do not see them, and "
            "Control.contact has -1 for their parts. Set spec.compiler.discardvisual = False "
            "before compile() (it is on for URDF)",
            HalfPhysicsWarning,
            stacklevel=3,
        )
    return control


def _part(model: Any, human: Human) -> int:
    """The body of a person's pelvis, which has a geom."""
    return int(model.body(f"{human.prefix}{JOINT_NAMES[0]}").id)


def _check_settings(settings: Settings) -> None:
    """Refuse settings that a hosted person does not support."""
    if not isinstance(settings, Settings):
        raise InputError(f"settings: found {settings!r}, expected halfphysics.Settings")
    if settings.drive.poses or settings.drive.follow is not None:
        raise InputError(
            f"bind: found the baseline {type(settings).__name__}; in a MuJoCo world of one's "
            "own a person is driven. Expected other settings, or use halfphysics.Simulator"
        )


def _check_world(model: Any, data: Any) -> None:
    """Refuse what is no world of MuJoCo: the core writes into the data by the model's sizes."""
    import mujoco

    if not isinstance(model, mujoco.MjModel) or not isinstance(data, mujoco.MjData):
        raise InputError(
            f"bind: found {type(model).__name__} and {type(data).__name__}, expected a "
            "mujoco.MjModel and its mujoco.MjData"
        )
    if data.signature != model.signature:
        raise InputError(
            "bind: the data is of another model; expected mujoco.MjData(model) of this one"
        )


def _check_humans(humans: Sequence[Human]) -> None:
    """Refuse what is no person, nobody, and somebody twice."""
    for human in humans:
        if not isinstance(human, Human):
            raise InputError(
                f"bind: humans: found {type(human).__name__}, expected what attach returned"
            )
    prefixes = [human.prefix for human in humans]
    if not prefixes or len(set(prefixes)) < len(prefixes):
        found = ", ".join(map(repr, prefixes)) or "nobody"
        raise InputError(f"bind: humans: found {found}, expected people of different prefixes")

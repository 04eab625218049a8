"""Settings of any kind from flat options: those of the command line, of sweeps and result files.

The options are the fields of `Settings`, and besides

    mode              how the motion moves the body, see `MODES`; "velocity" is half-physics
    internal_forces   with mode "velocity" and "torque", see `Ablation`
    joint_damping     likewise
    torque_frequency  with mode "torque": `Torque.frequency`
    torque_damping    with mode "torque": `Torque.damping`
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Literal

from halfphysics.base.validation import shown
from halfphysics.baselines.settings import (
    Ablation,
    EngineKinematic,
    EngineVelocity,
    Interpolated,
    Kinematic,
    Positions,
    Torque,
)
from halfphysics.errors import InputError
from halfphysics.settings import AS_IT_IS, Settings

Mode = Literal[
    "velocity",
    "torque",
    "positions",
    "interpolated",
    "kinematic",
    "engine_kinematic",
    "engine_velocity",
]

#: Mode -> kind of settings.
MODES: Mapping[Mode, type[Settings]] = {
    "velocity": Settings,
    "torque": Torque,
    "positions": Positions,
    "interpolated": Interpolated,
    "kinematic": Kinematic,
    "engine_kinematic": EngineKinematic,
    "engine_velocity": EngineVelocity,
}
_FORCES: Mapping[str, Any] = {"internal_forces": False, "joint_damping": 0.0}
#: Option -> field of `Torque`.
_TORQUE: Mapping[str, str] = {"torque_frequency": "frequency", "torque_damping": "damping"}
#: Options of baselines -> their defaults.
_DEFAULTS: Mapping[str, Any] = {
    "mode": "velocity",
    **_FORCES,
    **{option: getattr(Torque, field) for option, field in _TORQUE.items()},
}

_FIELDS = [f.name for f in fields(Settings)]
_AT = _FIELDS.index("threads")
#: Names of all options, in the order that result files have them in.
OPTIONS = (*_FIELDS[:_AT], *_DEFAULTS, *_FIELDS[_AT:])


def from_options(options: Mapping[str, Any]) -> Settings:
    """The settings that flat options describe; options that are left out have their defaults.

    The options of torques count with mode "torque" alone.

    Raises:
        InputError: An unknown option or mode, an impossible value, or options that do not go
            together.
    """
    values = dict(options)
    mode = values.pop("mode", "velocity")
    unknown = [name for name in values if name not in OPTIONS]
    if unknown:
        raise InputError(f"settings: found {unknown}, expected some of {', '.join(OPTIONS)}")
    known = isinstance(mode, str) and mode in MODES
    if not known:
        expected = " or ".join(map(repr, MODES))
        raise InputError(f"mode is {shown(mode)}; expected {expected}")
    torque = {name: values.pop(name) for name in _TORQUE if name in values}
    forces = {name: values.pop(name) for name in _FORCES if name in values}
    if mode == "torque":
        values |= {_TORQUE[name]: value for name, value in torque.items()}
        return Torque(**values, **forces)
    asked = {name: value for name, value in forces.items() if value != _FORCES[name]}
    if not asked:
        return MODES[mode](**values)
    if mode != "velocity":
        name, value = next(iter(asked.items()))
        raise InputError(
            f"{name} is {value!r} with mode={mode!r}, where no such force acts on the person; "
            f"expected {_FORCES[name]!r}, or mode='velocity'"
        )
    return Ablation(**values, **forces)


def options_of(settings: Settings) -> dict[str, Any]:
    """All flat options of settings: the reverse of `from_options`."""
    values = {f.name: getattr(settings, f.name) for f in fields(settings)}
    if isinstance(settings, Torque):
        values |= {option: values.pop(field) for option, field in _TORQUE.items()}
    kinds = {kind: mode for mode, kind in MODES.items()}
    values = {**_DEFAULTS, **values, "mode": kinds.get(type(settings), "velocity")}
    return {name: values[name] for name in OPTIONS}


def with_options(settings: Settings, options: Mapping[str, Any]) -> Settings:
    """Settings with some of their flat options changed.

    What half-physics and baselines have different defaults of is the default of the mode asked for,
    where it was the default.

    Raises:
        InputError: As `from_options`.
    """
    if not options:
        return settings
    kept = options_of(settings)
    for name in AS_IT_IS:
        if kept[name] == getattr(type(settings), name):
            del kept[name]
    return from_options({**kept, **options})

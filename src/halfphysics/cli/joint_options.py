"""`--stiffness 1`, `--stiffness hands=1,legs=0.2`, `--strength human`: numbers per joint group."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import tyro

from halfphysics.motion.joint_groups import JointValues

_FIRMNESS = float | Mapping[str, float]
_STRENGTH = Literal["human"] | Mapping[str, float] | None


def joint_options() -> Any:
    """A context in which tyro can read the values per joint of `Settings`."""
    registry = tyro.constructors.ConstructorRegistry()

    @registry.primitive_rule
    def rule(info: tyro.constructors.PrimitiveTypeInfo) -> Any:
        if info.type == _FIRMNESS:
            return _spec("FLOAT|JOINTS=FLOAT,...", lambda text: float(text))
        if info.type == _STRENGTH:
            return _spec("None|human|JOINTS=FLOAT,...", _word)
        return None

    return registry


def _word(text: str) -> str | None:
    if text not in ("None", "human"):
        raise ValueError(f"found {text!r}, expected None, human or JOINTS=NUMBER,...")
    return None if text == "None" else text


def _spec(metavar: str, single: Any) -> Any:
    def read(arguments: list[str]) -> Any:
        (text,) = arguments
        return _pairs(text) if "=" in text else single(text)

    return tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=read,
        is_instance=lambda value: True,
        str_from_instance=lambda value: [_text(value)],
    )


def _pairs(text: str) -> dict[str, float]:
    pairs = {}
    for pair in text.split(","):
        name, _, number = pair.partition("=")
        try:
            pairs[name.strip()] = float(number)
        except ValueError:
            raise ValueError(f"found {pair!r}, expected JOINTS=NUMBER, such as legs=0.2") from None
    return pairs


def _text(value: float | str | JointValues | None) -> str:
    if isinstance(value, Mapping):
        return ",".join(f"{name}={number:g}" for name, number in value.items())
    return str(value)

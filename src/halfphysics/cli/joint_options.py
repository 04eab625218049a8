"""`--stiffness hands=1,legs=0.2`, `--strength human`, `--soft-skin yes`: values per joint group."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import tyro

from halfphysics.body.soft_skin import SoftSkin
from halfphysics.motion.joint_groups import JointValues

_STIFFNESS = float | Mapping[str, float]
_STRENGTH = Literal["human"] | Mapping[str, float] | None
_SOFT_SKIN = bool | SoftSkin


def joint_spec(kind: Any) -> Any:
    """How tyro reads the values per joint of `Settings`; None: another type."""
    if kind == _STIFFNESS:
        return _spec("NUMBER|JOINTS=NUMBER,...", _number)
    if kind == _STRENGTH:
        return _spec("human|none|JOINTS=NUMBER,...", _word)
    if kind == _SOFT_SKIN:
        return _spec("yes|no", _yes)
    return None


def _yes(text: str) -> bool:
    if text not in ("yes", "no"):
        raise ValueError(f"found {text!r}, expected yes or no")
    return text == "yes"


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(
            f"found {text!r}, expected a number, or JOINTS=NUMBER, such as legs=0.2"
        ) from None


def _word(text: str) -> str | None:
    if text not in ("none", "None", "human"):
        raise ValueError(f"found {text!r}, expected human, none, or JOINTS=NUMBER, such as arms=40")
    return "human" if text == "human" else None


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


def _text(value: float | str | bool | SoftSkin | JointValues | None) -> str:
    if isinstance(value, bool | SoftSkin):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ",".join(f"{name}={number:g}" for name, number in value.items())
    return "none" if value is None else f"{value:g}" if isinstance(value, float) else str(value)

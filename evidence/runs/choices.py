"""Settings as JSON values, for tasks, and as Python code, for rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from halfphysics.baselines import from_options
from halfphysics.settings import AS_IT_IS, Settings

#: Options of settings that are not the default, see `halfphysics.baselines.from_options`.
Choice = dict[str, Any]
#: The paper's own setting, `Settings.paper()`; of Figures 4 and 9, Table 2: `Settings.paper(1.0)`.
LIMP: Choice = {"drive_time": None, "substeps": 8, "stiffness": 0.0, **AS_IT_IS}
FIRM: Choice = {**LIMP, "stiffness": 1.0}
#: Our drive, and nothing else that the paper has not: for the paper's figures.
OURS: Choice = dict(AS_IT_IS)
#: Options that are called otherwise as fields of settings.
FIELDS = {"torque_frequency": "frequency", "torque_damping": "damping"}


def said(choice: Mapping[str, Any]) -> str:
    """A choice as Python code."""
    kind = type(from_options(choice))
    name = "Settings" if kind is Settings else f"baselines.{kind.__name__}"
    values = {FIELDS.get(option, option): value for option, value in choice.items()}
    values.pop("mode", None)
    if all(choice.get(k, "") == v for k, v in LIMP.items() if k != "stiffness"):
        rest = {k: v for k, v in values.items() if k not in LIMP}
        words = [f"{choice['stiffness']:g}"] if choice["stiffness"] else []
        return f"{name}.paper({', '.join([*words, *_pairs(rest)])})"
    words = []
    if OURS.items() <= values.items():
        values = {k: v for k, v in values.items() if k not in OURS}
        words = ["**AS_IT_IS"]
    return f"{name}({', '.join([*_pairs(values), *words])})"


def _pairs(choice: Mapping[str, Any]) -> list[str]:
    return [f"{key}={value!r}" for key, value in choice.items()]

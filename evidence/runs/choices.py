"""Settings as JSON values, for tasks, and as Python code, for rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: Fields of `Settings` that are not the default.
Choice = dict[str, Any]
#: The paper's own setting, `Settings.paper()`; of Figures 4 and 9, Table 2: `Settings.paper(1.0)`.
LIMP: Choice = {"drive_time": None, "substeps": 8, "stiffness": 0.0}
FIRM: Choice = {**LIMP, "stiffness": 1.0}


def said(choice: Mapping[str, Any]) -> str:
    """A choice as Python code."""
    if all(choice.get(k, "") == v for k, v in LIMP.items() if k != "stiffness"):
        rest = {k: v for k, v in choice.items() if k not in LIMP}
        words = [f"{choice['stiffness']:g}"] if choice["stiffness"] else []
        return f"Settings.paper({', '.join([*words, *_pairs(rest)])})"
    return f"Settings({', '.join(_pairs(choice))})"


def _pairs(choice: Mapping[str, Any]) -> list[str]:
    return [f"{key}={value!r}" for key, value in choice.items()]

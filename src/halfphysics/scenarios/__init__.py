"""Authored stories: a motion, a scene and objects that bring each other to life.

A new scenario is one file with a function ``build(**options) -> Sequence`` whose keyword-only
options all have a default, and one line below.
"""

from __future__ import annotations

import importlib
import inspect
import re
import textwrap
from collections.abc import Callable
from typing import Any

from halfphysics.base.validation import frame_rate
from halfphysics.errors import InputError
from halfphysics.motion.resampling import MAX_FPS
from halfphysics.simulation.sequence import Sequence

__all__ = ["builder", "describe", "explain", "load", "names", "options"]

#: Scenario -> module of this package that builds it.
_NAMES = (
    "ball_on_cushion",
    "climb_onto_bed",
    "close_drawer",
    "close_laptop",
    "crawl_under_table",
    "doorway",
    "fly_with_ball",
    "grasp_glass",
    "jump_on_bed",
    "kick_ball",
    "leg_through_table",
    "lift_suitcase",
    "meet",
    "open_drawer",
    "open_laptop",
    "place_glass",
    "push_door",
    "reach_past_monitor",
    "shake_hands",
    "sit_on_bed",
    "sit_on_sofa",
    "squeeze_pillow",
    "step_back_onto_cabinet",
    "stretch_on_bed",
    "walk_into_wall",
)


def builder(name: str) -> Callable[..., Sequence]:
    """The function that builds a scenario; its docstring explains the options.

    Raises:
        InputError: An unknown name.
    """
    if name not in _NAMES:
        raise InputError(f"scenario: found {name!r}, expected one of {', '.join(names())}")
    build: Callable[..., Sequence] = importlib.import_module(f"{__name__}.stories.{name}").build
    return build


def names() -> tuple[str, ...]:
    """The names that `load` knows."""
    return _NAMES


def describe(name: str) -> str:
    """What happens in a scenario, one line.

    Raises:
        InputError: An unknown name.
    """
    return (inspect.getdoc(builder(name)) or "").splitlines()[0]


def explain(name: str) -> dict[str, str]:
    """What each option of a scenario means, for those that are explained.

    Raises:
        InputError: An unknown name.
    """
    text = inspect.getdoc(builder(name)) or ""
    section = re.search(r"^Args:\n((?:[ ]+.*\n?|\n)*)", text, re.MULTILINE)
    if section is None:
        return {}
    entries = re.split(r"^(\w+): ", textwrap.dedent(section[1]), flags=re.MULTILINE)[1:]
    said = (" ".join(meaning.split()) for meaning in entries[1::2])
    return dict(zip(entries[::2], said, strict=True))


def options(name: str) -> dict[str, Any]:
    """The options of a scenario and their defaults.

    Raises:
        InputError: An unknown name.
    """
    parameters = inspect.signature(builder(name)).parameters.values()
    return {parameter.name: parameter.default for parameter in parameters}


def load(name: str, **chosen: Any) -> Sequence:
    """Build a scenario: its motion, scene, body and settings.

    Args:
        name: One of `names()`.
        **chosen: Options of that scenario (see `options`), for example ``fps=60, mass=2.0``.

    Raises:
        InputError: An unknown name or option, or an impossible value of one.
    """
    build = builder(name)
    known = options(name)
    for option in chosen:
        if option not in known:
            raise InputError(
                f"scenario '{name}': unknown option '{option}', expected one of {', '.join(known)}"
            )
    if "fps" in chosen:
        chosen["fps"] = frame_rate(chosen["fps"], most=MAX_FPS)
    return build(**chosen)

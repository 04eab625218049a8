"""The tasks by name."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import shown
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.envs.task import Task

#: Name -> module of this package, and what it is about. The class has the task's name.
TASKS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "HandOver": ("hand_over", "a robot arm hands a person a cup"),
        "Corridor": ("corridor", "a robot passes a walking person in a corridor"),
        "HeldDoor": ("held_door", "a robot opens a door for a person and shuts it"),
    }
)


def names() -> tuple[str, ...]:
    """Names of the tasks."""
    return tuple(TASKS)


def task_class(name: str) -> type[Task]:
    """The class of a task.

    Raises:
        InputError: There is none of this name.
    """
    if not isinstance(name, str) or name not in TASKS:
        hint = (
            did_you_mean(name, list(TASKS), form=repr, otherwise=".")
            if isinstance(name, str)
            else "."
        )
        raise InputError(f"task: found {shown(name)}{hint} There are: {', '.join(TASKS)}")
    module = importlib.import_module(f"halfphysics.envs.{TASKS[name][0]}")
    found: type[Task] = getattr(module, name)
    return found

"""Goals: what a person is to do, until it is done.

A goal is a value: it can be given to many persons, many times. `task` begins it for one.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple, Protocol

from halfphysics.base.validation import shown
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.actors.person import Person


class Task(Protocol):
    """A goal under way."""

    def go_on(self, me: Person) -> bool:
        """Ask the person for what the goal needs in this frame; whether it is done.

        Where it cannot be done, `Person.give_up` ends it.
        """
        ...

    def end(self, me: Person) -> None:
        """Take back what was asked: it is done or given up, or another goal comes instead."""
        ...


class Goal(Protocol):
    """What a person is to do."""

    def task(self) -> Task:
        """Begin it."""
        ...


class GivenUp(NamedTuple):
    """A goal that was not reached.

    Attributes:
        goal: The goal.
        reason: Why, in a sentence.
    """

    goal: Goal
    reason: str


def checked_goals(goals: object) -> tuple[Goal, ...]:
    """Goals as a tuple.

    Raises:
        InputError: Something else, such as the class of a goal.
    """
    given = tuple(goals) if isinstance(goals, Iterable) else (goals,)
    for goal in given:
        if isinstance(goal, type) or not callable(getattr(goal, "task", None)):
            raise InputError(f"goals: expected goals such as WalkTo((1, 0)), found {shown(goal)}")
    return given

"""Goals: what a person is to do, until it is done.

A goal is a value: it can be given to many persons, many times. `task` begins it for one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from halfphysics.actors.person import Person


class Task(Protocol):
    """A goal under way."""

    def go_on(self, me: Person) -> bool:
        """Ask the person for what the goal needs in this frame; whether it is done."""
        ...

    def end(self, me: Person) -> None:
        """Take back what was asked: the goal is done, or another one comes instead."""
        ...


class Goal(Protocol):
    """What a person is to do."""

    def task(self) -> Task:
        """Begin it."""
        ...

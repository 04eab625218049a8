"""Goals: to look at something, and to wait."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from halfphysics.actors.reach_for import checked_target
from halfphysics.base.validation import number

if TYPE_CHECKING:
    from halfphysics.actors.person import Person, Target


@dataclass(frozen=True)
class LookAt:
    """Look at something for a time, as far as the neck turns.

    Attributes:
        target: A point (3,) [m], an object's name, or a person's index.
        seconds: How long [s].

    Raises:
        InputError: An impossible value.
    """

    target: Target
    seconds: float = 2.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "target", checked_target(self.target, "LookAt: target"))
        number(self.seconds, "LookAt: seconds", least=0.0, unit="s")

    def task(self) -> Waiting:
        return Waiting(self.seconds, self.target)


@dataclass(frozen=True)
class Wait:
    """Stand, or sit, for a time.

    Attributes:
        seconds: How long [s].

    Raises:
        InputError: Below 0, or no number.
    """

    seconds: float

    def __post_init__(self) -> None:
        number(self.seconds, "Wait: seconds", least=0.0, unit="s")

    def task(self) -> Waiting:
        return Waiting(self.seconds, None)


class Waiting:
    """`LookAt` or `Wait` under way."""

    def __init__(self, seconds: float, at: Target | None) -> None:
        self._left, self._at = seconds, at

    def go_on(self, me: Person) -> bool:
        me.look(self._at)
        self._left -= me.dt
        return self._left < 0.0

    def end(self, me: Person) -> None:
        me.look(None)

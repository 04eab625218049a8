"""Controls that show the values of a session, and post the values that the user sets.

Callbacks run in threads of viser. They only post commands; the playground's thread executes them
and shows the outcome with `Controls.follow`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from halfphysics.viewer import session as do

#: A slider is not updated for this long after its value was set by hand [s].
_HANDS_OFF = 0.8

LIVE = "Takes effect at once"
ANEW = "Starts from the beginning"


@dataclass(eq=False)
class _Control:
    """A handle of viser, the value to show, and the time when it was last set by hand [s]."""

    handle: Any
    value_of: Callable[[], Any]
    touched: float = -math.inf

    def __post_init__(self) -> None:
        self._shown = self.handle.value

    def follow(self, now: float) -> None:
        """Show the session's value, unless the control was set by hand a moment ago.

        A value set by hand is in the handle before its callback runs: a value that differs from
        the one shown last was set by hand.
        """
        value = self.handle.value
        both_nan = value != value and self._shown != self._shown
        if value != self._shown and not both_nan:
            self._shown, self.touched = value, now
        if now - self.touched > _HANDS_OFF:
            _show(self.handle, self.value_of())
            self._shown = self.handle.value


class Controls:
    """All controls of a panel that are bound to values of the session."""

    def __init__(self, post: Callable[[do.Command], None]) -> None:
        self.post = post
        self._bound: list[_Control] = []

    def bind(
        self,
        handle: Any,
        value_of: Callable[[], Any],
        command_for: Callable[[Any], do.Command],
    ) -> None:
        """Let a handle show `value_of()` and post `command_for(value)` when it is set by hand."""
        control = _Control(handle, value_of)
        self._bound.append(control)

        def moved(event: Any) -> None:
            if event.client_id is None:  # the program set the value, not the user
                return
            control.touched = time.monotonic()
            self.post(command_for(event.target.value))

        handle.on_update(moved)

    def forget(self, handles: Iterable[Any]) -> None:
        """Unbind handles before they are removed."""
        gone = list(handles)
        self._bound = [c for c in self._bound if not any(c.handle is h for h in gone)]

    def follow(self, now: float) -> None:
        """Show the session's values at the time `now` [s]."""
        for control in self._bound:
            control.follow(now)


def change(name: str) -> Callable[[Any], do.Command]:
    """The command that changes how the session plays, for a value."""
    return lambda value: do.Change(name, value)


def turn(name: str, item: str | None = None) -> Callable[[Any], do.Command]:
    """The command that sets a knob of the person or of an item, for a value."""
    return lambda value: do.Turn(name, value, item)


def write(handle: Any, text: str) -> None:
    """Put a text into a handle; nothing is sent if it is there already."""
    if handle.content != text:
        handle.content = text


def _show(handle: Any, value: Any) -> None:
    """Put a value into a control, clipped to its range."""
    if hasattr(handle, "min"):
        value = type(handle.value)(min(max(value, handle.min), handle.max))
    if handle.value != value:
        handle.value = value

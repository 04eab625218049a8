"""What a sweep runs on: anything that runs tasks somewhere and says how they ended."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from halfphysics.base.workers import Death

if TYPE_CHECKING:
    from halfphysics.sweep.run.work import Done, Task

__all__ = ["Death", "Engine"]


class Engine(Protocol):
    """Runs `work.do(folder, task)` in processes that may die.

    `slots`: how many tasks run at a time; the driver keeps up to twice as many handed over. A
    task of the kind "variants" is handed over because it may kill its process: it runs in a
    process that does nothing else before or after. An engine does not repeat what died.
    """

    slots: int

    def submit(self, task: Task) -> None:
        """Hand over a task; does not block."""

    def wait(self) -> list[tuple[Task, Done | Death]]:
        """How tasks ended, at least one; nothing only where none is under way."""

    def close(self) -> None:
        """End everything, what is under way included, within seconds."""

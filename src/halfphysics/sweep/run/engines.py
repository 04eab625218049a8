"""The interface of engines, which run the tasks of a sweep and report their outcomes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from halfphysics.base.workers import Death

if TYPE_CHECKING:
    from halfphysics.sweep.run.work import Done, Task

__all__ = ["Death", "Engine"]


class Engine(Protocol):
    """Runs `work.do(folder, task)` in processes that may die.

    `slots`: number of tasks that run at a time; the driver hands over up to twice as many. A task
    of the kind "variants" may kill its process: it runs in a process that runs no other task. An
    engine does not repeat a task whose process died.
    """

    slots: int

    def submit(self, task: Task) -> None:
        """Hand over a task; does not block."""

    def wait(self) -> list[tuple[Task, Done | Death]]:
        """Outcomes of at least one task; the list is empty only if no task is in progress."""

    def close(self) -> None:
        """End all processes within seconds, tasks in progress included."""

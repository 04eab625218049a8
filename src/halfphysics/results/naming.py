"""What the indices of a result's tables mean: names, and the time of frames."""

from __future__ import annotations

from dataclasses import dataclass

#: Columns of tables that are indices into `JOINT_NAMES`, and into `Result.names`; -1: none.
JOINT_COLUMNS, NAME_COLUMNS = ("part", "other_part"), ("other", "subject", "layer")


@dataclass(frozen=True)
class Naming:
    """Names and frame rate of the result that a table is of.

    Attributes:
        names: `Result.names`: statics, objects, people.
        people: Number of people, the last of them.
        fps: Frames per second.
    """

    names: tuple[str, ...]
    people: int
    fps: float

    @property
    def persons(self) -> tuple[str, ...]:
        """Names of the people."""
        return self.names[len(self.names) - self.people :]

"""`Verdict`: the values of the measures that were taken of a motion, and why others were not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from halfphysics.base.copying import FrozenMapping
from halfphysics.base.short_repr import short_repr
from halfphysics.metrics.measures import MEASURES, Measure


@dataclass(frozen=True, kw_only=True, eq=False)
class Verdict:
    """What the measures of `halfphysics.metrics.measures.MEASURES` say of a motion.

    Attributes:
        values: Key -> value; NaN where a measure has none (such as a stability error without any
            frame in contact).
        missing: Key -> why it was not taken: no scene, no truth, too few frames.
        frames: Number of frames.
        fps: Frames per second.
    """

    values: Mapping[str, float]
    missing: Mapping[str, str]
    frames: int
    fps: float

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("values", "missing"):
            object.__setattr__(self, name, FrozenMapping(dict(getattr(self, name))))

    def __getitem__(self, key: str) -> float:
        return self.values[key]

    def rows(self) -> Iterator[tuple[Measure, float]]:
        """The measures that were taken, with their values, in the order of tables."""
        for measure in MEASURES:
            if measure.key in self.values:
                yield measure, self.values[measure.key]

"""Options and records of a measurement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from statistics import median
from typing import TYPE_CHECKING, Any

from halfphysics.base.validation import number

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion

#: Name [unit] -> (ours, the peer's or None).
Checks = dict[str, tuple[float, float | None]]

#: Minimum duration of a timed run [s]; the work is repeated to reach it.
LEAST = 0.2


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of a measurement.

    Attributes:
        motion: A clip to play in the free cases beside the built-in walk, or None.
        motion_name: Name of the motion in the records.
        quick: Short clips, no repetition within a run: a test of function, not of speed.
        repeats: Timed runs of each side, after the untimed runs.

    Raises:
        InputError: `repeats` is not a whole number of at least 1.
    """

    motion: Motion | None = None
    motion_name: str = "motion"
    quick: bool = False
    repeats: int = 7

    def __post_init__(self) -> None:
        number(self.repeats, "repeats", least=1)

    @property
    def least(self) -> float:
        """Minimum duration of a timed run [s]."""
        return 0.0 if self.quick else LEAST

    def short(self, motion: Motion, frames: int = 20) -> Motion:
        """The motion, or only its first frames if `quick` is set."""
        return motion[:frames] if self.quick and len(motion) > frames else motion


@dataclass(frozen=True, kw_only=True)
class Record:
    """One row: a setting of a case.

    Attributes:
        case: Name of the case.
        setting: Name of the setting.
        frames: Number of frames of one pass.
        unit: Unit of `ours`, `parts` and `peer`: "frames/s", or "s" for a whole pass.
        ours: Our figures, one per timed run.
        parts: Ours with ``contact="parts"``, run by run in turns; None for cases without a person.
        peer: The peer's figures, run by run in turns with ours; None without a peer.
        checks: Name [unit] -> (ours, the peer's or None): quality of the result.
    """

    case: str
    setting: str
    frames: int
    unit: str = "frames/s"
    ours: tuple[float, ...]
    parts: tuple[float, ...] | None = None
    peer: tuple[float, ...] | None = None
    checks: Mapping[str, tuple[float, float | None]] = field(default_factory=dict)

    @property
    def middle(self) -> float:
        """Median of `ours`."""
        return median(self.ours)

    @property
    def parts_middle(self) -> float | None:
        """Median of `parts`."""
        return None if self.parts is None else median(self.parts)

    @property
    def peer_middle(self) -> float | None:
        """Median of `peer`."""
        return None if self.peer is None else median(self.peer)

    @property
    def parts_ratio(self) -> float | None:
        """Median over the runs of the ratio of ours to the rigid parts' in the same turn."""
        return self._over(self.parts)

    @property
    def ratio(self) -> float | None:
        """Median over the runs of ours / the peer's in the same turn; above 1, ours is faster."""
        return self._over(self.peer)

    def _over(self, other: tuple[float, ...] | None) -> float | None:
        if other is None:
            return None
        return median(a / b for a, b in zip(self.ours, other, strict=True))

    def to_dict(self) -> dict[str, Any]:
        """The record as plain values, for JSON."""
        return {
            "case": self.case,
            "setting": self.setting,
            "frames": self.frames,
            "unit": self.unit,
            "ours": list(self.ours),
            "parts": None if self.parts is None else list(self.parts),
            "peer": None if self.peer is None else list(self.peer),
            "median": self.middle,
            "parts_median": self.parts_middle,
            "parts_ratio": self.parts_ratio,
            "peer_median": self.peer_middle,
            "ratio": self.ratio,
            "checks": {name: list(values) for name, values in self.checks.items()},
        }

"""What the numbers of observations and actions mean: name, unit, range; as spaces and as tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.optional_package import optional
from halfphysics.base.validation import shown
from halfphysics.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Channel:
    """Some numbers of one meaning.

    Attributes:
        meaning: In plain words.
        unit: "m", "rad/s", ...; "" for a number without.
        low, high: Range, in the unit: what is beyond is cut off.
        parts: Names of the numbers, such as ("x", "y", "z"); one name: one number.
    """

    meaning: str
    unit: str
    low: float
    high: float
    parts: tuple[str, ...] = ("",)


XYZ = ("x", "y", "z")
XY = ("x", "y")
COS_SIN = ("cos", "sin")


class Layout:
    """Channels one after the other: a vector of `size` numbers."""

    def __init__(self, *channels: Channel) -> None:
        self.channels = channels
        counts = [len(c.parts) for c in channels]
        self.size = sum(counts)
        self.low = np.repeat([c.low for c in channels], counts)
        self.high = np.repeat([c.high for c in channels], counts)

    def cut(self, *columns: Array) -> NDArray[np.float32]:
        """Numbers (N, size) from columns (N,) or (N, k), in the channels' order, within their
        ranges."""
        joined = np.concatenate([c if c.ndim == 2 else c[:, None] for c in columns], axis=1)
        out: NDArray[np.float32] = np.clip(joined, self.low, self.high).astype(np.float32)
        return out

    def checked(self, values: Any) -> Array:
        """Actions (N, size) within their ranges; what is not finite counts as 0."""
        given = np.asarray(values, dtype=np.float64)
        return np.clip(np.where(np.isfinite(given), given, 0.0), self.low, self.high)

    def space(self, seed: int | None = None) -> Any:
        """A `gymnasium.spaces.Box`."""
        spaces = optional("gymnasium.spaces", "environments", "rl")
        low, high = self.low.astype(np.float32), self.high.astype(np.float32)
        return spaces.Box(low, high, dtype=np.float32, seed=seed)

    def table(self) -> str:
        """The channels as rows of a Markdown table: index, meaning, unit, range."""
        lines = ["| index | meaning | unit | range |", "|---|---|---|---|"]
        at = 0
        for c in self.channels:
            end = at + len(c.parts) - 1
            index = str(at) if end == at else f"{at} to {end}"
            names = f" ({', '.join(c.parts)})" if len(c.parts) > 1 else ""
            lines.append(
                f"| {index} | {c.meaning}{names} | {c.unit or '1'} | {c.low:g} to {c.high:g} |"
            )
            at = end + 1
        return "\n".join(lines)


def checked_actions(actions: Any, shape: tuple[int, ...], what: str = "step: action") -> Array:
    """Actions as an array; what is finite but out of range is cut off later (`Layout.checked`).

    Args:
        actions: As somebody gave them.
        shape: Theirs.
        what: They are, for the error.

    Raises:
        InputError: Another shape, or what is no finite number.
    """
    try:
        given = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != shape:
        raise InputError(f"{what}: found {shown(actions)}, expected numbers of shape {shape}")
    if not np.isfinite(given).all():
        raise InputError(f"{what}: found {shown(actions)}, expected finite numbers")
    return given

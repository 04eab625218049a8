"""Checks of the fields of a configuration dataclass, with the field's name in each message."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from halfphysics.base.arrays import scalar_of
from halfphysics.base.validation import is_whole, real, shown, within
from halfphysics.errors import InputError

#: The most of anything that is counted: far beyond use, and what the core can count.
MOST_COUNT = 1_000_000


class FieldChecks:
    """Checks fields of `owner`; each raises "Class.field is VALUE; expected ..." (`InputError`)."""

    def __init__(self, owner: object) -> None:
        self._owner = owner

    def plain(self) -> None:
        """Replace numbers of numpy and of tensors, which files cannot hold, by Python's own."""
        for name, value in list(vars(self._owner).items()):
            if isinstance(value, np.generic):
                object.__setattr__(self._owner, name, value.item())
            elif not isinstance(value, int | float | str | None):
                object.__setattr__(self._owner, name, scalar_of(value))

    def holds(self, name: str, ok: bool, expected: str) -> None:
        """Raise unless `ok`."""
        if not ok:
            kind, value = type(self._owner).__name__, self._value(name)
            raise InputError(f"{kind}.{name} is {shown(value)}; expected {expected}")

    def number(
        self,
        name: str,
        *,
        above: float | None = None,
        least: float | None = None,
        most: float = math.inf,
        why: str = "",
    ) -> None:
        """A finite int or float above `above` or from `least` to `most`; `why` explains `most`."""
        limit = f"> {above}" if above is not None else f">= {least}"
        limit += f" and <= {most}{why}" if most < math.inf else ""
        value = real(self._value(name), plain=True)
        ok = value is not None and within(value, above=above, least=least, most=most)
        self.holds(name, ok, f"a finite number {limit}")

    def count(self, name: str) -> None:
        """An int from 1 to `MOST_COUNT`."""
        value = self._value(name)
        ok = is_whole(value, least=1) and value <= MOST_COUNT
        self.holds(name, ok, f"a whole number >= 1, at most {MOST_COUNT:,}")

    def flag(self, name: str) -> None:
        """True or False."""
        self.holds(name, isinstance(self._value(name), bool), "True or False")

    def choice(self, name: str, *values: str) -> None:
        """One of the values."""
        value = self._value(name)
        ok = isinstance(value, str) and value in values
        self.holds(name, ok, " or ".join(repr(v) for v in values))

    def _value(self, name: str) -> Any:
        return getattr(self._owner, name)

"""One line for an object that holds arrays: its numbers, and the sizes of the rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Letters of a line; fields beyond are left out.
MOST = 160
#: Letters of the value of one field.
_EACH = 60
#: Entries of a tuple or a mapping that are shown.
_FEW = 3


def short_repr(self: Any) -> str:
    """The `__repr__` of a dataclass in one line: arrays by shape, long collections by size.

    Fields that are None or as by default are left out.
    """
    parts: list[str] = []
    left = MOST
    for field in dataclasses.fields(self):
        if not field.repr or field.name.startswith("_"):
            continue
        value = getattr(self, field.name)
        if value is None or (value is field.default and not isinstance(value, int | float)):
            continue
        part = f"{field.name}={value_repr(value)}"
        left -= len(part) + 2
        if left < 0:
            parts.append("...")
            break
        parts.append(part)
    return f"{type(self).__name__}({', '.join(parts)})"


def changed_repr(self: Any) -> str:
    """The `__repr__` of a configuration: the fields that differ from their defaults, in full."""
    usual = type(self)()
    names = [field.name for field in dataclasses.fields(self)]
    changed = [n for n in names if getattr(self, n) != getattr(usual, n)]
    return f"{type(self).__name__}({', '.join(f'{n}={getattr(self, n)!r}' for n in changed)})"


def counted(count: int, one: str, several: str | None = None) -> str:
    """The number with its noun: "1 person", "2 people"."""
    return f"{count:,} {one if count == 1 else several or one + 's'}"


def frames_repr(frames: NDArray[np.int64]) -> str:
    """The range of some frames, at least one: "frame 3", "frames 3 to 8"."""
    first, last = frames.min(), frames.max()
    return f"frame {first}" if first == last else f"frames {first} to {last}"


def numbers(values: Any, digits: int = 2) -> str:
    """A short vector such as "(1.00, -0.30, 0.95)"."""
    rounded = [round(v, digits) + 0.0 for v in np.asarray(values).tolist()]
    return f"({', '.join(f'{v:.{digits}f}' for v in rounded)})"


def value_repr(value: Any) -> str:
    """A value in a few words: arrays by shape, long collections by size."""
    if isinstance(value, np.ndarray):
        return f"array{value.shape}".replace(",)", ")") if value.ndim else f"{value:.6g}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping) and (len(value) > _FEW or _long(value)):
        return f"{{{counted(len(value), 'entry', 'entries')}}}"
    if isinstance(value, tuple | list) and (len(value) > _FEW or _long(value)):
        return f"({counted(len(value), 'entry', 'entries')})"
    return f"{type(value).__name__}(...)" if _long(value) else repr(value)


def _long(value: Any) -> bool:
    text = repr(value)
    return len(text) > _EACH or "\n" in text

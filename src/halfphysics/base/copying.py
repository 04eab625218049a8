"""Copies and pickles: mappings and arrays stay read-only in them, or they are refused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NoReturn, TypeVar

import numpy as np

from halfphysics.base.short_repr import value_repr

K = TypeVar("K")
V = TypeVar("V")


class FrozenMapping(Mapping[K, V]):
    """A mapping that never changes, in the order it was given.

    What `types.MappingProxyType` is, which cannot be copied or sent to another process.
    """

    __slots__ = ("_items",)
    _items: dict[K, V]

    def __init__(self, items: Mapping[K, V]) -> None:
        object.__setattr__(self, "_items", dict(items))

    def __getitem__(self, key: K) -> V:
        return self._items[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __or__(self, other: Mapping[K, V]) -> dict[K, V]:
        return {**self._items, **other}

    def __ror__(self, other: Mapping[K, V]) -> dict[K, V]:
        return {**other, **self._items}

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} never changes")

    def __repr__(self) -> str:
        entries = (f"{key!r}: {value_repr(value)}" for key, value in self._items.items())
        return f"{{{', '.join(entries)}}}"

    def __getstate__(self) -> dict[K, V]:
        return self._items

    def __setstate__(self, items: dict[K, V]) -> None:
        object.__setattr__(self, "_items", items)
        freeze(items)


class ReadOnly:
    """Base of classes whose arrays are read-only: so they are in copies.

    numpy gives back writeable arrays, whatever was copied or pickled.
    """

    #: Cached properties that cannot leave the process: they are computed again when asked for.
    _REBUILT: ClassVar[frozenset[str]] = frozenset()

    def __getstate__(self) -> dict[str, Any]:
        return {name: v for name, v in vars(self).items() if name not in self._REBUILT}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        freeze(state)


class Bound:
    """Base of what lives in this process alone: copies and pickles are refused in one sentence."""

    #: Why, and what to do instead; follows "it cannot be copied or sent to another process:".
    _WHY: ClassVar[str]

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        name = type(self).__name__
        raise TypeError(f"{name}: it cannot be copied or sent to another process: {self._WHY}")


def freeze(value: Any) -> None:
    """Make the arrays in a value read-only, in plain containers too."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, dict):
        for one in value.values():
            freeze(one)
    elif isinstance(value, list | tuple):
        for one in value:
            freeze(one)

"""A bounded cache that keeps the most recently used values."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

T = TypeVar("T")


class Kept(Generic[T]):
    """The values of the `most` keys used last; the least recently used value is dropped first.

    A caller that uses the `id` of an object as key must keep that object in the value: Python
    reuses the id of a deleted object.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._made: OrderedDict[Hashable, T] = OrderedDict()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """The value of a key, made by `make` if it is missing; nothing is kept if `make` raises."""
        if key in self._made:
            self._made.move_to_end(key)
            return self._made[key]
        value = self._made[key] = make()
        while len(self._made) > self._most:
            self._made.popitem(last=False)
        return value

    def __len__(self) -> int:
        return len(self._made)

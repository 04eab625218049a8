"""A bounded store of what was made: the last few, and no more."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

T = TypeVar("T")


class Kept(Generic[T]):
    """What was made for the last `most` keys asked for; the least recently asked goes first.

    A caller that keys by the `id` of an object must hold that object in the value made: an id is
    taken again once its owner has gone.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._made: OrderedDict[Hashable, T] = OrderedDict()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """What is kept under a key, or else what `make` makes; nothing is kept if it raises."""
        if key in self._made:
            self._made.move_to_end(key)
            return self._made[key]
        value = self._made[key] = make()
        while len(self._made) > self._most:
            self._made.popitem(last=False)
        return value

    def __len__(self) -> int:
        return len(self._made)

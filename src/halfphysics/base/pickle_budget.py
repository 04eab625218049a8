"""What a pickle of a stranger may cost: memory, operations, keys, and what comes of it unfolded.

A pickle may name a large object again and again for a few bytes each: copies of it (`list(x)`,
`encode(x)`), keys whose hash walks down all ways into it, lists of lists of it that some reader
unfolds into one array. Every cost here is therefore counted against the size of the file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np

#: Bytes that stand-ins may make, and into which the content may unfold: a fixed allowance, and a
#: multiple of the file's size. Data sets store each number once or twice.
FREE_BYTES, BYTES_PER_BYTE = 2**27, 4
#: Operations likewise: an operation puts an object of 50 bytes or more on the stack and takes half
#: a microsecond. Lists of numbers have one in 9 bytes, files of long videos one in 30.
FREE_OPERATIONS, OPERATIONS_PER_BYTE = 2_000_000, 0.25
#: Keys whose hashes a file can choose (large numbers, fractions, tuples) are compared pair by pair
#: where they are equal: a second for so many, of so many parts.
MOST_CHOSEN_KEYS, MOST_PARTS = 4_000, 16
#: Calls that make an object of each letter, byte or row of their argument: bytes of one, and of its
#: place. Letters beyond Latin-1 are made each time; rows of arrays are arrays.
_TAKEN_APART = (list, tuple, set, frozenset)
_EACH = {str: 96, bytes: 8, bytearray: 8, np.ndarray: 128}
#: Hashes of whole numbers below are the numbers themselves.
_OWN_HASH = 2**61 - 1


class TooCostly(Exception):
    """The pickle costs more than a file of its size should; the text says what."""


class Budget:
    """Counts the costs of one file.

    Args:
        size: Bytes of the file, unpacked.
        on_disk: Bytes of the file as it is on the disk.
    """

    def __init__(self, size: int, on_disk: int) -> None:
        self.bytes = self.unfolded = FREE_BYTES + BYTES_PER_BYTE * size
        self.operations = FREE_OPERATIONS + int(OPERATIONS_PER_BYTE * on_disk)
        self.keys = MOST_CHOSEN_KEYS

    def spend(self, count: int) -> None:
        """Count bytes that are made."""
        self.bytes -= count
        if self.bytes < 0:
            raise TooCostly("its objects are copied into far more memory than the file is long")

    def call(self, function: Any, arguments: Any) -> None:
        """Count a call before it is made."""
        for argument in arguments:
            if function in _TAKEN_APART:
                self.spend(_apart(argument))
            if isinstance(argument, (str, bytes, bytearray)):
                self.spend(len(argument))
            elif isinstance(argument, np.ndarray):
                self.spend(argument.nbytes)
            elif isinstance(argument, (list, tuple, set, frozenset, dict)):
                self.spend(8 * len(argument))
        if function in (set, frozenset) and arguments:
            self.check_keys(arguments[0])
        elif function is dict and arguments:
            self.check_keys(_names(arguments[0]))

    def check_keys(self, keys: Any) -> None:
        """Refuse keys of dicts and members of sets that take long to hash or to compare."""
        for key in keys:
            if isinstance(key, (str, bytes)) or key is None:
                continue
            if isinstance(key, int) and -_OWN_HASH < key < _OWN_HASH:
                continue
            self.keys -= 1
            if self.keys < 0:
                raise TooCostly(f"more than {MOST_CHOSEN_KEYS} keys that are no text")
            parts = [key]
            for count, part in enumerate(parts):
                if count > MOST_PARTS:
                    raise TooCostly(f"a key of more than {MOST_PARTS} parts")
                if isinstance(part, (tuple, frozenset)):
                    parts += list(part)[: MOST_PARTS + 1]


def _apart(argument: Any) -> int:
    """Bytes of the objects that a call makes of each letter, byte or row of its argument."""
    each = next((size for kind, size in _EACH.items() if isinstance(argument, kind)), 0)
    whole = isinstance(argument, np.ndarray) and argument.ndim == 0  # cannot be taken apart
    return 0 if whole or not each else each * len(argument)


def _names(pairs: Any) -> Any:
    """The keys in the argument of `dict`: another dict, or pairs."""
    if isinstance(pairs, dict):
        return pairs
    fine = isinstance(pairs, (list, tuple)) and all(
        isinstance(pair, (list, tuple)) and len(pair) == 2 for pair in pairs
    )
    if not fine:
        raise TooCostly("a dict that is not made of pairs")
    return [pair[0] for pair in pairs]


_current: ContextVar[Budget | None] = ContextVar("budget", default=None)


def current() -> Budget | None:
    """The budget of the file that is being read; None: none is."""
    return _current.get()


@contextmanager
def counted(budget: Budget) -> Iterator[None]:
    """`spend` counts against this budget in the block."""
    before = _current.set(budget)
    try:
        yield
    finally:
        _current.reset(before)


def spend(count: int) -> None:
    """Count bytes that a stand-in is about to make."""
    budget = _current.get()
    if budget is not None:
        budget.spend(count)


def check_unfolded(root: Any, most: int) -> None:
    """Refuse what contains itself, and what is more than `most` bytes once it is unfolded.

    numpy makes one array of a list of lists: every list counts as often as it is named, and every
    text as long as the longest beside it.
    """
    known: dict[int, tuple[int, int, int]] = {}

    def of(value: Any) -> tuple[int, int, int]:
        """Bytes, number of leaves, longest text."""
        if isinstance(value, str):
            return 4 * len(value), 1, len(value)
        if isinstance(value, (bytes, bytearray)):
            return len(value), 1, len(value)
        if isinstance(value, np.ndarray) and not value.dtype.hasobject:
            return value.nbytes, 1, 0
        if not isinstance(value, (list, tuple, dict, set, frozenset, np.ndarray)):
            return 8, 1, 0
        if id(value) in known:
            if known[id(value)][0] < 0:
                raise TooCostly("an object that contains itself")
            return known[id(value)]
        known[id(value)] = (-1, 0, 0)
        known[id(value)] = found = _sum(value, of)
        if found[0] > most:
            raise TooCostly("its lists name each other until they are far longer than the file")
        return found

    of(root)


def _sum(value: Any, of: Callable[[Any], tuple[int, int, int]]) -> tuple[int, int, int]:
    if isinstance(value, np.ndarray):
        value = value.reshape(-1).tolist()
    items = value.values() if isinstance(value, dict) else value
    size = leaves = longest = 0
    for item in items:
        own = of(item)
        size, leaves, longest = size + own[0], leaves + own[1], max(longest, own[2])
    if isinstance(value, dict):
        return size, 1, 0
    return max(size, 4 * longest * leaves), leaves, longest

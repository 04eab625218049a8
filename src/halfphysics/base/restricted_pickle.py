"""Reads pickles of untrusted files: data comes out, nothing is run.

A pickle is a program: it names any function of any module and calls it. Here it may name only what
`pickle_placeholders` answers: with functions and classes that build numpy arrays, numbers, strings
and containers, or with the plain containers themselves. Every other name is refused before the
named object is looked up. Sparse matrices of scipy and arrays of chumpy become
numpy arrays without importing either.

It builds on the interpreter's own pure-Python unpickler, whose table of operations can be cut; the
C one trusts sizes written in the file (a 20-byte file can ask it for gigabytes).
"""

from __future__ import annotations

import io
import os
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from halfphysics.base.pickle_budget import Budget, TooCostly, check_unfolded, counted, current
from halfphysics.base.pickle_placeholders import (
    MAX_BYTES,
    InLineArray,
    Placeholder,
    Refused,
    global_of,
)
from halfphysics.errors import FileError

# Arrays of objects in a joblib dump are pickles of their own, which may hold such arrays again.
_MAX_DEPTH = 8


@dataclass(frozen=True, kw_only=True)
class Guests:
    """Additional names of a format that is built on pickles (torch).

    `globals` holds our stand-ins for the format's functions and classes, by module and name;
    `persistent` returns the data of a persistent object.
    """

    globals: Mapping[str, Mapping[str, Any]]
    persistent: Callable[[Any], Any]


_PythonUnpickler: Any = pickle._Unpickler


class _Unpickler(_PythonUnpickler):  # type: ignore[misc]
    """The interpreter's unpickler, cut down to data."""

    dispatch: ClassVar[dict[int, Any]] = dict(_PythonUnpickler.dispatch)

    def __init__(
        self, stream: io.BytesIO, budget: Budget, guests: Guests | None = None, depth: int = 0
    ) -> None:
        if depth > _MAX_DEPTH:
            raise ValueError("pickles within pickles")
        super().__init__(stream, encoding="latin1")
        # `load` looks every operation up in it.
        self.dispatch = _Metered(type(self).dispatch, budget)  # type: ignore[assignment,misc]
        self._budget = budget
        self._stream = stream
        self._guests = guests
        self._depth = depth

    def find_class(self, module: str, name: str) -> Any:
        guests = {} if self._guests is None else self._guests.globals.get(module, {})
        known = guests[name] if name in guests else global_of(module, name)
        if known is None:
            raise Refused(f"{module}.{name}")
        return known

    def persistent_load(self, pid: Any) -> Any:
        if self._guests is None:
            raise Refused("a persistent object")
        return self._guests.persistent(pid)

    def get_extension(self, code: int) -> None:
        raise Refused(f"the registered extension {code}")

    def load_build(self) -> None:
        # Only on placeholders: the original sets attributes on anything, classes included.
        state = self.stack.pop()
        target = self.stack[-1]
        if not isinstance(target, Placeholder):
            raise Refused(f"setting the state of {type(target).__name__}")
        target.__setstate__(state)
        if isinstance(target, InLineArray):
            target.read(self._stream, self._nested)

    def _nested(self, stream: io.BytesIO) -> Any:
        return _Unpickler(stream, self._budget, self._guests, self._depth + 1).load()

    # Calls and keys, which may cost more than the bytes that ask for them.

    def load_reduce(self) -> None:
        arguments = self.stack.pop()
        self._budget.call(self.stack[-1], arguments)
        self.stack[-1] = self.stack[-1](*arguments)

    def load_newobj(self) -> None:
        arguments = self.stack.pop()
        kind = self.stack.pop()
        self._budget.call(kind, arguments)
        self.append(kind.__new__(kind, *arguments))

    def load_newobj_ex(self) -> None:
        named = self.stack.pop()
        if named:
            raise Refused("an object with named arguments")
        self.load_newobj()

    def _instantiate(self, kind: Any, arguments: Any) -> None:
        self._budget.call(kind, arguments)
        super()._instantiate(kind, arguments)

    def load_setitem(self) -> None:
        self._budget.check_keys(self.stack[-2:-1])
        super().load_setitem()

    def load_setitems(self) -> None:
        self._budget.check_keys(self.stack[::2])
        super().load_setitems()

    def load_additems(self) -> None:
        self._budget.check_keys(self.stack)
        super().load_additems()

    def load_frozenset(self) -> None:
        self._budget.check_keys(self.stack)
        super().load_frozenset()

    def load_dict(self) -> None:
        self._budget.check_keys(self.stack[::2])
        super().load_dict()

    def load_bytearray8(self) -> None:
        # The original allocates the size that the file claims before it reads.
        size = int.from_bytes(self.read(8), "little")
        self.append(bytearray(self.read(size)))

    dispatch[pickle.BUILD[0]] = load_build
    dispatch[pickle.BYTEARRAY8[0]] = load_bytearray8
    dispatch[pickle.REDUCE[0]] = load_reduce
    dispatch[pickle.NEWOBJ[0]] = load_newobj
    dispatch[pickle.NEWOBJ_EX[0]] = load_newobj_ex
    dispatch[pickle.SETITEM[0]] = load_setitem
    dispatch[pickle.SETITEMS[0]] = load_setitems
    dispatch[pickle.ADDITEMS[0]] = load_additems
    dispatch[pickle.FROZENSET[0]] = load_frozenset
    dispatch[pickle.DICT[0]] = load_dict


class _Metered:
    """The table of operations; each look-up is one operation of the budget."""

    def __init__(self, table: dict[int, Any], budget: Budget) -> None:
        self._table, self._budget = table, budget

    def __getitem__(self, code: int) -> Any:
        self._budget.operations -= 1
        if self._budget.operations < 0:
            raise TooCostly("it has far more operations than data")
        return self._table[code]


def _settled(root: Any) -> Any:
    """`root` with every placeholder in it replaced by its value, shared objects kept shared."""
    done: dict[int, Any] = {}
    alive: list[Any] = []  # ids stay unique only while their objects live
    busy = object()

    def settle(value: Any) -> Any:
        if not isinstance(value, (dict, list, tuple, set, frozenset, Placeholder)):
            if callable(value):
                raise Refused("a class or function in place of data")
            return value
        key = id(value)
        if key in done:
            if done[key] is busy:
                raise TooCostly("an object that contains itself")
            return done[key]
        alive.append(value)
        # Lists and dicts are filled in place, so that they may contain themselves.
        done[key] = value if isinstance(value, (dict, list)) else busy
        if isinstance(value, Placeholder):
            done[key] = value.resolve(settle)
        elif isinstance(value, dict):
            for name in value:
                value[plain(name)] = settle(value[name])
        elif isinstance(value, list):
            value[:] = [settle(item) for item in value]
        elif isinstance(value, tuple):
            done[key] = tuple(settle(item) for item in value)
        else:
            done[key] = type(value)(plain(item) for item in value)
        return done[key]

    def plain(value: Any) -> Any:
        """Keys and members of sets: numbers, strings, tuples."""
        if isinstance(value, Placeholder) or callable(value):
            raise Refused(f"{type(value).__name__} as a key")
        if isinstance(value, (tuple, frozenset)):
            for item in value:
                plain(item)
        return value

    return settle(root)


def loads(
    data: bytes,
    name: str | os.PathLike[str] = "pickle",
    guests: Guests | None = None,
    *,
    on_disk: int | None = None,
) -> Any:
    """The data of a pickle in memory; messages call it `name`.

    Args:
        data: The pickle.
        name: The file, for messages.
        guests: Additional names of a format that is built on pickles.
        on_disk: Bytes of the file on the disk, if they are others than `data`: what the pickle may
            cost is measured against them.

    Raises:
        FileError: It holds or calls anything but data, is damaged or truncated, or costs far more
            than a file of its size should.
    """
    on_disk = len(data) if on_disk is None else on_disk
    budget = Budget(max(len(data), on_disk), on_disk)
    return load_from(io.BytesIO(data), name, guests, budget)


def load_from(
    stream: io.BytesIO,
    name: str | os.PathLike[str] = "pickle",
    guests: Guests | None = None,
    budget: Budget | None = None,
) -> Any:
    """The data of the next pickle in a stream, which is left right behind it; as `loads`.

    `budget`: what it may cost; None: within another pickle what is left of that one's, else what a
    file of the stream's size may.
    """
    budget = budget or current()
    if budget is None:
        size = stream.getbuffer().nbytes
        budget = Budget(size, size)
    try:
        with counted(budget):
            root = _settled(_Unpickler(stream, budget, guests).load())
        check_unfolded(root, budget.unfolded)
        return root
    except TooCostly as costly:
        raise FileError(
            f"{name}: {costly}; expected data that is about as large as its file. Nobody's motion "
            "is stored so: do not trust it, or save its arrays as .npz"
        ) from None
    except Refused as refused:
        raise FileError(
            f"{name}: unsafe or unknown content: the pickle names {refused}. Read are only numpy "
            "arrays, numbers, strings, containers, scipy.sparse matrices and chumpy arrays; "
            "nothing was run. If you trust the file, save its arrays as .npz"
        ) from None
    except (RecursionError, MemoryError) as error:
        raise FileError(f"{name}: nested too deeply or too large ({error!r})") from None
    except Exception as error:  # a damaged pickle can fail in any way that Python knows
        raise FileError(
            f"{name}: not a readable pickle ({type(error).__name__}: {str(error)[:200]}). Is it "
            "truncated? Download or copy the file again"
        ) from None


def load(path: str | os.PathLike[str]) -> Any:
    """The data of a pickle file.

    Returns:
        Numbers, strings, bytes, numpy arrays (also for scipy.sparse and chumpy), and lists,
        tuples, sets and dicts of those.

    Raises:
        FileError: The file cannot be read, is larger than `MAX_BYTES`, holds or calls anything
            but data, or is damaged.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise FileError(
                f"{path}: {size / 2**30:.1f} GiB, expected at most {MAX_BYTES / 2**30:.0f} GiB "
                "in one pickle"
            )
        data = path.read_bytes()
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    return loads(data, path)

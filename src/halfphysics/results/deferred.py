"""A dataclass field that is loaded on first access."""

from __future__ import annotations

from typing import Any, Generic, Protocol, TypeVar

from halfphysics.base.validation import shown
from halfphysics.errors import InputError

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Record(Protocol[T_co]):
    """A reference to a value in another file; `make` loads it (once)."""

    def make(self) -> T_co: ...


class Deferred(Generic[T]):
    """A dataclass field that holds a value, or a `Record` that loads it on first access.

    So a thousand results can be read without loading the meshes to which they refer.
    """

    def __set_name__(self, owner: type, name: str) -> None:
        self._key = f"_{name}"

    def __get__(self, instance: Any, owner: type | None = None) -> T:
        if instance is None:
            raise AttributeError("a field without a default")  # as dataclasses require
        held = vars(instance)[self._key]
        result: T = held.make() if hasattr(held, "make") else held
        return result

    def __set__(self, instance: Any, value: T | Record[T]) -> None:
        vars(instance)[self._key] = value


def typed(name: str, value: Any, kind: type) -> None:
    """Refuse a value that is not of a type."""
    if not isinstance(value, kind):
        raise InputError(f"{name}: found {shown(value)}, expected a halfphysics {kind.__name__}")


def typed_or_deferred(name: str, held: Any, kind: type) -> None:
    """Refuse a value that is neither of a type nor a `Record` of one."""
    if not hasattr(held, "make"):
        typed(name, held, kind)

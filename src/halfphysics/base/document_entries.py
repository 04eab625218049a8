"""Values of a document's entries, each mistake with its place in the file (a `FileError`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from halfphysics.base.document_tree import Entry
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import real, shown, within
from halfphysics.errors import HalfPhysicsError

T = TypeVar("T")
Read = Callable[[Entry], Any]


def guarded(entry: Entry, make: Callable[..., T], *args: Any) -> T:
    """make(*args); the place in the file is put before the message of an error."""
    try:
        return make(*args)
    except HalfPhysicsError as error:
        raise entry.error(str(error)) from error


def mapping(entry: Entry, allowed: tuple[str, ...], suffix: str = "") -> dict[str, Entry]:
    """A mapping with only the allowed keys; `suffix` names their owner in messages."""
    if not isinstance(entry.value, dict):
        raise entry.error(f"expected a mapping with {', '.join(allowed)}, found {describe(entry)}")
    for key, child in entry.value.items():
        if key not in allowed:
            hint = did_you_mean(key, allowed, otherwise=".")
            raise child.error(f"unknown key {key!r}{suffix}{hint} Allowed: {', '.join(allowed)}")
    return entry.value


def named_entries(entry: Entry, of: str) -> dict[str, Entry]:
    """A mapping with keys of any name; `of` describes its keys and values in messages."""
    if not isinstance(entry.value, dict):
        raise entry.error(f"expected a mapping ({of}), found {describe(entry)}")
    return entry.value


def items(entry: Entry | None) -> list[Entry]:
    """A list; a missing entry is an empty one."""
    if entry is None or entry.value is None:
        return []
    if not isinstance(entry.value, list):
        raise entry.error(f"expected a list, found {describe(entry)}")
    return entry.value


def sequence(entry: Entry, size: int, form: str) -> list[Entry]:
    """A list of `size` entries; `form` describes it in messages."""
    if not isinstance(entry.value, list) or len(entry.value) != size:
        raise entry.error(f"expected {form}, found {describe(entry)}")
    return entry.value


def number(entry: Entry) -> float:
    """A finite number."""
    value = real(entry.value, plain=True)
    if value is None:
        raise entry.error(f"expected a number, found {describe(entry)}")
    if not within(value):
        raise entry.error(f"expected a finite number, found {shown(entry.value)}")
    return value


def vector(size: int) -> Read:
    """A reader of lists of `size` finite numbers."""
    return lambda entry: [
        number(child) for child in sequence(entry, size, f"a list of {size} numbers")
    ]


def text(entry: Entry) -> str:
    """Text that is not empty."""
    if not isinstance(entry.value, str) or not entry.value:
        raise entry.error(f"expected text, found {describe(entry)}")
    return entry.value


def flag(entry: Entry) -> bool:
    """True or false."""
    if not isinstance(entry.value, bool):
        raise entry.error(f"expected true or false, found {describe(entry)}")
    return entry.value


def choice(entry: Entry, options: tuple[str, ...]) -> str:
    """One of the options."""
    if entry.value not in options:
        hint = did_you_mean(entry.value, options)
        raise entry.error(f"expected one of {', '.join(options)}, found {describe(entry)}{hint}")
    result: str = entry.value
    return result


def describe(entry: Entry) -> str:
    """The entry's value, for a message."""
    if isinstance(entry.value, dict):
        return "a mapping" + (f" ({', '.join(entry.value)})"[:80] if entry.value else "")
    if isinstance(entry.value, list):
        return f"a list of {len(entry.value)}"
    return "nothing" if entry.value is None else shown(entry.value)

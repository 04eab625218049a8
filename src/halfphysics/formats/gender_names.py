"""Genders as files spell them."""

from __future__ import annotations

from halfphysics.formats.checked_fields import Record

_SHORT = {"m": "male", "f": "female", "n": "neutral"}


def gender_named(text: str) -> str:
    """A gender of any spelling ("Female", "m") in that of `Motion.gender`; other words as they
    are, in small letters."""
    word = text.strip().lower()
    return _SHORT.get(word, word)


def said_gender(record: Record, key: str = "gender") -> str | None:
    """The gender that a file says; None: it has no such field, or None in it.

    Raises:
        FileError: The field is no text.
    """
    if key not in record or record.raw(key) is None:
        return None
    return gender_named(record.text(key))

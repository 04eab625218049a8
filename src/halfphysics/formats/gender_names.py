"""Genders as files spell them."""

from __future__ import annotations

import numpy as np

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
    if key not in record:
        return None
    said = record.raw(key)
    if isinstance(said, np.ndarray) and said.dtype.hasobject and said.size == 1:
        said = said.reshape(-1)[0]
    return None if said is None else gender_named(record.text(key))

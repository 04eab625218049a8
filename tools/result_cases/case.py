"""A case, and the names that make up its result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Case:
    """Something to run whose outcome must not change.

    Attributes:
        name: Unique; "family/what".
        run: Gives the values to hash, by name: numbers, text, arrays, and tuples, lists,
            mappings and dataclasses of them.
        quick: Whether `--quick` runs it.
    """

    name: str
    run: Callable[[], Mapping[str, Any]]
    quick: bool = False

"""The clause "did you mean X?" of a message about an unknown name."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable


def closest(word: object, known: Iterable[str], count: int = 1) -> list[str]:
    """Up to `count` of the `known` names that are spelled like `word`, the most similar first."""
    return difflib.get_close_matches(str(word), list(known), n=count)


def did_you_mean(
    word: object,
    known: Iterable[str],
    *,
    form: Callable[[str], str] = str,
    count: int = 1,
    brackets: bool = False,
    otherwise: str = "",
) -> str:
    """The clause that proposes up to `count` known names, to append to a message.

    Args:
        word: The unknown name.
        known: All names that are allowed.
        form: How a proposed name is written: `str` plainly, `repr` in quotation marks.
        count: Largest number of names that are proposed.
        brackets: Write " (did you mean X?)" instead of "; did you mean X?".
        otherwise: The result if no known name is similar.
    """
    names = closest(word, known, count)
    if not names:
        return otherwise
    question = f"did you mean {' or '.join(map(form, names))}?"
    return f" ({question})" if brackets else f"; {question}"

"""The clause "did you mean X?" of a message about an unknown name."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable

#: Words of other programs -> ours, where that is allowed: spelling would find another.
_OTHER_WORDS = {
    **dict.fromkeys(("rotation", "orientation", "rot", "quat", "euler"), "quaternion"),
    **dict.fromkeys(("translation", "location", "pos", "origin"), "position"),
    **dict.fromkeys(("dimensions", "extents", "extent"), "size"),
    **dict.fromkeys(("file", "path"), "mesh"),
    "weight": "mass",
}


def closest(word: object, known: Iterable[str], count: int = 1) -> list[str]:
    """Up to `count` of the `known` names, the best first: of this meaning, or spelled like it."""
    names = list(dict.fromkeys(known))
    meant = [name for name in (_OTHER_WORDS.get(str(word).lower()),) if name in names]
    return meant or difflib.get_close_matches(str(word), names, n=count)


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

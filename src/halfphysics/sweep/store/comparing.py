"""The differences of two versions of a sample's files as text: which array, which entry."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.sweep.store.contents import DAMAGE, contents

_SHOWN = 40


def files_differ(
    there: Mapping[str, bytes], here: Mapping[str, bytes], ignored: Collection[str] = ()
) -> list[str]:
    """The differences between the files of two versions of a sample, at most a line per array.

    Args:
        there: Name -> content, the stored version.
        here: Name -> content, the version that was made again.
        ignored: Entries of card.json that may differ.
    """
    words = _missing("", there, here)
    for name in sorted(there.keys() & here.keys()):
        if there[name] == here[name]:
            continue
        try:
            one, other = (contents(name, data) for data in (there[name], here[name]))
        except DAMAGE as error:
            words.append(f"{name}: cannot be read ({error})")
            continue
        found = contents_differ(name, one, other, ignored)
        # The difference may be in ignored entries of a card.
        if not found and not (name.endswith(".json") and ignored):
            found = [f"{name}: the bytes differ, what is in it is the same"]
        words += found
    return words


def contents_differ(name: str, there: Any, here: Any, ignored: Collection[str] = ()) -> list[str]:
    """The differences between the contents of two files; see `files_differ`."""
    if name.endswith(".json"):
        one, other = ({k: v for k, v in its.items() if k not in ignored} for its in (there, here))
        first = next(_values_differ(one, other), None)
        return [] if first is None else [f"{name}: {first}"]
    words = _missing(f"{name}: ", there, here)
    for key in sorted(there.keys() & here.keys()):
        text = _arrays_differ(np.asarray(there[key]), np.asarray(here[key]))
        words += [f"{name}: {key}{text}"] if text else []
    return words


def _missing(what: str, there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    gone = [f"{what}{name} is not made any more" for name in sorted(there.keys() - here.keys())]
    return gone + [f"{what}{name} is missing there" for name in sorted(here.keys() - there.keys())]


def _arrays_differ(there: NDArray[Any], here: NDArray[Any]) -> str:
    """The first entry in which arrays differ, bit by bit; "" if they are equal."""
    if there.dtype != here.dtype or there.shape != here.shape:
        return f" is {there.dtype} of shape {there.shape} there, {here.dtype} of {here.shape} here"
    # Compare bits: NaN equals NaN, and 0.0 differs from -0.0.
    size = there.dtype.itemsize
    one, other = (
        np.frombuffer(np.ascontiguousarray(a).tobytes(), np.uint8).reshape(-1, size)
        for a in (there, here)
    )
    rows = np.flatnonzero((one != other).any(axis=1))
    if not len(rows):
        return ""
    place = np.unravel_index(rows[0], there.shape)
    index = ", ".join(str(int(i)) for i in place)
    values = (_short(a[place].item()) for a in (there, here))
    return (
        f"[{index}] is {' there, '.join(values)} here"
        f" ({len(rows):,} of {there.size:,} entries differ)"
    )


def _values_differ(there: Any, here: Any, where: str = "") -> Iterator[str]:
    """The entries in which JSON values differ."""
    if isinstance(there, dict) and isinstance(here, dict):
        for key in sorted(there.keys() | here.keys()):
            own = f"{where}.{key}".lstrip(".")
            if key not in there or key not in here:
                yield f"{own} is {'there' if key in there else 'here'} only"
            else:
                yield from _values_differ(there[key], here[key], own)
    elif isinstance(there, list) and isinstance(here, list) and len(there) == len(here):
        for place, pair in enumerate(zip(there, here, strict=True)):
            yield from _values_differ(*pair, f"{where}[{place}]")
    # Compare as text: 1 differs from 1.0, and 0.0 from -0.0.
    elif json.dumps(there) != json.dumps(here):
        yield f"{where} is {_short(there)} there, {_short(here)} here"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."

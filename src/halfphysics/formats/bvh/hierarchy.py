"""The hierarchy of a BVH file: joints with offsets and channels, read statement by statement."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import FileError

Array = NDArray[np.float64]

KEYWORD = b"HIERARCHY"
#: All channel names: positions along x, y, z, then rotations about them.
CHANNELS = (
    *(f"{axis}position" for axis in "XYZ"),
    *(f"{axis}rotation" for axis in "XYZ"),
)
_CANON = {name.lower(): name for name in CHANNELS}
_MAX_JOINTS = 10_000
# Larger than any position in any unit and any angle in degrees.
LARGEST = 1e9


class StatementReader:
    """Statements of the hierarchy one after another, with their line numbers."""

    def __init__(self, path: Path, lines: Sequence[str]) -> None:
        self.path = path
        self.line = 1
        self._statements = [
            (number, part.strip())
            for number, line in enumerate(lines, 1)
            for part in re.split(r"([{}])", line)
            if part.strip()
        ]
        self._at = 0

    @property
    def at_end(self) -> bool:
        """Whether every statement has been read."""
        return self._at == len(self._statements)

    def next(self, expected: str) -> list[str]:
        """The words of the next statement."""
        if self.at_end:
            raise self.error(f"the file ends here, expected {expected}. Copy it again")
        self.line, text = self._statements[self._at]
        self._at += 1
        return text.split()

    def error(self, text: str) -> FileError:
        return FileError(f"{self.path}: line {self.line}: {text}")

    def take(self, word: str, where: str) -> None:
        words = self.next(f"'{word}' {where}")
        if len(words) != 1 or words[0].upper() != word:
            raise self.error(f"found {shown_words(words)}, expected '{word}' {where}")

    def offset(self, words: list[str], where: str) -> Array:
        """The numbers of an OFFSET statement."""
        if words[0].upper() != "OFFSET":
            raise self.error(f"found {shown_words(words)}, expected OFFSET x y z {where}")
        try:
            array = np.array([one_number(word) for word in words[1:]])
        except ValueError:
            array = np.empty(0)
        if array.shape != (3,) or not (np.abs(array) < LARGEST).all():
            raise self.error(
                f"found {shown_words(words)}, expected OFFSET and three numbers {where} under "
                f"{LARGEST:g}"
            )
        return array


def shown_words(words: Sequence[str]) -> str:
    text = " ".join(words)
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def one_number(word: str) -> float:
    # float() reads 1_000 as a thousand; BVH does not.
    if "_" in word:
        raise ValueError(word)
    return float(word)


@dataclass
class Hierarchy:
    """The joints of the hierarchy, filled while its statements are read."""

    reader: StatementReader
    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[Array] = field(default_factory=list)
    ends: dict[int, Array] = field(default_factory=dict)
    channels: list[tuple[str, ...]] = field(default_factory=list)
    # Joints whose closing brace has not been read, the innermost last.
    open_joints: list[int] = field(default_factory=list)

    def read(self) -> None:
        """Read the whole hierarchy, which is one skeleton."""
        reader = self.reader
        reader.take(KEYWORD.decode(), "in the first line")
        words = reader.next("ROOT and a name")
        if words[0].upper() != "ROOT":
            raise reader.error(f"found {shown_words(words)}, expected ROOT and a name")
        self._statement(words)
        while self.open_joints:
            self._statement(reader.next(f"'}}' of joint {self._innermost!r}"))
        if not reader.at_end:
            words = reader.next("MOTION")
            raise reader.error(
                f"found {shown_words(words)} after the joints of {self.names[0]!r}, expected "
                "MOTION and one skeleton per file"
            )

    @property
    def _innermost(self) -> str:
        return self.names[self.open_joints[-1]]

    def _statement(self, words: list[str]) -> None:
        reader, kind = self.reader, words[0].upper()
        if kind == "}":
            self.open_joints.pop()
        elif kind in ("JOINT", "ROOT"):
            self._joint(kind, " ".join(words[1:]))
        elif kind == "END":
            where = f"in the End Site of joint {self._innermost!r}"
            reader.take("{", where)
            end = reader.offset(reader.next(f"the OFFSET {where}"), where)
            self.ends[self.open_joints[-1]] = end
            reader.take("}", where)
        else:
            raise reader.error(
                f"found {shown_words(words)}, expected JOINT, End Site or '}}' in joint "
                f"{self._innermost!r}"
            )

    def _joint(self, kind: str, name: str) -> None:
        reader = self.reader
        if kind == "ROOT" and self.names:
            raise reader.error(
                f"found a second ROOT after {self.names[0]!r}, expected one skeleton per file. "
                "Split the file"
            )
        if not name:
            raise reader.error(f"found {kind} without a name")
        if name in self.names:
            raise reader.error(f"found joint {name!r} a second time. Rename one of them")
        if len(self.names) == _MAX_JOINTS:
            raise reader.error(f"found more than {_MAX_JOINTS} joints")
        self.names.append(name)
        self.parents.append(self.open_joints[-1] if self.open_joints else -1)
        self.open_joints.append(len(self.names) - 1)
        where = f"of joint {name!r}"
        reader.take("{", f"after joint {name!r}")
        self.offsets.append(reader.offset(reader.next(f"the OFFSET {where}"), where))
        self.channels.append(_channels(reader, where))


#: A longer number is none of channels.
_DIGITS = 3


def _channels(reader: StatementReader, where: str) -> tuple[str, ...]:
    words = reader.next(f"the CHANNELS {where}")
    said = words[1] if len(words) > 1 else ""
    if words[0].upper() != "CHANNELS" or not said.isdecimal() or len(said) > _DIGITS:
        raise reader.error(f"found {shown_words(words)}, expected CHANNELS, their number and names")
    found = [_CANON.get(word.lower()) for word in words[2:]]
    unknown = [word for word, name in zip(words[2:], found, strict=True) if name is None]
    if unknown:
        raise reader.error(
            f"found channel {unknown[0]!r} {where}, expected some of {', '.join(CHANNELS)}"
        )
    if len(found) != int(said):
        raise reader.error(f"found {len(found)} channels {where}, expected the {said} it says")
    if len(set(found)) != len(found):
        raise reader.error(f"found {shown_words(words)} {where}, expected each channel once")
    return tuple(name for name in found if name is not None)

"""The text of a BVH file: joints with offsets and channels, and a row of numbers per frame.

Facts of the format. A joint turns by the product of its channels' rotations in the order in which
they are listed, degrees. Offsets are the child's place in its parent's frame. Position channels
stand for the joint's place in its parent's frame, in the file's unit.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.atomic import atomic_write
from halfphysics.errors import FileError

Array = NDArray[np.float64]

KEYWORD = b"HIERARCHY"
#: The channels there are; positions along x, y, z, then rotations about them.
CHANNELS = (
    *(f"{axis}position" for axis in "XYZ"),
    *(f"{axis}rotation" for axis in "XYZ"),
)
_CANON = {name.lower(): name for name in CHANNELS}
# Far above any mocap file (an hour of 200 joints at 120 fps is about 2 GB of text).
_MAX_BYTES = 4 * 2**30
_MAX_JOINTS = 10_000
# No person and no path is that long in any unit, no joint turns by that many degrees.
_LARGEST = 1e9
# A rate this near (relative) to what the printed frame time says is that rate.
_SAME_RATE = 1e-12


@dataclass(frozen=True, eq=False, kw_only=True)
class Bvh:
    """What a BVH file says, in its own unit and axes.

    Attributes:
        names: Of the J joints, parents before children.
        parents: (J,), -1 for the root.
        offsets: Places in the parents' frames, (J, 3).
        ends: Joint -> the offset of its End Site.
        channels: Of each joint the names of its channels, in the file's order.
        values: Rows of numbers (T, C), the channels of all joints one after another.
        fps: Frames per second.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Array
    ends: dict[int, Array]
    channels: tuple[tuple[str, ...], ...]
    values: Array
    fps: float

    @property
    def starts(self) -> NDArray[np.intp]:
        """Column of `values` where a joint's channels begin, (J,)."""
        sizes = [len(channels) for channels in self.channels]
        return np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.intp)


class _Reader:
    """Statements of the hierarchy one after another, with the lines they are on."""

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

    def next(self, expected: str) -> list[str]:
        """The words of the next statement."""
        if self._at == len(self._statements):
            raise self.error(f"the file ends here, expected {expected}. Copy it again")
        self.line, text = self._statements[self._at]
        self._at += 1
        return text.split()

    def error(self, text: str) -> FileError:
        return FileError(f"{self.path}: line {self.line}: {text}")

    def take(self, word: str, where: str) -> None:
        words = self.next(f"'{word}' {where}")
        if len(words) != 1 or words[0].upper() != word:
            raise self.error(f"found {_shown(words)}, expected '{word}' {where}")

    def offset(self, words: list[str], where: str) -> Array:
        """The numbers of an OFFSET statement."""
        if words[0].upper() != "OFFSET":
            raise self.error(f"found {_shown(words)}, expected OFFSET x y z {where}")
        try:
            array = np.array([_number(word) for word in words[1:]])
        except ValueError:
            array = np.empty(0)
        if array.shape != (3,) or not (np.abs(array) < _LARGEST).all():
            raise self.error(
                f"found {_shown(words)}, expected OFFSET and three numbers {where} under "
                f"{_LARGEST:g}"
            )
        return array


def _shown(words: Sequence[str]) -> str:
    text = " ".join(words)
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def _number(word: str) -> float:
    # Python takes 1_000 for a thousand; files do not.
    if "_" in word:
        raise ValueError(word)
    return float(word)


def read_bvh(path: Path) -> Bvh:
    """Read a BVH file.

    Raises:
        FileError: It is damaged, truncated or says something impossible: it names the line.
    """
    try:
        size = path.stat().st_size
        if size > _MAX_BYTES:
            raise FileError(
                f"{path}: {size / 2**30:.1f} GiB of text, expected at most "
                f"{_MAX_BYTES / 2**30:.0f} GiB. Split the file"
            )
        raw = path.read_bytes()
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    text = raw.decode("utf-8-sig", errors="replace")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    motion = next((i for i, line in enumerate(lines) if line.strip().upper() == "MOTION"), None)
    reader = _Reader(path, lines[:motion])
    names, parents, offsets, ends, channels = _hierarchy(reader)
    if motion is None:
        raise FileError(
            f"{path}: line {len(lines)}: the file ends without MOTION, expected a row of numbers "
            "per frame after it. Is it a skeleton only, or was it cut off?"
        )
    fps, values = _frames(path, lines, motion, sum(map(len, channels)))
    return Bvh(
        names=tuple(names),
        parents=tuple(parents),
        offsets=np.array(offsets),
        ends=ends,
        channels=tuple(channels),
        values=values,
        fps=fps,
    )


def _hierarchy(
    reader: _Reader,
) -> tuple[list[str], list[int], list[Array], dict[int, Array], list[tuple[str, ...]]]:
    names: list[str] = []
    parents: list[int] = []
    offsets: list[Array] = []
    ends: dict[int, Array] = {}
    channels: list[tuple[str, ...]] = []
    reader.take(KEYWORD.decode(), "in the first line")
    open_joints: list[int] = []
    words = reader.next("ROOT and a name")
    if words[0].upper() != "ROOT":
        raise reader.error(f"found {_shown(words)}, expected ROOT and a name")
    while True:
        kind = words[0].upper()
        if kind == "}":
            open_joints.pop()
        elif kind in ("JOINT", "ROOT"):
            if kind == "ROOT" and names:
                raise reader.error(
                    f"found a second ROOT after {names[0]!r}, expected one skeleton per file. "
                    "Split the file"
                )
            name = " ".join(words[1:])
            if not name:
                raise reader.error(f"found {kind} without a name")
            if name in names:
                raise reader.error(f"found joint {name!r} a second time. Rename one of them")
            if len(names) == _MAX_JOINTS:
                raise reader.error(f"found more than {_MAX_JOINTS} joints")
            names.append(name)
            parents.append(open_joints[-1] if open_joints else -1)
            open_joints.append(len(names) - 1)
            where = f"of joint {name!r}"
            reader.take("{", f"after joint {name!r}")
            offsets.append(reader.offset(reader.next(f"the OFFSET {where}"), where))
            channels.append(_channels(reader, where))
        elif kind == "END":
            where = f"in the End Site of joint {names[open_joints[-1]]!r}"
            reader.take("{", where)
            ends[open_joints[-1]] = reader.offset(reader.next(f"the OFFSET {where}"), where)
            reader.take("}", where)
        else:
            raise reader.error(
                f"found {_shown(words)}, expected JOINT, End Site or '}}' in joint "
                f"{names[open_joints[-1]]!r}"
            )
        if not open_joints:
            break
        words = reader.next(f"'}}' of joint {names[open_joints[-1]]!r}")
    if reader._at != len(reader._statements):
        words = reader.next("MOTION")
        raise reader.error(
            f"found {_shown(words)} after the joints of {names[0]!r}, expected MOTION and one "
            "skeleton per file"
        )
    return names, parents, offsets, ends, channels


def _channels(reader: _Reader, where: str) -> tuple[str, ...]:
    words = reader.next(f"the CHANNELS {where}")
    if words[0].upper() != "CHANNELS" or len(words) < 2 or not words[1].isdecimal():
        raise reader.error(f"found {_shown(words)}, expected CHANNELS, their number and names")
    found = [_CANON.get(word.lower()) for word in words[2:]]
    unknown = [word for word, name in zip(words[2:], found, strict=True) if name is None]
    if unknown:
        raise reader.error(
            f"found channel {unknown[0]!r} {where}, expected some of {', '.join(CHANNELS)}"
        )
    if len(found) != int(words[1]):
        raise reader.error(f"found {len(found)} channels {where}, expected the {words[1]} it says")
    if len(set(found)) != len(found):
        raise reader.error(f"found {_shown(words)} {where}, expected each channel once")
    return tuple(name for name in found if name is not None)


def _frames(path: Path, lines: list[str], motion: int, columns: int) -> tuple[float, Array]:
    """Frame rate and rows after the line MOTION (counted from 0)."""

    def error(line: int, text: str) -> FileError:
        return FileError(f"{path}: line {line + 1}: {text}")

    rows = [(i, line) for i, line in enumerate(lines[motion + 1 :], motion + 1) if line.strip()]
    heads: list[tuple[int, str]] = []
    for pattern, example in (
        (r"Frames\s*:\s*(\d+)", "Frames: 120"),
        (r"Frame\s*Time\s*:\s*(\S+)", "Frame Time: 0.0333333"),
    ):
        at, line = rows[len(heads)] if len(rows) > len(heads) else (len(lines) - 1, "")
        match = re.fullmatch(pattern, line.strip(), re.IGNORECASE)
        if match is None:
            raise error(at, f"found {_shown(line.split())}, expected a line like '{example}'")
        heads.append((at, match[1]))
    count = int(heads[0][1])
    fps = _rate(heads[1][1])
    if fps is None:
        raise error(
            heads[1][0],
            f"Frame Time: found {heads[1][1]!r}, expected seconds above zero, such as 0.0333333",
        )
    rows = rows[2:]
    if len(rows) != count:
        raise error(
            rows[-1][0] if rows else heads[1][0],
            f"the file ends after {len(rows)} rows of numbers, expected the {count} that 'Frames:' "
            f"in line {heads[0][0] + 1} says. Copy the file again, or mend that line",
        )
    words = [line.split() for _, line in rows]
    for (at, _), row in zip(rows, words, strict=True):
        if len(row) != columns:
            raise error(
                at,
                f"found {len(row)} numbers in the row, expected {columns}, one for each channel",
            )
    try:
        flat = np.fromiter(map(float, chain.from_iterable(words)), np.float64, count * columns)
        if any("_" in line for _, line in rows):
            raise ValueError
    except ValueError:
        raise _no_number(path, rows) from None
    values = flat.reshape(count, columns)
    possible = np.abs(values) < _LARGEST
    if not possible.all():
        row, column = np.argwhere(~possible)[0]
        raise error(
            rows[row][0],
            f"number {column + 1} of the row is {values[row, column]}, expected finite numbers "
            f"under {_LARGEST:g}",
        )
    return fps, values


def _no_number(path: Path, rows: list[tuple[int, str]]) -> FileError:
    """What to raise where a word is no number."""
    for at, line in rows:
        for column, word in enumerate(line.split(), 1):
            try:
                _number(word)
            except ValueError:
                return FileError(
                    f"{path}: line {at + 1}: word {column} of the row is {_shown([word])}, expected"
                    " numbers"
                )
    raise AssertionError("every word is a number")


def _rate(text: str) -> float | None:
    """Frames per second of a printed frame time; None: it is impossible.

    A whole rate, or one of television's (30000 / 1001), that prints as `text` is meant: 0.0333333
    is 30 frames per second, 0.008342 is 119.88.
    """
    try:
        seconds = _number(text)
    except ValueError:
        return None
    if not (np.isfinite(seconds) and seconds > 0.0) or not np.isfinite(1.0 / seconds):
        return None
    mantissa, _, exponent = text.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    slack = 0.5 * 10.0 ** (int(exponent or 0) - digits) + _SAME_RATE * seconds
    whole = round(1.0 / seconds)
    for rate in (whole, round(1.001 / seconds) / 1.001):
        if rate > 0 and abs(1.0 / rate - seconds) <= slack:
            return float(rate)
    return 1.0 / seconds


def write_bvh(path: Path, bvh: Bvh) -> None:
    """Write a BVH file; it appears whole or not at all.

    Raises:
        FileError: It cannot be written.
    """
    children: list[list[int]] = [[] for _ in bvh.names]
    for joint, parent in enumerate(bvh.parents):
        if parent >= 0:
            children[parent].append(joint)
    starts = bvh.starts.tolist()
    order: list[int] = []
    lines = ["HIERARCHY"]

    def offset(place: Array) -> str:
        return "OFFSET " + " ".join(_printed(number) for number in place)

    def joint_lines(joint: int, depth: int) -> None:
        pad, inner = "\t" * depth, "\t" * (depth + 1)
        order.extend(range(starts[joint], starts[joint] + len(bvh.channels[joint])))
        channels = bvh.channels[joint]
        lines.append(f"{pad}{'ROOT' if depth == 0 else 'JOINT'} {bvh.names[joint]}")
        lines.extend([f"{pad}{{", inner + offset(bvh.offsets[joint])])
        lines.append(" ".join([f"{inner}CHANNELS {len(channels)}", *channels]))
        for child in children[joint]:
            joint_lines(child, depth + 1)
        if joint in bvh.ends:
            lines.extend([f"{inner}End Site", f"{inner}{{"])
            lines.extend([f"{inner}\t{offset(bvh.ends[joint])}", f"{inner}}}"])
        lines.append(f"{pad}}}")

    joint_lines(0, 0)
    lines.extend(["MOTION", f"Frames: {len(bvh.values)}", f"Frame Time: {1.0 / bvh.fps!r}"])
    form = " ".join([_FORM] * len(order))
    # Readers take the rows in the order of the hierarchy as it is written.
    rows = bvh.values[:, order] + 0.0
    with atomic_write(path) as handle:
        handle.write(("\n".join(lines) + "\n").encode("utf-8"))
        for row in rows:
            handle.write((form % tuple(row)).encode("ascii") + b"\n")


# A billionth of a centimetre or degree: far below the 1e-6 m that files are held to.
_FORM = "%.9f"


def _printed(number: float) -> str:
    return _FORM % (number + 0.0)

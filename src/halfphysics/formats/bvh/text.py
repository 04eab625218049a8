"""The text of a BVH file: joints with offsets and channels, and a row of numbers per frame.

The rotation of a joint is the product of its channels' rotations in the order of the list, in
degrees. An offset is the child's position in its parent's frame. Position channels give the
joint's position in its parent's frame, in the file's unit.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.atomic import atomic_write
from halfphysics.errors import FileError
from halfphysics.formats.bvh.hierarchy import (
    LARGEST,
    Hierarchy,
    StatementReader,
    one_number,
    shown_words,
)

Array = NDArray[np.float64]

# Far above any mocap file (an hour of 200 joints at 120 fps is about 2 GB of text).
_MAX_BYTES = 4 * 2**30
# Rates of animations, cameras and suits: where a time of two digits fits several, one of these.
_USUAL = (30, 60, 120, 24)
# Relative tolerance between a rate and the printed frame time.
_SAME_RATE = 1e-12


@dataclass(frozen=True, eq=False, kw_only=True)
class Bvh:
    """The content of a BVH file, in its own unit and axes.

    Attributes:
        names: Names of the J joints, parents before children.
        parents: Parent joints (J,), -1 for the root.
        offsets: Positions in the parents' frames, (J, 3).
        ends: Joint -> the offset of its End Site.
        channels: Channel names of each joint, in the file's order.
        values: Channel values (T, C), joint after joint.
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


def read_bvh(path: Path) -> Bvh:
    """Read a BVH file.

    Raises:
        FileError: The file is damaged, truncated or impossible; the message names the line.
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
    reader = StatementReader(path, lines[:motion])
    joints = Hierarchy(reader)
    joints.read()
    if motion is None:
        raise FileError(
            f"{path}: line {len(lines)}: the file ends without MOTION, expected a row of numbers "
            "per frame after it. Is it a skeleton only, or was it cut off?"
        )
    fps, values = _frames(path, lines, motion, sum(map(len, joints.channels)))
    return Bvh(
        names=tuple(joints.names),
        parents=tuple(joints.parents),
        offsets=np.array(joints.offsets),
        ends=joints.ends,
        channels=tuple(joints.channels),
        values=values,
        fps=fps,
    )


def _error(path: Path, line: int, text: str) -> FileError:
    """An error in a line; `line` counts from 0."""
    return FileError(f"{path}: line {line + 1}: {text}")


def _frames(path: Path, lines: list[str], motion: int, columns: int) -> tuple[float, Array]:
    """Frame rate and rows after the line MOTION (counted from 0)."""
    rows = [(i, line) for i, line in enumerate(lines[motion + 1 :], motion + 1) if line.strip()]
    heads: list[tuple[int, str]] = []
    for pattern, example in (
        (r"Frames\s*:\s*(\d{1,12})", "Frames: 120"),
        (r"Frame\s*Time\s*:\s*(\S+)", "Frame Time: 0.0333333"),
    ):
        at, line = rows[len(heads)] if len(rows) > len(heads) else (len(lines) - 1, "")
        match = re.fullmatch(pattern, line.strip(), re.IGNORECASE)
        if match is None:
            found = shown_words(line.split())
            raise _error(path, at, f"found {found}, expected a line like '{example}'")
        heads.append((at, match[1]))
    count = int(heads[0][1])
    fps = _rate(heads[1][1])
    if fps is None:
        raise _error(
            path,
            heads[1][0],
            f"Frame Time: found {heads[1][1]!r}, expected seconds above zero, such as 0.0333333",
        )
    rows = rows[2:]
    if len(rows) != count:
        raise _error(
            path,
            rows[-1][0] if rows else heads[1][0],
            f"the file ends after {len(rows)} rows of numbers, expected the {count} that 'Frames:' "
            f"in line {heads[0][0] + 1} says. Copy the file again, or mend that line",
        )
    return fps, _values(path, rows, columns)


def _values(path: Path, rows: list[tuple[int, str]], columns: int) -> Array:
    """The numbers of the rows (T, columns); a row is its line number, from 0, and the text."""
    words = [line.split() for _, line in rows]
    for (at, _), row in zip(rows, words, strict=True):
        if len(row) != columns:
            raise _error(
                path,
                at,
                f"found {len(row)} numbers in the row, expected {columns}, one for each channel",
            )
    try:
        numbers = map(float, chain.from_iterable(words))
        flat = np.fromiter(numbers, np.float64, len(rows) * columns)
        if any("_" in line for _, line in rows):
            raise ValueError
    except ValueError:
        raise _no_number(path, rows) from None
    values = flat.reshape(len(rows), columns)
    possible = np.abs(values) < LARGEST
    if not possible.all():
        frame, column = np.argwhere(~possible)[0]
        raise _error(
            path,
            rows[frame][0],
            f"number {column + 1} of the row is {values[frame, column]}, expected finite numbers "
            f"under {LARGEST:g}",
        )
    return values


def _no_number(path: Path, rows: list[tuple[int, str]]) -> FileError:
    """The error for a word that is no number."""
    for at, line in rows:
        for column, word in enumerate(line.split(), 1):
            try:
                one_number(word)
            except ValueError:
                return FileError(
                    f"{path}: line {at + 1}: word {column} of the row is {shown_words([word])}, "
                    "expected numbers"
                )
    raise AssertionError("every word is a number")


def _rate(text: str) -> float | None:
    """Frames per second of a printed frame time; None: it is impossible.

    A rate of few digits that is this exactly, else a rate of cameras and suits (30, 60, 120), else
    any whole or television rate (30000 / 1001) that prints as `text` is taken: 0.08 is 12.5 frames
    per second, 0.017 is 60, 0.0333333 is 30, 0.008342 is 119.88.
    """
    try:
        seconds = one_number(text)
    except ValueError:
        return None
    if not (np.isfinite(seconds) and seconds > 0.0) or not np.isfinite(1.0 / seconds):
        return None
    mantissa, _, exponent = text.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    slack = 0.5 * 10.0 ** (int(exponent or 0) - digits) + _SAME_RATE * seconds
    whole = round(1.0 / seconds)
    short = round(1.0 / seconds, 3)
    if short > 0 and abs(1.0 / short - seconds) < _SAME_RATE * seconds:
        return short
    for rate in (*_USUAL, whole, round(1.001 / seconds) / 1.001):
        if rate > 0 and abs(1.0 / rate - seconds) <= slack:
            return float(rate)
    return 1.0 / seconds


def write_bvh(path: Path, bvh: Bvh) -> None:
    """Write a BVH file atomically.

    Raises:
        FileError: The file cannot be written.
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
    # Readers expect the columns in the order of the written hierarchy.
    rows = bvh.values[:, order] + 0.0
    with atomic_write(path) as handle:
        handle.write(("\n".join(lines) + "\n").encode("utf-8"))
        for row in rows:
            handle.write((form % tuple(row)).encode("ascii") + b"\n")


# 1e-9 cm or degrees: far below the required file precision of 1e-6 m.
_FORM = "%.9f"


def _printed(number: float) -> str:
    return _FORM % (number + 0.0)

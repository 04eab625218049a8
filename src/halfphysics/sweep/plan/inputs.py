"""Inputs of a sweep: entries of its file, and the motions and scenarios they name.

Each input of an entry is a line of text, so a million inputs are a file and an array of offsets.
A line is "file", the path and the number of the entry, or "scenario", the name and the number,
separated by tabs.
"""

from __future__ import annotations

import glob
import mmap
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, get_args, get_type_hints

import numpy as np

from halfphysics.base.validation import file_path, frame_rate, number, shown
from halfphysics.errors import FileError, InputError
from halfphysics.formats.loading import MotionOptions
from halfphysics.motion.motion import MODELS
from halfphysics.sweep.plan.factors import NOT_PLAIN

_CHUNK = 1 << 20
#: Control characters, separators of lines and paragraphs, and bytes that are no UTF-8: a line of
#: text cannot hold them. Other spaces and joined signs can be in it.
_UNLISTED = re.compile("[\0-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """An entry of a plan's inputs: files or scenarios, and their common options.

    Attributes:
        files: Patterns (*, ?, [...], ** for any folders between), relative to the plan's folder;
            a pattern that ends in a slash matches folders, for data sets with one folder per clip.
        scenarios: Names of scenarios; these or files.
        options: For files the fields of `io.asked.MotionOptions` (fps, up, floor, hands, model,
            gender, frames, clip, assets, objects, adapt, grip), for scenarios their own options.
        ground: Add a floor at z = 0 if the scene has no plane.
    """

    files: tuple[str, ...] = ()
    scenarios: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    ground: bool = False

    def __post_init__(self) -> None:
        for name in ("files", "scenarios"):
            object.__setattr__(self, name, _texts(getattr(self, name), name))
        if bool(self.files) == bool(self.scenarios):
            found = "both" if self.files else "neither"
            raise InputError(f"expected files (patterns) or scenarios (names), found {found}")
        if not isinstance(self.ground, bool):
            raise InputError(f"ground: found {shown(self.ground)}, expected true or false")
        if not isinstance(self.options, Mapping):
            raise InputError(f"options: found {shown(self.options)}, expected a mapping")
        options = dict(self.options)
        if self.files:
            options = _motion_options(options)
        else:
            _check_scenarios(self.scenarios, options)
        object.__setattr__(self, "options", options)

    def document(self) -> dict[str, Any]:
        """The entry as plain data, with all defaults written out."""
        what = {"files": list(self.files)} if self.files else {"scenarios": list(self.scenarios)}
        return {**what, **dict(sorted(self.options.items())), "ground": self.ground}


@dataclass(frozen=True, kw_only=True, slots=True)
class Input:
    """One motion file or scenario.

    Attributes:
        kind: "file" or "scenario".
        name: The file's path as in the list of inputs (with /), or the scenario's name.
        path: Path of the file; None for a scenario.
        options: For a file, the given fields of `io.asked.MotionOptions`, with paths that can be
            opened; for a scenario, its own options.
        ground: Add a floor at z = 0 if the scene has no plane.
    """

    kind: Literal["file", "scenario"]
    name: str
    path: Path | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    ground: bool = False

    @property
    def motion_options(self) -> MotionOptions:
        """The options for reading the file."""
        return MotionOptions(**self.options)


def file_options() -> tuple[str, ...]:
    """The options that an entry of files can have."""
    return tuple(option.name for option in fields(MotionOptions))


def scenario_options(names: Sequence[str]) -> tuple[str, ...]:
    """The options that all of these scenarios have.

    Raises:
        InputError: An unknown name.
    """
    from halfphysics import scenarios

    known = [tuple(scenarios.options(name)) for name in names]
    return tuple(o for o in known[0] if o not in NOT_PLAIN and all(o in each for each in known))


def resolve(entries: Sequence[Inputs], base: Path, *outputs: str | os.PathLike[str]) -> list[str]:
    """The inputs, one line each: entry by entry, files sorted by path within each.

    Args:
        entries: The entries of the plan.
        base: The folder that patterns are relative to.
        outputs: Folders of results, relative to `base`; they and the files in them are no inputs.

    Raises:
        FileError: No file matches a pattern, or a line cannot hold a name.
    """
    own = _own(base, outputs)
    lines = []
    for place, entry in enumerate(entries):
        if entry.scenarios:
            lines += [f"scenario\t{name}\t{place}" for name in entry.scenarios]
            continue
        found: set[str] = set()
        for k, pattern in enumerate(entry.files):
            count = 0
            for name in _matches(pattern, base, own):
                found.add(f"file\t{name}\t{place}")  # a million: no second copy of them
                count += 1
            if not count:
                raise FileError(
                    f"inputs[{place}].files[{k}]: no {'folder' if pattern[-1:] == '/' else 'file'}"
                    f" matches {pattern!r} in {base.absolute()}; patterns are relative to the "
                    "plan's folder, ** stands for any folders between"
                )
        lines += sorted(found)
    return lines


def read_line(line: str, entries: Sequence[Inputs], base: Path) -> Input:
    """The input described by a line.

    Raises:
        FileError: The line cannot belong to this plan.
    """
    kind, _, rest = line.partition("\t")
    name, _, digits = rest.partition("\t")
    place = int(digits) if digits.isascii() and digits.isdigit() else 0 if not digits else -1
    if kind not in ("file", "scenario") or not name or not 0 <= place < len(entries):
        raise FileError(
            f"inputs: found the line {shown(line)}, expected 'file' or 'scenario', a name, and the "
            f"number of one of the plan's {len(entries)} entries of inputs, with tabs between"
        )
    entry = entries[place]
    if kind == "scenario":
        return Input(kind="scenario", name=name, options=entry.options, ground=entry.ground)
    options = _opened(entry.options, base)
    return Input(kind="file", name=name, path=base / name, options=options, ground=entry.ground)


class InputList(Sequence[str]):
    """The lines of a file, read on access: a million lines take 8 MB.

    The file must not change. The list can be sent to other processes, which open the file again.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """
        Raises:
            FileError: The file does not exist or is empty.
        """
        self.path = file_path(path)
        try:
            with self.path.open("rb") as handle:
                self._ends = _line_ends(handle)
                if self._ends.size:
                    self._bytes = mmap.mmap(handle.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise FileError(f"{self.path}: cannot be read: {error.strerror}") from None
        if not self._ends.size:
            raise FileError(f"{self.path}: found no lines, expected the inputs of a sweep")

    def __len__(self) -> int:
        return int(self._ends.size)

    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, slice):
            return [self[k] for k in range(*place.indices(len(self)))]
        if not -len(self) <= place < len(self):
            raise IndexError(f"line {place} of {len(self)}")
        place %= len(self)
        start = int(self._ends[place - 1]) + 1 if place else 0
        return self._bytes[start : int(self._ends[place])].decode()

    def __reduce__(self) -> tuple[type[InputList], tuple[Path]]:
        return InputList, (self.path,)


def _line_ends(handle: Any) -> np.ndarray:
    """Offsets of the line breaks (n,), int64, the end of an unfinished last line included."""
    parts, offset, last = [], 0, b"\n"
    while chunk := handle.read(_CHUNK):
        parts.append(np.flatnonzero(np.frombuffer(chunk, np.uint8) == 10).astype(np.int64) + offset)
        offset += len(chunk)
        last = chunk[-1:]
    if last != b"\n":
        parts.append(np.array([offset], np.int64))
    return np.concatenate(parts) if parts else np.empty(0, np.int64)


def _own(base: Path, outputs: Sequence[str | os.PathLike[str]]) -> dict[str, tuple[str, ...]]:
    """The base as it is named and without links -> the folders of results, named likewise.

    A folder that the base is in is left out: everything would be in it.
    """
    own = {}
    for true in (os.path.abspath, os.path.realpath):
        root = os.path.join(true(base), "")
        folders = (os.path.join(true(base / folder), "") for folder in outputs)
        own[root] = tuple(folder for folder in folders if not root.startswith(folder))
    return own


def _matches(pattern: str, base: Path, own: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
    folders = pattern.endswith("/")
    for name in glob.iglob(pattern, root_dir=base, recursive=True):
        if any(
            (os.path.normpath(os.path.join(root, name)) + os.sep).startswith(results)
            for root, results in own.items()
        ):
            continue
        if folders or os.path.isfile(base / name):
            name = name.replace(os.sep, "/").rstrip("/")
            if _UNLISTED.search(name):
                raise FileError(
                    f"{name!r}: found a name with characters that a list of inputs cannot hold "
                    "(tabs, line breaks, what is no UTF-8); rename it"
                )
            yield name


def _motion_options(options: dict[str, Any]) -> dict[str, Any]:
    """Options of files, checked by making a `MotionOptions` and reading its frames."""
    known = file_options()
    for name in options:
        if name not in known:
            raise InputError(f"{name}: unknown option, expected one of {', '.join(known)}")
    if "assets" in options:
        options["assets"] = list(_texts(options["assets"], "assets"))
    hints = get_type_hints(MotionOptions)
    for name in ("up", "hands", "gender", "objects"):
        allowed = _literals(hints[name])
        if name in options and options[name] not in allowed:
            raise InputError(
                f"{name}: found {shown(options[name])}, expected {' or '.join(allowed)}"
            )
    for name in ("model", "clip", "frames"):
        if name in options and (not isinstance(options[name], str) or not options[name]):
            raise InputError(f"{name}: found {shown(options[name])}, expected text")
    for name in ("adapt", "grip"):
        if not isinstance(options.get(name, True), bool):
            raise InputError(f"{name}: found {shown(options[name])}, expected true or false")
    if "fps" in options:
        frame_rate(options["fps"])
    if options.get("floor", "lowest") != "lowest":
        try:
            options["floor"] = number(options["floor"], "floor", unit="m")
        except InputError as error:
            raise InputError(f"{error}, or lowest") from None
    if "frames" in options:
        MotionOptions(frames=options["frames"]).frame_range()
    return options


def _literals(hint: Any) -> tuple[str, ...]:
    """The texts that a type of Literal, or of Literal and None, allows."""
    inner = [_literals(part) for part in get_args(hint) if not isinstance(part, str)]
    own = tuple(part for part in get_args(hint) if isinstance(part, str))
    return own + tuple(text for texts in inner for text in texts)


def _check_scenarios(names: tuple[str, ...], options: Mapping[str, Any]) -> None:
    known = scenario_options(names)
    for option in options:
        if option not in known:
            raise InputError(
                f"{option}: unknown option of {', '.join(names)}, expected one of "
                f"{', '.join(known)}, ground"
            )


def _opened(options: Mapping[str, Any], base: Path) -> dict[str, Any]:
    """Options with paths that can be opened."""
    opened = dict(options)
    if "assets" in opened:
        opened["assets"] = tuple(base / folder for folder in opened["assets"])
    if "model" in opened and opened["model"] not in MODELS:
        opened["model"] = str(base / opened["model"])
    return opened


def _texts(value: Any, what: str) -> tuple[str, ...]:
    """One text or several distinct texts, as a tuple."""
    texts = (value,) if isinstance(value, str) else value
    if not isinstance(texts, list | tuple) or not all(isinstance(t, str) and t for t in texts):
        raise InputError(f"{what}: found {shown(value)}, expected text or a list of texts")
    for k, text in enumerate(texts):
        if text in texts[:k]:
            raise InputError(f"{what}: found {text!r} twice, expected it once")
    return tuple(texts)

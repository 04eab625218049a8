"""Data model of the evidence: tasks that compute it, rows that set it beside the paper."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from halfphysics.base.validation import shown
from halfphysics.errors import InputError

Found = TypeVar("Found")

#: Kinds of data that a user may name: a folder of AIST++, of any motions, of any scenes.
DATA = ("aist", "clips", "scenes")


@dataclass(frozen=True, kw_only=True)
class Options:
    """The size of a run, its seed, and the data of the user.

    Attributes:
        quick: Fewer and shorter cases, in under two minutes.
        seed: Seed of all motions and rooms that are made.
        data: Folders of the user, by kind (`DATA`).

    Raises:
        InputError: The seed is no whole number, a kind of data is unknown, a folder is missing.
    """

    quick: bool = False
    seed: int = 0
    data: Mapping[str, Path] = field(default_factory=dict)
    _found: dict[str, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        whole = isinstance(self.seed, int) and not isinstance(self.seed, bool)
        if not whole or self.seed < 0:
            raise InputError(f"seed: found {shown(self.seed)}, expected a whole number from 0")
        for name, folder in self.data.items():
            if name not in DATA:
                raise InputError(f"data: found {name!r}, expected one of {', '.join(DATA)}")
            if not Path(folder).is_dir():
                raise InputError(f"data: {name}={folder}: there is no such folder")

    def once(self, name: str, look: Callable[[], Found]) -> Found:
        """The result of `look`, called once: files that appear or vanish in a folder of the user
        while the report is made do not change which rows it has."""
        if name not in self._found:
            self._found[name] = look()
        found: Found = self._found[name]
        return found


@dataclass(frozen=True, kw_only=True)
class Task:
    """A unit of work that runs in any process, in any order.

    Attributes:
        key: Its name within the section: letters, digits, spaces, "-", "_", "." and
            "/".
        function: "MODULE:NAME" of a function that returns an `Outcome`; ".runs.x" is a module of
            this package. The same arguments give the same values, bit for bit.
        arguments: Its arguments, as JSON values.
        inputs: Files of the user that it reads. An outcome is kept for their content; for a folder,
            for the names, sizes and dates of its files.
        seconds: Expected time on one core [s].
    """

    key: str
    function: str
    arguments: Mapping[str, Any] = field(default_factory=dict)
    inputs: tuple[str, ...] = ()
    seconds: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The result of a task: JSON values, and pictures (name -> PNG)."""

    values: Mapping[str, Any]
    pictures: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One measure of a row.

    Attributes:
        name: Name of the measure.
        unit: Its unit, "" for none.
        ours: Our value, None if there is none.
        paper: The value of the paper, None if it has none.
        expected: The condition on `ours`, in words; "" without one.
        reproduced: Whether the condition holds; None: shown, not judged.
        direction: The condition is the direction of the paper's finding and a smallest size, not
            its number.
    """

    name: str
    unit: str = ""
    ours: float | None
    paper: float | None = None
    expected: str = ""
    reproduced: bool | None = None
    direction: bool = False


@dataclass(frozen=True, kw_only=True)
class Row:
    """One row of a table: data, setting, figures.

    A `quoted` row holds numbers of the paper only, for a method that is not run here.
    """

    name: str
    data: str = ""
    setting: str = ""
    figures: tuple[Figure, ...]
    note: str = ""
    quoted: bool = False


@dataclass(frozen=True)
class Series:
    """One line, or one bar at each of `x`."""

    name: str
    x: Sequence[float | str]
    y: Sequence[float | None]


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A chart of series; `x` and `y` are (label, unit)."""

    title: str
    x: tuple[str, str]
    y: tuple[str, str]
    series: tuple[Series, ...]
    kind: Literal["lines", "bars"] = "lines"


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture that a task made."""

    caption: str
    task: str
    name: str


@dataclass(frozen=True, kw_only=True)
class Content:
    """The content of a section."""

    rows: tuple[Row, ...] = ()
    plots: tuple[Plot, ...] = ()
    pictures: tuple[Picture, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Section:
    """One table or figure of the paper.

    Attributes:
        key: What `--only` calls it.
        title: Its heading.
        about: What the paper shows there.
        tasks: The tasks that it needs.
        content: Its content, from the values of the tasks that succeeded, by key; failed tasks are
            reported elsewhere.
        timing: It measures speed, which depends on the machine: its tasks run alone, and its
            content goes into a file of its own.
    """

    key: str
    title: str
    about: str
    tasks: Callable[[Options], Sequence[Task]]
    content: Callable[[Options, Mapping[str, Any]], Content]
    timing: bool = False


def at_most(
    limit: float, ours: float | None, *, name: str, unit: str = "", paper: float | None = None
) -> Figure:
    """A figure that is reproduced where ours is at most `limit`."""
    good = None if ours is None else ours <= limit
    expected = f"at most {limit:g}"
    return Figure(name=name, unit=unit, ours=ours, paper=paper, expected=expected, reproduced=good)


def at_least(
    limit: float, ours: float | None, *, name: str, unit: str = "", paper: float | None = None
) -> Figure:
    """A figure that is reproduced where ours is at least `limit`; where the paper has a number and
    `limit` is less, its direction is confirmed."""
    good = None if ours is None else ours >= limit
    expected = f"at least {limit:g}"
    return Figure(
        name=name,
        unit=unit,
        ours=ours,
        paper=paper,
        expected=expected,
        reproduced=good,
        direction=paper is not None and limit < paper,
    )


def between(low: float, high: float, ours: float | None, *, name: str, unit: str = "") -> Figure:
    """A figure that is reproduced from `low` to `high`."""
    good = None if ours is None else low <= ours <= high
    expected = f"{low:g} to {high:g}"
    return Figure(name=name, unit=unit, ours=ours, expected=expected, reproduced=good)


def plain(value: Any, where: str) -> Any:
    """`value` as JSON values: numpy numbers become Python numbers, tuples become lists.

    Raises:
        InputError: NaN, infinity, or a type that JSON does not have.
    """
    if isinstance(value, Mapping):
        return {str(k): plain(v, f"{where}/{k}") for k, v in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(v, f"{where}/{i}") for i, v in enumerate(value)]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{where}: found {value}, expected a finite number or None")
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise InputError(f"{where}: found {shown(value)}, expected what JSON can say")


def to_dict(content: Content) -> dict[str, Any]:
    """The content of a section as plain values."""
    return {key: plain(value, key) for key, value in asdict(content).items()}

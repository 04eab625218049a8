"""What the evidence is made of: tasks that compute it, rows that set it beside the paper."""

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

#: What a user may bring: a folder of AIST++, of any motions, of any scenes.
DATA = ("aist", "clips", "scenes")


@dataclass(frozen=True, kw_only=True)
class Options:
    """What is to be shown, and on what.

    Attributes:
        quick: Fewer and shorter cases: whether it works, in under two minutes.
        seed: Of everything that is made from random numbers.
        data: Folders of the user's own, by `DATA`.

    Raises:
        InputError: A seed that is no whole number, another kind of data, no such folder.
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
        """What `look` finds in a folder of the user's, which is looked through once: files that
        come and go while a report is made do not change what its rows are of."""
        if name not in self._found:
            self._found[name] = look()
        found: Found = self._found[name]
        return found


@dataclass(frozen=True, kw_only=True)
class Task:
    """Work that can be done alone, in any order and in any process.

    Attributes:
        key: Its name within the section: letters, digits, spaces, "-", "_", "." and
            "/".
        function: "MODULE:NAME" of a function that returns an `Outcome`; ".runs.x" is a module of
            this package. The same arguments give the same values, bit for bit.
        arguments: Its arguments: what JSON can say.
        inputs: Files of the user that it reads; their content is part of what is remembered, of
            folders the names, sizes and dates of what is in them.
        seconds: About how long it takes on one core [s].
    """

    key: str
    function: str
    arguments: Mapping[str, Any] = field(default_factory=dict)
    inputs: tuple[str, ...] = ()
    seconds: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a task found: values that JSON can say, and pictures (name -> PNG)."""

    values: Mapping[str, Any]
    pictures: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One measure of a row.

    Attributes:
        name: Of the measure.
        unit: Its unit, "" for none.
        ours: What we found, None if there is nothing.
        paper: What the paper has, None if it says nothing.
        expected: What `ours` must be, in words; "" where nothing is expected.
        reproduced: Whether it is; None: shown, not judged.
    """

    name: str
    unit: str = ""
    ours: float | None
    paper: float | None = None
    expected: str = ""
    reproduced: bool | None = None


@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of a table: on which data, with which setting, which figures.

    `quoted` rows are of the paper alone, for methods that are not run here.
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
    """Series over one axis each way; `x` and `y` are (label, unit)."""

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
    """What a section shows."""

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
        tasks: The work that it needs.
        content: What it shows, from the values of the tasks that succeeded, by key; it says
            nothing of those that did not.
        timing: What it measures depends on the machine and the hour: it runs alone, and goes into
            a file of its own.
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
    """A figure that is reproduced where ours is at least `limit`."""
    good = None if ours is None else ours >= limit
    expected = f"at least {limit:g}"
    return Figure(name=name, unit=unit, ours=ours, paper=paper, expected=expected, reproduced=good)


def between(low: float, high: float, ours: float | None, *, name: str, unit: str = "") -> Figure:
    """A figure that is reproduced from `low` to `high`."""
    good = None if ours is None else low <= ours <= high
    expected = f"{low:g} to {high:g}"
    return Figure(name=name, unit=unit, ours=ours, expected=expected, reproduced=good)


def plain(value: Any, where: str) -> Any:
    """`value` as JSON says it: numpy's numbers as Python's, tuples as lists.

    Raises:
        InputError: NaN, infinity, or what JSON cannot say.
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
    """Plain values of what a section shows."""
    return {key: plain(value, key) for key, value in asdict(content).items()}

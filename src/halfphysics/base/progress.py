"""Progress bars: one way for every step that may take longer than two seconds.

A step says what it does with `bar` or `over`; who calls it decides whether it is shown, with
`progress=True` or `with halfphysics.progress():` around anything. Bars are on standard error where
that is a terminal, in notebooks widgets (where ipywidgets is installed, else nothing), and begin
after two seconds: short work says nothing.
"""

from __future__ import annotations

import sys
import threading
import warnings
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar

T = TypeVar("T")

#: What takes less is not shown [s].
DELAY = 2.0
#: Least time between two drawings [s].
_EVERY = 0.1
#: Between two drawings where nothing is done [s].
_TICK = 1.0

#: Whether bars are shown; None: nobody said.
_wanted: ContextVar[bool | None] = ContextVar("wanted", default=None)


@contextmanager
def progress(show: bool = True) -> Iterator[None]:
    """Show a progress bar of every step in the block that takes longer than two seconds.

    Args:
        show: False: show none, also where a step would show one unasked (the cutting of meshes).
    """
    before = _wanted.set(bool(show))
    try:
        yield
    finally:
        _wanted.reset(before)


@contextmanager
def asked(show: bool) -> Iterator[None]:
    """The block of a function with an argument `progress`: False leaves it to the caller's."""
    if not show:
        yield
        return
    with progress():
        yield


class _Shown:
    """A bar that is drawn anew each second: the time runs on in a call that takes minutes."""

    def __init__(self, drawn: Any) -> None:
        self._drawn = drawn
        self._over = threading.Event()
        self._ticks = threading.Thread(target=self._tick, name="halfphysics-bar", daemon=True)

    def __enter__(self) -> _Shown:
        self._ticks.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def update(self, count: float = 1) -> None:
        """So much more is done."""
        self._drawn.update(count)

    def close(self) -> None:
        """Take the bar away."""
        self._over.set()
        if self._ticks.ident is not None and self._ticks.is_alive():
            self._ticks.join()
        self._drawn.close()

    def _tick(self) -> None:
        wait = DELAY
        while not self._over.wait(wait):
            self._drawn.refresh()
            wait = _TICK


class NoBar:
    """A progress bar that does not show."""

    def __enter__(self) -> NoBar:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def update(self, count: float = 1) -> None:
        """Nothing to draw."""

    def close(self) -> None:
        """Nothing to remove."""


def bar(total: int, what: str, unit: str, *, unasked: bool = False) -> Any:
    """A bar, to be used in a `with` block and told by `update` how much more is done.

    Args:
        total: Number of units in all.
        what: What is being done, before the bar.
        unit: Of one of them, such as "frame".
        unasked: Whether it is shown where nobody said.
    """
    wanted = _wanted.get()
    kind = _kind() if (unasked if wanted is None else wanted) else None
    if kind is None:
        return NoBar()
    how = {"delay": DELAY, "mininterval": _EVERY, "leave": False}
    return _Shown(kind(total=total, desc=what, unit=f" {unit}", **how))


def over(parts: Collection[T], what: str, unit: str, *, size: int = 1) -> Iterator[T]:
    """The parts, one by one, with a bar that counts `size` units for each."""
    return _each(parts, bar(size * len(parts), what, unit), size)


def _each(parts: Collection[T], shown: Any, size: int) -> Iterator[T]:
    with shown:
        for part in parts:
            yield part
            shown.update(size)


def _kind() -> Any:
    """The class of bars for where this runs; None: nowhere to show one."""
    if "ipykernel" in sys.modules:
        return _of_notebook()
    if sys.stderr is None or not sys.stderr.isatty():
        return None
    from tqdm import tqdm

    return tqdm


def _of_notebook() -> Any:
    """Bars as widgets; None where ipywidgets is missing: lines would fill the cell."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # tqdm warns of the missing package
        from tqdm.auto import tqdm
        from tqdm.notebook import tqdm_notebook
    return tqdm if issubclass(tqdm, tqdm_notebook) else None

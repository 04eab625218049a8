"""The progress of a sweep: a bar at a terminal, otherwise a line every few seconds."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfphysics.sweep.run.engines import Death
    from halfphysics.sweep.run.work import Done, Task

_EVERY = 5.0  # time between lines without a terminal [s]


class Progress:
    """Counts variants and reports the counts on stderr.

    Args:
        bar: Whether to show a bar; None: if stderr is a terminal.
        say: Receives each line; None: write it to stderr.
    """

    def __init__(self, bar: bool | None = None, say: Callable[[str], None] | None = None) -> None:
        self.total = self.before = self.kept = self.skipped = self.failed = self.size = 0
        self.deaths = 0
        self._bar: Any = None
        self._say = _to_stderr if say is None else say
        self._wanted = sys.stderr.isatty() if bar is None else bar
        self._estimated = False
        self._start = self._said = time.monotonic()

    @property
    def done(self) -> int:
        """Number of finished variants, in this run and earlier ones."""
        return self.before + self._now

    @property
    def _now(self) -> int:
        return self.kept + self.skipped + self.failed

    def begin(self, variants: int) -> None:
        """Start the progress of a number of variants."""
        self.total = variants
        self._start = self._said = time.monotonic()
        if self._wanted:
            from tqdm import tqdm

            self._bar = tqdm(total=variants, unit=" variants", leave=False, smoothing=0.05)

    def found(self, variants: int) -> None:
        """Count variants that an earlier run finished."""
        self.before += variants
        if self._bar is not None and variants:
            # Variants of an earlier run must not change the estimated time left.
            self._bar.initial += variants
            self._bar.update(variants)

    def ended(self, task: Task, done: Done) -> None:
        """Count the variants of a finished task."""
        self.kept += done.kept
        self.skipped += done.skipped
        self.failed += len(done.causes)
        self.size += done.size
        if not done.variants:
            return
        if not self._estimated:
            self._estimated = True
            self._tell(self.estimate(done))
        if self._bar is not None:
            self._bar.set_postfix_str(f"{self.failed} failed" if self.failed else "", refresh=False)
            self._bar.update(done.variants)
        elif time.monotonic() - self._said >= _EVERY:
            self._tell(self.line())

    def died(self, task: Task, death: Death) -> None:
        """Report the death of a process."""
        self.deaths += 1
        what = {"batches": "batch", "variants": "variant", "seal": "shard"}[task.kind]
        number = task.shard if task.kind == "seal" else task.first
        self._tell(f"at {what} {number}: {death.cause}")

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def estimate(self, first: Done) -> str:
        """The estimated time and size of the sweep, from its first task."""
        left = self.total - self.before
        each = first.seconds / first.variants
        size = f", {bytes_text(left * first.size / first.variants)}" if first.size else ""
        return (
            f"{left} variants to make: the first took {each:.2g} s each, so that is "
            f"{time_text(left * each)} of work{size}"
        )

    def line(self) -> str:
        """The progress as a line."""
        rate = self._now / max(time.monotonic() - self._start, 1e-9)
        left = f", {time_text((self.total - self.done) / rate)} left" if rate else ""
        failed = f", {self.failed} failed" if self.failed else ""
        return f"{self.done}/{self.total} variants, {rate:.3g}/s{left}{failed}"

    def _tell(self, line: str) -> None:
        self._said = time.monotonic()
        if self._bar is not None:
            self._bar.write(line, file=sys.stderr)
        else:
            self._say(line)


def time_text(seconds: float) -> str:
    """A time in readable units."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 90.0 * 60.0:
        return f"{seconds / 60.0:.0f} min"
    hours = seconds / 3600.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"


def bytes_text(size: float) -> str:
    """A size in readable units."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000.0:
            return f"{size:.3g} {unit}"
        size /= 1000.0
    return f"{size:.3g} TB"


def _to_stderr(line: str) -> None:
    print(line, file=sys.stderr, flush=True)

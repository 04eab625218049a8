"""The evidence: every claim of the paper beside the number that this program computes.

`./run evidence` computes it and writes the report. This package belongs to the repository, not to
the wheel. A section of the report is a module of `sections`, named by its key, with a constant
`SECTION`, and one entry of `KEYS`. The tasks of a section (`runs`) run in worker processes, and
their outcomes are kept (`store`), so that an interrupted run continues where it stopped.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from evidence import document
from evidence.model import Options, Section
from evidence.page import html
from evidence.runner import Done, Job, run
from evidence.store import Store
from halfphysics.base.atomic import atomic_write
from halfphysics.errors import FileError, InputError

__all__ = ["KEYS", "Options", "Report", "listed", "make"]

#: Keys of the sections, which are modules of `sections`, in the order of the report.
KEYS = (
    "table1",
    "table2",
    "table3",
    "table4",
    "figures4and9",
    "figure5",
    "figures6and7",
    "figure8",
    "defaults",
    "pressures",
    "speed",
)

#: Files of a report, in its folder.
JSON, SPEED, PAGE, WORK = "paper.json", "paper-speed.json", "paper.html", "work"
_GONE = "what it found is gone: its files, or those in work, changed while the report was made"


@dataclass(frozen=True)
class Report:
    """A written report: `content` is what the file `JSON` holds, `speed` what `SPEED` holds."""

    folder: Path
    content: dict[str, Any]
    speed: dict[str, Any]


def listed(only: Sequence[str] = ()) -> list[Section]:
    """All sections, or those named.

    Raises:
        InputError: An unknown key.
    """
    for key in only:
        if key not in KEYS:
            raise InputError(f"only: unknown section {key!r}, expected one of {', '.join(KEYS)}")
    chosen = [key for key in KEYS if not only or key in only]
    return [importlib.import_module(f"{__name__}.sections.{key}").SECTION for key in chosen]


def make(
    folder: Path,
    options: Options | None = None,
    *,
    only: Sequence[str] = (),
    workers: int = 1,
    progress: Callable[[Iterator[Done], int, float], Iterator[Done]] | None = None,
) -> Report:
    """Compute what is missing and write the report.

    Args:
        folder: Folder of the report; outcomes that the same program computed there before are used.
        options: The size of the run, its seed and the data of the user.
        only: Keys of sections; none: all.
        workers: Number of processes. Timings always run one at a time.
        progress: Passes the finished jobs on and shows them; it also receives the number of jobs
            and their expected time on one core [s].

    Raises:
        InputError: Impossible options. FileError: The folder cannot be written.
    """
    options = replace(options or Options())  # a copy, which searches the folders of the user again
    chosen = listed(only)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{folder}: cannot make this folder: {error.strerror}") from None
    store = Store(folder / WORK)
    failed = _compute(store, options, chosen, workers, progress)
    timed = [s for s in chosen if s.timing]
    stable = [s for s in chosen if not s.timing]
    content = document.document(options, _entries(store, options, stable, failed))
    speed = document.document(options, _entries(store, options, timed, failed))
    speed["machine"] = document.machine()
    _write(folder / JSON, _json(content))
    _write(folder / SPEED, _json(speed))
    _write(folder / PAGE, html.build(content, speed, store.picture).encode())
    return Report(folder, content, speed)


def _compute(
    store: Store,
    options: Options,
    chosen: Sequence[Section],
    workers: int,
    progress: Any,
) -> dict[tuple[str, str], str]:
    """Run the missing tasks; returns the causes of failures by section and task."""
    missing: dict[bool, list[Job]] = {False: [], True: []}
    for section in chosen:
        for task in section.tasks(options):
            if store.load(section.key, task) is None:
                missing[section.timing].append(Job(section.key, task))
    jobs = [*missing[False], *missing[True]]

    def doing() -> Iterator[Done]:
        yield from run(store.folder, missing[False], workers)
        # Timings have the machine for themselves.
        yield from run(store.folder, missing[True], 1)

    done = doing()
    if progress is not None:
        done = progress(done, len(jobs), sum(job.task.seconds for job in jobs))
    return {(d.job.section, d.job.task.key): d.cause for d in done if d.cause}


def _entries(
    store: Store,
    options: Options,
    chosen: Sequence[Section],
    failed: dict[tuple[str, str], str],
) -> list[dict[str, Any]]:
    entries = []
    for section in chosen:
        causes = {key: cause for (name, key), cause in failed.items() if name == section.key}
        values = {}
        for task in section.tasks(options):
            if task.key in causes:
                continue
            found = store.load(section.key, task)
            if found is None:
                causes[task.key] = _GONE
            else:
                values[task.key] = found
        entries.append(document.entry(section, options, values, causes))
    return entries


def _json(content: dict[str, Any]) -> bytes:
    return (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode()


def _write(path: Path, content: bytes) -> None:
    with atomic_write(path) as handle:
        handle.write(content)

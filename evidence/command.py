"""The command line of the evidence: `./run evidence [options]`, or `python -m evidence`."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli import guarded
from halfphysics.cli.options import progress
from halfphysics.cli.parsing import Exit, parse
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from evidence.runner import Done

#: The command as a user types it.
PROGRAM = "./run evidence"
EXAMPLES = """\
./run evidence --quick
./run evidence --out out/report
./run evidence --only table1 --data aist=/data/aist_plusplus
./run evidence --only table2 --data scenes=/data/rooms"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Make the report: paper.html, paper.json and paper-speed.json (what depends on the machine).

    It makes its motions and scenes itself, and takes yours where --data names them.
    An interrupted run continues where it stopped: outcomes are kept in FOLDER/work.
    """

    out: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")] = Path("out/paper")
    """Folder to write into; made if it is not there."""
    quick: bool = False
    """Fewer and shorter cases: under two minutes instead of under an hour."""
    only: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, tyro.conf.arg(metavar="KEY")] = ()
    """A part of the report: table1, table2, table3, table4, figures4and9, figure5, figures6and7,
    figure8, defaults, pressures or speed; repeat it for more parts, all parts by default."""
    data: Annotated[
        tuple[str, ...], tyro.conf.UseAppendAction, tyro.conf.arg(metavar="KIND=FOLDER")
    ] = ()
    """Data of your own: aist=DIR (AIST++), clips=DIR (any motions), scenes=DIR (any scenes)."""
    seed: int = 0
    """Seed of the scenes and motions that are made."""
    jobs: int | None = None
    """Number of processes; one per core by default. The numbers are the same for any value."""

    def run(self) -> None:
        """Compute, write, print."""
        import evidence
        from evidence.page import text

        if self.jobs is not None and self.jobs < 1:
            raise InputError(f"--jobs: found {self.jobs}, expected at least 1")
        start = time.perf_counter()
        report = evidence.make(
            self.out,
            evidence.Options(quick=self.quick, seed=self.seed, data=self._folders()),
            only=self.only,
            workers=self.jobs or os.cpu_count() or 1,
            progress=_shown,
        )
        encoding = sys.stdout.encoding
        print(text.summary(report.content, encoding=encoding))
        if report.speed["sections"]:
            print(f"\n{text.summary(report.speed, encoding=encoding)}")
        for name in (evidence.PAGE, evidence.JSON, evidence.SPEED):
            print(f"written: {report.folder / name}")
        print(f"in {time.perf_counter() - start:.0f} s")

    def _folders(self) -> dict[str, Path]:
        found: dict[str, Path] = {}
        for given in self.data:
            kind, sign, folder = given.partition("=")
            if not sign or not folder:
                raise InputError(f"--data: found {given!r}, expected KIND=FOLDER, as in aist=DIR")
            if kind in found:
                raise InputError(f"--data: found {kind} twice, expected one folder of a kind")
            found[kind] = Path(folder)
        return found


def main(argv: Sequence[str] | None = None) -> int:
    """Make the report; returns the exit code, as `halfphysics.cli.main` does."""
    return guarded(lambda: _run(list(sys.argv[1:] if argv is None else argv)), PROGRAM)


def _run(arguments: list[str]) -> int:
    command = parse(Command, PROGRAM, EXAMPLES, arguments)
    if isinstance(command, Exit):
        return command.code
    command.run()
    return 0


def _shown(done: Iterator[Done], count: int, seconds: float) -> Iterator[Done]:
    """A progress bar at a terminal, elsewhere a line per task; failures are reported at once."""
    from tqdm import tqdm

    with tqdm(total=round(seconds, 1), unit="s", disable=not progress(), leave=False) as bar:
        for number, one in enumerate(done, 1):
            job = one.job
            name = f"{job.section} {job.task.key}"
            bar.set_description(f"{number}/{count} {name}")
            bar.update(round(job.task.seconds, 1))
            if one.cause:
                tqdm.write(f"{name}: failed: {one.cause}", file=sys.stderr)
            elif not progress():
                print(f"{number}/{count} {name}: {one.seconds:.1f} s", file=sys.stderr)
            yield one

"""halfphysics sweep: simulate variants of many clips, into a labelled data set."""

from __future__ import annotations

import contextlib
import shlex
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from halfphysics.base.validation import number
from halfphysics.cli.loudness import is_quiet
from halfphysics.cli.options import check_room
from halfphysics.cli.parsing import Exit, parse
from halfphysics.cli.wording import spoken
from halfphysics.errors import HalfPhysicsError, InputError

if TYPE_CHECKING:
    from halfphysics.sweep.plan.plan import Plan
    from halfphysics.sweep.run.engines import Engine
    from halfphysics.sweep.run.progress import Progress
    from halfphysics.sweep.store.store import Store

EXAMPLES = """\
halfphysics sweep plan.yaml --dry-run
halfphysics sweep plan.yaml --out data --jobs 4
halfphysics sweep plan.yaml --out data --verify 20
halfphysics sweep plan.yaml --engine ray --address auto"""

#: Number of samples that --verify computes again by default.
VERIFIED = 10
#: Largest number of shards for which a stopped sweep still writes its manifest: it is quick.
_QUICK = 1000


def read(prog: str, arguments: Sequence[str]) -> Command | Exit:
    """The command that the arguments describe; --verify needs no number."""
    given = list(arguments)
    for place, word in enumerate(given):
        following = given[place + 1 : place + 2]
        if word == "--verify" and not (following and following[0].lstrip("-").isdigit()):
            given[place] = f"--verify={VERIFIED}"
    return parse(Command, prog, EXAMPLES, given)


@dataclass(frozen=True, kw_only=True)
class Command:
    """Simulate every variant of a plan: inputs x bodies x scenes x factors (docs/sweeps.md).

    Stop it and start it again, however it ended: what is done is kept, and the data comes out the
    same to the last byte. Variants that fail are listed with their cause; the rest goes on.
    """

    plan: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="PLAN")]
    """What to do, as a .yaml or .json file."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")] = None
    """Folder to write into instead of the plan's; made if it is not there."""
    engine: Literal["local", "ray"] = "local"
    """What works: processes of this machine, or a cluster."""
    jobs: int | None = None
    """Processes to work in; one per core if not said. The output is identical for any value."""
    memory: Annotated[float | None, tyro.conf.arg(metavar="GIB")] = None
    """Memory for all processes together [GiB]; 80 % of the machine's if not said."""
    limit: Annotated[float | None, tyro.conf.arg(metavar="SECONDS")] = None
    """What a variant may take; one that takes longer fails. As long as it takes if not said."""
    address: Annotated[str | None, tyro.conf.arg(metavar="RAY")] = None
    """Of --engine ray: the cluster (auto, HOST:PORT or ray://HOST:PORT)."""
    dry_run: bool = False
    """Only show what would be done, and set up some variants to see whether they can be made."""
    verify: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """Make so many samples of a finished sweep again and compare them bit by bit; 10 if it does not
    say how many."""
    retry_failed: bool = False
    """Try the variants that failed again."""
    remake: bool = False
    """Make again what another version of the program made; without it such a folder is refused."""

    def run(self) -> None:
        """Show the plan, run it, print the summary."""
        from halfphysics.sweep import Plan, Variants, describe
        from halfphysics.sweep.plan.plan import resolve_inputs

        self._check()
        plan = Plan.load(self.plan)
        folder = plan.folder if self.out is None else self.out
        if self.verify is not None:
            self._verify(plan, folder, self.verify)
            return
        # The data is identical for any --out: only the printed text has the folder.
        shown = replace(plan, outputs=replace(plan.outputs, folder=str(folder.absolute())))
        variants = Variants(plan, resolve_inputs(plan, folder))
        check_room(next(p for p in (folder, *folder.absolute().parents) if p.is_dir()), folder)
        if self.dry_run:
            from halfphysics.sweep.make.rehearsal import rehearse

            told = rehearse(plan, variants)
            print(f"{describe(shown, variants)}\ntrial     {spoken(str(told))}")
        else:
            print(describe(shown, variants))
            sys.stdout.flush()
            self._sweep(plan, folder)

    def _check(self) -> None:
        modes = {
            "--dry-run": self.dry_run,
            "--verify": self.verify is not None,
            "--retry-failed": self.retry_failed,
        }
        chosen = [name for name, given in modes.items() if given]
        if len(chosen) > 1:
            raise InputError(f"{' and '.join(chosen)}: expected one of these at a time")
        if self.address is not None and self.engine != "ray":
            raise InputError("--address: is for --engine ray, found --engine local")
        for name, count in (("jobs", self.jobs), ("verify", self.verify)):
            if count is not None and count < 1:
                raise InputError(f"--{name}: found {count}, expected at least 1")
        if self.memory is not None:
            self._check_memory(self.memory, works=not chosen or self.retry_failed)
        if self.limit is not None:
            from halfphysics.sweep.make.time_limit import check_limit, check_possible

            check_limit(self.limit, "--limit")
            check_possible()

    def _check_memory(self, memory: float, works: bool) -> None:
        """That there can be this memory [GiB], and where this machine `works`, that it has it."""
        if not works or self.engine != "local":
            number(memory, "--memory", above=0.0, unit="GiB")
            return
        from halfphysics.sweep.run.local import shares

        try:
            shares(self.jobs, memory)
        except InputError as error:
            raise InputError(f"--{error}") from None

    def _verify(self, plan: Plan, folder: Path, count: int) -> None:
        from halfphysics.sweep.report.verify import verify
        from halfphysics.sweep.store.fixed_plan import check_plan

        check_plan(folder, plan)
        print(spoken(str(verify(folder, count))))

    def _sweep(self, plan: Plan, folder: Path) -> None:
        from halfphysics.sweep.report.summary import summary
        from halfphysics.sweep.run.driver import SweepError, run
        from halfphysics.sweep.run.progress import Progress
        from halfphysics.sweep.store.store import Store

        progress = Progress(False, lambda line: None) if is_quiet() else Progress()
        with contextlib.ExitStack() as stack:
            stack.enter_context(_ended_like_by_ctrl_c())
            store = stack.enter_context(Store(folder, plan, remake=self.remake))
            if self.retry_failed:
                print(f"{store.drop_failed()} variants failed and are tried again")
            engine = self._engine(folder)
            stack.callback(progress.close)
            stack.callback(engine.close)
            try:
                report = run(store, engine, progress, limit=self.limit)
            except KeyboardInterrupt:
                engine.close()
                progress.close()
                print(f"stopped: {self._how_far(progress)}", file=sys.stderr)
                _list_what_there_is(store)
                raise
            except SweepError as error:
                raise SweepError(f"{error}\n{self._how_far(progress)}") from None
        print(spoken(summary(report)))
        if report.failures and not report.samples:
            raise SweepError(
                f"{folder}: no sample came of it, {report.failures} variants failed. See "
                f"{folder / 'failures.jsonl'}, and --retry-failed once that is mended"
            )
        print(f"next     {self._again('--verify')}")

    def _engine(self, folder: Path) -> Engine:
        if self.engine == "local":
            from halfphysics.sweep.run.local import LocalEngine

            return LocalEngine(folder, self.jobs, self.memory)
        from halfphysics.sweep.run.ray_engine import RayEngine

        return RayEngine(folder, self.jobs, self.memory, address=self.address)

    def _how_far(self, progress: Progress) -> str:
        """The number of finished variants, and the command to continue."""
        of = f" of {progress.total}" if progress.total else ""
        return f"{progress.done}{of} variants are done. To go on: {self._again()}"

    def _again(self, *more: str) -> str:
        words = ["halfphysics", "sweep", str(self.plan)]
        for name in ("out", "jobs", "memory", "limit", "address"):
            value: Any = getattr(self, name)
            if value is not None and (name == "out" or "--verify" not in more):
                words += [f"--{name}", str(value)]
        if self.remake and "--verify" not in more:
            words += ["--remake"]
        if self.engine != "local" and "--verify" not in more:
            words += ["--engine", self.engine]
        return shlex.join([*words, *more])


def _list_what_there_is(store: Store) -> None:
    """Write manifest and card of a stopped sweep if that is quick."""
    if store.layout.shards <= _QUICK:
        with contextlib.suppress(HalfPhysicsError):  # the sweep ends in any case
            store.finish()


@contextlib.contextmanager
def _ended_like_by_ctrl_c() -> Iterator[None]:
    """Handle a request to end (SIGTERM, as job systems send it) like Ctrl-C."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)

"""A live session over minutes: latency, watchers, faults.

    PYTHONPATH=src:tests python -m campaigns.live latency|watchers|faults [--minutes 10] [--busy]
        [--count 100]

`halfphysics serve` runs the demo's scene in a process of its own; a client in this one moves two
people through it at 90 Hz, and waits for every pose to come back corrected. `watchers` adds
clients that watch, `faults` a process that does `--count` things wrong. `--busy` keeps the other
core busy. Prints the figures and what is over its limit; exits with 1 if anything is.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import time
from dataclasses import dataclass

import numpy as np

from support.live import watchers
from support.live.driver import Driven, drive
from support.live.faults import provoke
from support.live.process import ServerProcess, busy

#: Limits of latency [ms]: median, 99 of 100, worst; with watchers the 99 of 100 alone.
ALONE, WATCHED = (2.0, 5.0, 20.0), (np.inf, 10.0, np.inf)
#: Growth of the server's memory that is none: buffers and the allocator's own [MB].
MEMORY = 20.0
#: Seconds for everything to start, and until memory is first looked at.
_STARTS = 3.0


@dataclass
class Run:
    """What one run gave.

    Attributes:
        driven: Latencies.
        limits: Those of `ALONE` or `WATCHED`.
        grown: Growth of the server's memory [MB].
        files: Growth of its open files and sockets.
        notes: More to print.
        unanswered: Wrong messages that got no error.
    """

    driven: Driven
    limits: tuple[float, float, float]
    grown: float
    files: int
    notes: list[str]
    unanswered: int = 0

    def complaints(self, speed: bool = True) -> list[str]:
        """What is over its limit; without `speed` only what does not depend on the machine."""
        said = []
        if self.grown > MEMORY:
            said.append(f"memory grew by {self.grown:.1f} MB, limit {MEMORY:g}")
        if self.files > 3:
            said.append(f"{self.files} more files are open")
        if self.unanswered:
            said.append(f"{self.unanswered} wrong messages got no error")
        if speed and self.driven.seconds:
            found = 1000.0 * np.percentile(self.driven.seconds, [50, 99, 100])
            for name, value, most in zip(("p50", "p99", "worst"), found, self.limits, strict=True):
                if value > most:
                    said.append(f"{name} {value:.2f} ms, limit {most:g} ms")
        return said


def run(
    what: str, seconds: float, count: int, keep_busy: bool = False, starts: float = _STARTS
) -> Run:
    """One run of a kind: "latency", "watchers" or "faults"; `starts`: seconds before it counts."""
    notes: list[str] = []
    unanswered = 0
    with ServerProcess("doorway", "--people", "2") as server:
        others = busy(seconds + 2 * starts) if keep_busy else None
        drive(server.url, starts)  # everything has been done once
        memory, files = server.memory, server.open_files
        if what == "watchers":
            looking = watchers.watchers(server.url, count, seconds + starts)
            time.sleep(starts)
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            if what == "faults":
                wrong = pool.apply_async(provoke, (server.url, count))
                time.sleep(min(starts, 1.0))
            driven = drive(server.url, seconds)
            if what == "faults":
                done = wrong.get()
                unanswered = done.pop("unanswered", 0)
                notes.append(f"{done.total()} things done wrong: {dict(sorted(done.items()))}")
        if what == "watchers":
            seen = watchers.figures(looking)
            notes.append(
                f"{count} watchers: {seen['rate']:.1f} frames/s each, their frames p50 "
                f"{1000.0 * seen['p50']:.2f} ms, p99 {1000.0 * seen['p99']:.2f} ms old"
            )
        time.sleep(0.5)
        grown, opened = server.memory - memory, server.open_files - files
        if others is not None:
            others.kill()
            others.wait()
    notes.append(f"memory {memory:.1f} MB, {grown:+.1f} MB; {opened:+d} open files")
    notes.append(server.said.strip().splitlines()[-1])
    limits = ALONE if what == "latency" else WATCHED
    return Run(driven, limits, grown, opened, notes, unanswered)


def main() -> int:
    """Run what the command line asks for; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("latency", "watchers", "faults"))
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--count", type=int, default=None, help="watchers, or faults")
    parser.add_argument("--busy", action="store_true", help="keep the other core busy")
    given = parser.parse_args()
    count = given.count or {"latency": 0, "watchers": 100, "faults": 10_000}[given.what]
    found = run(given.what, 60.0 * given.minutes, count, given.busy)
    print(found.driven.figures())
    print("\n".join(found.notes))
    said = found.complaints()
    print("\n".join(said) or "all within their limits")
    return bool(said)


if __name__ == "__main__":
    sys.exit(main())

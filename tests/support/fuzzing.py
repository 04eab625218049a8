"""How long to fuzz: a few cases, the same ones each time, or ever new ones for as long as is asked.

`HALFPHYSICS_FUZZ=SECONDS` lets every kind of test go on for so long. What it has seen is counted
and printed at the end. No case is lost: each is in a file of `UNDER_WAY` from before it begins
until it has passed, so that it is still there after a crash, or an interruption; one
that fails is said at once, and reported as it was found: nothing is made smaller.
"""

from __future__ import annotations

import functools
import inspect
import os
import secrets
import sys
import time
from collections import Counter

from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.errors import UnsatisfiedAssumption

from support.paths import ROOT

#: Of every kind of test [s]; 0: the few cases that always run.
SECONDS = float(os.environ.get("HALFPHYSICS_FUZZ", 0.0))
#: Cases of one seed.
BATCH = 5
#: Where random cases are that have begun and not passed, a file for each process.
UNDER_WAY = ROOT / "build" / "fuzz"
#: Runs, frames and committed poses that were judged, all from clear starts, and in how many of the
#: runs something was inside or crossed. By what is kept clear.
seen = {}


def drawn(few):
    """Decorates a hypothesis test: `few` cases, or new ones until `SECONDS` are over."""

    def decorate(test):
        # Runs are too slow to be made smaller.
        phases = (Phase.explicit, Phase.reuse, Phase.generate)
        shared = {"deadline": None, "suppress_health_check": list(HealthCheck), "phases": phases}
        if SECONDS == 0.0:
            return settings(max_examples=few, derandomize=True, **shared)(test)
        name = test.__qualname__.replace(".<locals>", "")
        test.hypothesis.inner_test = noted(test.hypothesis.inner_test, name)
        test = settings(max_examples=BATCH, print_blob=True, **shared)(test)

        def run(*args, **kwargs):
            for _ in moments():
                seed(secrets.randbits(64))(test)(*args, **kwargs)

        run.__name__, run.__doc__ = test.__name__, test.__doc__
        run.__signature__ = inspect.signature(test)
        return run

    return decorate


def noted(test, name):
    """The test, whose arguments are in a file until it has passed, and are said where it fails."""

    @functools.wraps(test)
    def run(*args, **kwargs):
        case = ", ".join(f"{key}={value!r}" for key, value in kwargs.items())
        UNDER_WAY.mkdir(parents=True, exist_ok=True)
        file = UNDER_WAY / f"{name}-{os.getpid()}.txt"
        file.write_text(f"@example({case})\n", encoding="utf-8")
        try:
            test(*args, **kwargs)
        except UnsatisfiedAssumption:
            file.unlink()
            raise
        except Exception as error:
            # Past what pytest captures.
            print(f"\n{name}: {error!r:.300}\n@example({case})", file=sys.__stderr__, flush=True)
            raise
        file.unlink()

    return run


def moments():
    """0, 1, 2, ... until `SECONDS` are over; at least 0."""
    end, k = time.monotonic() + SECONDS, 0
    while k == 0 or time.monotonic() < end:
        yield k
        k += 1


def count(contact, frames, clear):
    """One run has been judged: `frames`, of which the first may be the start."""
    seen.setdefault(contact, Counter()).update(
        runs=1,
        frames=sum(len(f.substeps) > 0 for f in frames),
        poses=sum(len(f.substeps) for f in frames),
        penetrations=not clear,
    )


def report():
    """Lines of what was seen, one for each contact."""
    return [
        f"{contact}: {n['frames']} frames, {n['poses']} committed poses in {n['runs']} runs from "
        f"clear starts; penetrations in {n['penetrations']} runs"
        for contact, n in sorted(seen.items())
    ]

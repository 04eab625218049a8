"""How long to fuzz: a few cases, the same ones each time, or new ones for a requested time.

`HALFPHYSICS_FUZZ=SECONDS` lets every kind of test go on for so long. Its runs are counted
and printed at the end. No case is lost: each is in a file of `UNDER_WAY` from before it begins
until it has passed, so that it survives a crash, or an interruption; one
that fails is printed at once, and reported as it was found, without shrinking.
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

#: Time for every kind of test [s]; 0: the few cases that always run.
SECONDS = float(os.environ.get("HALFPHYSICS_FUZZ", 0.0))
#: Cases of one seed.
BATCH = 2
#: Folder of random cases that have begun and not passed, a file for each process.
UNDER_WAY = ROOT / "build" / "fuzz"
#: Judged runs, frames and committed poses, all from clear starts, and the number of runs with a
#: penetration or a crossing. By the surface that is kept clear.
seen = {}


def drawn(few):
    """Decorates a hypothesis test: `few` cases, or new ones until `SECONDS` are over."""

    def decorate(test):
        # Runs are too slow for shrinking.
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
    """The test, with its arguments in a file until it has passed, and printed if it fails."""

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
            # Print past pytest's capture.
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
    """Count a judged run of `frames`, the first of which may be the start."""
    seen.setdefault(contact, Counter()).update(
        runs=1,
        frames=sum(len(f.substeps) > 0 for f in frames),
        poses=sum(len(f.substeps) for f in frames),
        penetrations=not clear,
    )


def report():
    """Lines of the counts, one for each contact."""
    return [
        f"{contact}: {n['frames']} frames, {n['poses']} committed poses in {n['runs']} runs from "
        f"clear starts; penetrations in {n['penetrations']} runs"
        for contact, n in sorted(seen.items())
    ]

"""How long to fuzz: a few cases, the same ones each time, or ever new ones for as long as is asked.

`HALFPHYSICS_FUZZ=SECONDS` lets every kind of test go on for so long. What it has seen is counted
and printed at the end.
"""

from __future__ import annotations

import inspect
import os
import secrets
import time
from collections import Counter

from hypothesis import HealthCheck, Phase, seed, settings

#: Of every kind of test [s]; 0: the few cases that always run.
SECONDS = float(os.environ.get("HALFPHYSICS_FUZZ", 0.0))
#: Cases of one seed.
BATCH = 5
#: Runs, frames and committed poses that were judged, all from clear starts, and in how many of the
#: runs something was inside or crossed. By what is kept clear.
seen = {}


def drawn(few):
    """Decorates a hypothesis test: `few` cases, or new ones until `SECONDS` are over.

    A failing case is made smaller where there is time for it, and printed as code.
    """

    def decorate(test):
        shared = {"deadline": None, "suppress_health_check": list(HealthCheck)}
        if SECONDS == 0.0:
            # Runs are too slow to be made smaller in passing.
            phases = (Phase.explicit, Phase.reuse, Phase.generate)
            return settings(max_examples=few, phases=phases, derandomize=True, **shared)(test)
        test = settings(max_examples=BATCH, print_blob=True, **shared)(test)

        def run(*args, **kwargs):
            for _ in moments():
                seed(secrets.randbits(64))(test)(*args, **kwargs)

        run.__name__, run.__doc__ = test.__name__, test.__doc__
        run.__signature__ = inspect.signature(test)
        return run

    return decorate


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

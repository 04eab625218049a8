"""Sets up some variants of a sweep without simulating them: finds factors that are impossible.

A plan is checked as it is read for what its text alone says. What its scenes have in them, which
options a scenario takes together, how short a clip becomes: only making a variant tells.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice, takewhile

from halfphysics.body.match import check_match
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning, InputError
from halfphysics.sweep.make.vary import Workshop
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.plan.values import Value
from halfphysics.sweep.plan.variants import Variant, Variants

#: Most variants that are set up; of larger sweeps, extremes of each factor in a few scenes.
MOST = 48
#: Most values of one factor, and most combinations of input, body and scene in that case.
_VALUES, _GROUNDS = 6, 6
#: No new variant is set up after this time [s].
_SECONDS = 30.0
#: Most variants to which the conditions are applied if they leave out all of those.
_SCANNED = 100_000


@dataclass(frozen=True)
class Rehearsal:
    """What setting up variants told.

    Attributes:
        tried: Number of variants; 0 if conditions leave out all that were looked at.
        failed: Causes of those that cannot be made, though others of the same factors can.
    """

    tried: int
    failed: tuple[str, ...] = ()

    def __str__(self) -> str:
        if not self.tried:
            return "no variant set up: the plan's conditions (keep) leave out all that were tried"
        if not self.failed:
            return f"{self.tried:,} variants set up on trial, all can be made"
        causes = "\n  ".join(dict.fromkeys(self.failed))
        return f"{self.tried:,} variants set up on trial, {len(self.failed)} cannot:\n  {causes}"


def rehearse(plan: Plan, variants: Variants) -> Rehearsal:
    """Set up variants of a plan, at the extremes of its factors.

    Raises:
        InputError: No variant can be made, or none with a certain value of a factor.
    """
    workshop, tried = Workshop(plan), list[tuple[Variant, str]]()
    end = time.monotonic() + _SECONDS
    for choose in (_chosen, _scanned):
        if tried:
            break
        for variant in islice(filter(variants.keeps, choose(plan, variants)), MOST):
            tried.append((variant, _cause(workshop, variant)))
            if time.monotonic() > end:
                break
    failed = [(variant, cause) for variant, cause in tried if cause]
    if tried and len(failed) == len(tried):
        raise InputError(failed[0][1])
    for variant, cause in failed:
        name = cause.partition(":")[0]
        if name not in variant.factors:
            continue
        value = variant.factors[name]
        same = [why for one, why in tried if one.factors[name] == value]
        if all(why.startswith(f"{name}:") for why in same):
            raise InputError(cause)
    return Rehearsal(len(tried), tuple(cause for _, cause in failed))


def _cause(workshop: Workshop, variant: Variant) -> str:
    """Why a variant cannot be made; empty if it can."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)  # of each variant when it is made
        try:
            ready = workshop.make(variant)
            for motion, body in zip(ready.motions, ready.bodies, strict=True):
                check_match(motion, body, allow_mismatch=ready.allow_mismatch)
        except HalfPhysicsError as error:
            return _of_factor(str(error), variant)
    return ""


def _of_factor(cause: str, variant: Variant) -> str:
    """A cause with the name of its factor first: settings and options are named without group."""
    found = {}
    for name, value in variant.factors.items():
        for form in (name, name.rpartition(".")[2], f"Settings.{name.rpartition('.')[2]}"):
            if cause.startswith((f"{form}:", f"{form} ")):
                found[name] = (_shown(value) in cause, cause[len(form) :].lstrip(": "))
    if not found:
        return cause
    # Two factors of one last word, as scenario.fps and motion.fps: the one whose value is told.
    name = max(found, key=lambda name: found[name][0])
    return f"{name}: {found[name][1]}"


def _shown(value: Value) -> str:
    """A value of a factor as messages write it."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _chosen(plan: Plan, variants: Variants) -> Iterator[Variant]:
    """All variants of a small sweep; of a large one, each factor at its extremes."""
    if len(variants) <= MOST:
        yield from variants
        return
    grounds: list[Variant] = []
    for variant in map(variants.__getitem__, variants.sample(8 * _GROUNDS)):
        at = variant.input.name, variant.body.name, variant.scene.name
        if at not in [(v.input.name, v.body.name, v.scene.name) for v in grounds]:
            grounds.append(variant)
    grounds = grounds[:_GROUNDS]
    yield from grounds
    for name, values in plan.factors.items():
        extremes = values.extremes()
        if len(extremes) > _VALUES:
            extremes = (*extremes[: _VALUES // 2], *extremes[-_VALUES // 2 :])
        for value in extremes:
            for variant in grounds:
                yield replace(variant, factors={**variant.factors, name: value})


def _scanned(plan: Plan, variants: Variants) -> Iterator[Variant]:
    """Of many variants at random those that the conditions keep, evenly spread."""
    end = time.monotonic() + _SECONDS
    looked_at = takewhile(lambda _: time.monotonic() < end, variants.sample(_SCANNED))
    kept = [n for n in looked_at if variants.keeps(variants[n])]
    count = min(MOST, len(kept))
    yield from (variants[kept[k * len(kept) // count]] for k in range(count))

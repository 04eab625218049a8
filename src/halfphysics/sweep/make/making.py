"""One variant, from its number to the files of its sample or the cause of its failure."""

from __future__ import annotations

import os
import traceback
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning
from halfphysics.sweep.make.card import card_of, plain
from halfphysics.sweep.make.contact_exports import other_labels
from halfphysics.sweep.make.sample import files_of
from halfphysics.sweep.make.time_limit import OutOfTimeError, time_limit
from halfphysics.sweep.make.vary import Workshop
from halfphysics.sweep.plan.plan import OF_RESULT, OF_SUPPORT

if TYPE_CHECKING:
    from halfphysics.sweep.plan.plan import Plan
    from halfphysics.sweep.plan.variants import Variant, Variants

BUG = "(a bug: the traceback is on stderr)"


@dataclass(frozen=True)
class Sample:
    """A simulated variant: its card, its files and its input files (path -> hash).

    A sample without files was left out by a condition of the plan.
    """

    card: Mapping[str, Any]
    files: Mapping[str, bytes]
    inputs: Mapping[str, str] = field(default_factory=dict)


class Maker:
    """Makes the samples of a plan one by one; no sample depends on those before it."""

    def __init__(self, plan: Plan, variants: Variants) -> None:
        self._plan, self._variants = plan, variants
        self._workshop = Workshop(plan)
        self._told: set[tuple[str, str, int | None]] = set()
        self._keep_after = plan.expressions("keep_after")

    def sample(self, number: int, limit: float | None = None) -> Sample | dict[str, Any] | None:
        """A sample, a failure (plain values: number, input, factors, cause), or None: left out.

        A variant that takes longer than `limit` [s] or raises an exception is a failure. For a bug
        (no error of the input), the traceback is written to stderr once. Only `MemoryError` is
        raised.
        """
        variant: Variant | None = None
        try:
            variant = self._variants[number]
            if not self._variants.keeps(variant):
                return None
            with time_limit(limit), warnings.catch_warnings():
                # The card has the information of these warnings.
                warnings.simplefilter("ignore", HalfPhysicsWarning)
                return self._made(variant)
        except MemoryError:
            raise
        except OutOfTimeError:
            # The interrupted work may be incomplete, so nothing of it is used again.
            self._workshop = Workshop(self._plan)
            return failure(number, variant, f"it took longer than {limit:g} s (--limit)")
        except HalfPhysicsError as error:
            return failure(number, variant, self._cause(error))
        except Exception as error:
            self._tell(error)
            cause = f"{type(error).__name__}: {self._cause(error)} {BUG}"
            return failure(number, variant, cause)

    def _tell(self, error: Exception) -> None:
        """Print the traceback of a bug, once per place: a million variants may raise the same."""
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = (type(error).__name__, last.filename, last.lineno)
        if place not in self._told:
            self._told.add(place)
            traceback.print_exception(error)

    def lost(self, number: int, cause: str) -> dict[str, Any]:
        """The failure of a variant that is not made because it kills its process."""
        try:
            return failure(number, self._variants[number], cause)
        except HalfPhysicsError:
            return failure(number, None, cause)

    def _cause(self, error: Exception) -> str:
        """The message of an error, independent of the folder of the plan and its files."""
        base = self._plan.base
        return str(error).replace(f"{base}{os.sep}", "") if base.parts else str(error)

    def _made(self, variant: Variant) -> Sample:
        from halfphysics.labels import contact_labels
        from halfphysics.labels.events import events

        ready = self._workshop.make(variant)
        result = self._workshop.run(ready)
        labels = contact_labels(result, threshold=self._plan.labels.threshold)
        card = card_of(self._plan, variant, ready, result, labels, events(result))
        values = {**variant.values(), **{name: card[name] for name in (*OF_RESULT, *OF_SUPPORT)}}
        inputs = {source["path"]: source["sha256"] for source in ready.sources}
        if not all(holds(values) for holds in self._keep_after):
            return Sample(card, {}, inputs)
        outputs = self._plan.outputs
        files = files_of(result, labels, card, whole=outputs.results, support=outputs.support)
        return Sample(card, {**files, **other_labels(labels, self._plan.labels.also)}, inputs)


def failure(number: int, variant: Variant | None, cause: str) -> dict[str, Any]:
    """The record of a failed variant; None: its input is unknown."""
    if variant is None:
        return {"number": number, "input": "", "factors": {}, "cause": cause}
    return {
        "number": number,
        "input": variant.input.name,
        "body": variant.body.name,
        "scene": variant.scene.name,
        "factors": plain(variant.factors),
        "cause": cause,
    }

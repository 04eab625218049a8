"""Description of a sweep before it runs, as text for a terminal."""

from __future__ import annotations

from halfphysics.sweep.plan.choices import OWN
from halfphysics.sweep.plan.layout import Layout
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.plan.values import (
    Choice,
    Listed,
    LogUniform,
    Normal,
    Range,
    Spec,
    Uniform,
    Value,
)
from halfphysics.sweep.plan.variants import Variants, first_inputs

#: Number of variants from which the share that passes `keep` is estimated.
SAMPLE = 1000

_FIRST = 3
_WIDTH = 60


def describe(plan: Plan, variants: Variants) -> str:
    """Inputs, bodies, scenes, factors, the number of variants and shards, and the output folder.

    The same text for the same plan and inputs, in bounded time and memory.

    Raises:
        InputError: A condition of `keep` that cannot be evaluated.
    """
    names = [given.name for given in first_inputs(variants, _FIRST)]
    more = len(variants.inputs) - len(names)
    rows: list[tuple[str, ...]] = [
        ("inputs", f"{len(variants.inputs):,}: {', '.join(names)}" + (", ..." if more else "")),
        ("bodies", _some([body.name for body in plan.bodies], "the input's, or the default body")),
        ("scenes", _some([scene.name for scene in plan.scenes], "the input's")),
    ]
    if plan.grounded:
        rows.append(("grounded", "each motion is put on z = 0"))
    lines = _aligned(rows)
    if plan.factors:
        table = [(name, *_row(values)) for name, values in plan.factors.items()]
        lines += ["", *_aligned([("factor", "values", ""), *table], ruled=True), ""]
    return "\n".join([*lines, *_aligned(_totals(plan, variants))])


def _totals(plan: Plan, variants: Variants) -> list[tuple[str, ...]]:
    outputs = plan.outputs
    layout = Layout(plan.folder, len(variants), outputs.batch, outputs.variants_per_shard)
    rows: list[tuple[str, ...]] = []
    if plan.drawn:
        rows.append(("draws", f"{plan.samples:,} of each combination, seed {plan.seed}"))
    rows.append(("variants", f"{len(variants):,}"))
    if plan.keep:
        numbers = variants.sample(SAMPLE)
        kept = sum(variants.keeps(variants[number]) for number in numbers)
        exact = len(numbers) == len(variants)
        share = f"{kept:,} of them" if exact else f"about {100 * kept / len(numbers):.3g} %"
        source = "" if exact else f" ({kept} of {len(numbers):,} tried)"
        rows.append(("simulated", f"{share}{source}, where {' and '.join(plan.keep)}"))
    if plan.keep_after:
        rows.append(("kept", f"of these, where {' and '.join(plan.keep_after)}"))
    if plan.settings:
        rows.append(("settings", ", ".join(f"{k} {v}" for k, v in sorted(plan.settings.items()))))
    formats = " and ".join(outputs.formats)
    full = layout.batch * layout.batches_per_shard
    rows.append(("shards", f"{layout.shards:,} of up to {full:,} variants, {formats}"))
    rows.append(("folder", str(plan.folder)))
    return rows


def _row(values: Spec) -> tuple[str, str]:
    """The values of a factor as text, and their number."""
    if isinstance(values, Listed):
        return _short(values.values), f"{len(values.values):,}"
    if isinstance(values, Range):
        steps = "by even factors" if values.scale == "log" else "in even steps"
        return f"{values.first:g} to {values.last:g} {steps}", f"{values.count:,}"
    if isinstance(values, Uniform):
        return f"uniform from {values.low:g} to {values.high:g}", "drawn"
    if isinstance(values, LogUniform):
        return f"log-uniform from {values.low:g} to {values.high:g}", "drawn"
    if isinstance(values, Normal):
        inside = "" if values.within is None else " within {:g} to {:g}".format(*values.within)
        return f"normal, {values.mean:g} ± {values.sd:g}{inside}", "drawn"
    return _chosen(values), "drawn"


def _chosen(values: Choice) -> str:
    if values.weights is None:
        return f"one of {_short(values.values)}"
    pairs = zip(values.values, values.weights, strict=True)
    return f"one of {_short(tuple(f'{_said(v)} ({w:g})' for v, w in pairs))}"


def _short(values: tuple[Value, ...]) -> str:
    """The values in one line; of many values, the middle ones are left out."""
    texts = [_said(value) for value in values]
    whole = ", ".join(texts)
    return whole if len(whole) <= _WIDTH else f"{texts[0]}, {texts[1]}, ..., {texts[-1]}"


def _said(value: Value) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _some(names: list[str], own: str) -> str:
    texts = [own if name == OWN else name for name in names]
    shown = "; ".join(texts[:_FIRST]) + ("; ..." if len(texts) > _FIRST else "")
    return shown if len(texts) == 1 else f"{len(texts):,}: {shown}"


def _aligned(rows: list[tuple[str, ...]], ruled: bool = False) -> list[str]:
    """Rows as lines with aligned columns; `ruled` draws a line under the first row."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = [
        "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    if ruled:
        lines.insert(1, "  ".join("-" * width for width in widths))
    return lines

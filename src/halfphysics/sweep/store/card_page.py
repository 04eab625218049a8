"""The data card as a Markdown page: contents of the data set, outcome, how to load it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from halfphysics.sweep.plan.plan import OF_SOFT, OF_SUPPORT
from halfphysics.sweep.store.counting import COUNTED

#: A factor with more rows than the first number has neighbouring rows merged, if they are bins or
#: drawn numbers; numbers count as drawn if each has fewer samples on average than the second.
_ROWS, _FEW = 12, 10
#: Smaller values are rounding errors [m, s, N].
_NOTHING = 1e-12
_LOADING = """\
```python
import halfphysics.sweep

for sample in halfphysics.sweep.read("."):   # this folder, one shard (.tar) or one HDF5 file
    sample["card"]["factors"]                # what it was made from, and how it came out
    sample["human"]["poses"]                 # (T, 156); sample["object"], sample["contact"]
```

A `.tar` is a WebDataset archive as well: `WebDataset(sorted(glob.glob("shards/*/*.tar")))`. Take
the samples whose card says `"success": true`, or look at its `checks`."""
_LICENCES = """\
Motions, body models, meshes and scenes are the user's: their licences hold for this data set too.
Body models and meshes are named in the cards by path and SHA-256, their content is not in it;
poses, shapes and places of objects are."""
_SUCCESS = {
    "whole": "fewer frames came back than the reference has",
    "finite": "a number was not finite",
    "clear": "a person or an object was inside something again, or never got out",
    "in_time": "a blocked step was shortened",
}


def page(card: Mapping[str, Any]) -> str:
    """The Markdown text of a card.

    Args:
        card: The result of `DataCard.document`.
    """
    blocks = [
        "# Data card",
        _about(card),
        "## What is in it",
        _table(("", "number"), _contents(card)),
        "## Whether it went well",
        _outcome(card),
        "## Numbers",
        _table(("", "samples", "least", "1 %", "median", "99 %", "most", "mean"), _spreads(card)),
        *_factors(card),
        "## Loading",
        _LOADING,
        "## Licences",
        _LICENCES,
    ]
    return "\n\n".join(blocks) + "\n"


def _about(card: Mapping[str, Any]) -> str:
    versions = card["versions"]
    if versions is None:
        made = "many versions of the program"
    else:
        made = "; ".join(
            ", ".join(
                f"{name} {str(which)[:12]}" for name, which in its.items() if which is not None
            )
            for its in versions
        )
    lines = [f"Made with {made or 'nothing yet'}."]
    if card["plan"] is not None:
        lines.append(
            f"Plan {card['plan_identity'][:12]}, seed {card['seed']}; the plan is in plan.yaml, "
            "its inputs are in inputs.txt."
        )
    return "\n".join(lines)


def _contents(card: Mapping[str, Any]) -> Iterable[tuple[str, ...]]:
    total = card["samples"]
    yield "samples", f"{total:,}"
    yield "of them successes", _share(card["success"], total)
    yield "left out by filters", f"{card['skipped']:,}"
    yield "failed", f"{card['failed']:,}"
    yield "frames", f"{card['totals']['frames']:,}"
    for name, words in (
        ("holds", "things that people carried"),
        ("lost_grasps", "grasps that were lost"),
        ("slips", "slips"),
        ("drops", "drops"),
    ):
        number, within = card["totals"][name], card["samples_with"][name]
        where = f", in {_share(within, total)} of the samples" if number else ""
        yield words, f"{number:,}{where}"


def _outcome(card: Mapping[str, Any]) -> str:
    total = card["samples"]
    lines = [
        f"- {_share(number, total)}: {_SUCCESS[name]} (`{name}`)"
        for name, number in card["unsuccessful"].items()
        if number
    ]
    text = "\n".join(lines) or "Every sample is a success: whole, finite, clear and in time."
    if not total:
        text = "There is no sample."
    if not card["failed"]:
        return text
    causes = card["failures"]
    if causes is None:
        return f"{text}\n\n{card['failed']:,} variants failed for many causes: failures.jsonl."
    rows = sorted(causes.items(), key=lambda row: (-row[1], row[0]))
    head = f"{text}\n\nVariants that failed are in failures.jsonl; by cause:\n\n"
    return head + _table(("cause", "variants"), ((k, f"{v:,}") for k, v in rows))


def _spreads(card: Mapping[str, Any]) -> Iterable[tuple[str, ...]]:
    for name, its in card["spreads"].items():
        if not its["number"] and name in OF_SUPPORT:
            continue  # the plan does not ask for it
        if not its["most"] and name in OF_SOFT:
            continue  # nothing is soft
        keys = ("least", "p1", "p50", "p99", "most", "mean")
        yield (
            f"{name} [{its['unit']}]",
            f"{its['number']:,}",
            *("" if its[key] is None else _number(its[key]) for key in keys),
        )


def _number(value: float) -> str:
    """A value with four digits; rounding errors become zero."""
    return f"{value if abs(value) > _NOTHING else 0.0:.4g}"


def _factors(card: Mapping[str, Any]) -> Iterable[str]:
    if card["factors"]:
        yield "## Factors"
    for name, rows in card["factors"].items():
        yield f"### {name}"
        if rows is None:
            yield "More values than are counted one by one."
        else:
            yield _table(
                ("value", "samples", "successes", "with slips", "with drops", "failed"),
                (_factor(row) for row in _together(rows)),
            )


def _factor(row: Mapping[str, Any]) -> tuple[str, ...]:
    value = str(row["value"]) if "value" in row else f"{row['from']:.4g} to {row['to']:.4g}"
    total = row["samples"]
    return (
        value,
        f"{total:,}",
        *(_share(row[key], total) for key in ("success", "slipped", "dropped")),
        f"{row['failed']:,}",
    )


def _together(rows: Sequence[Mapping[str, Any]]) -> Sequence[Mapping[str, Any]]:
    """Rows of bins or drawn numbers, neighbours merged into at most `_ROWS` rows."""
    size = -(-len(rows) // _ROWS)
    drawn = sum(row["samples"] for row in rows) < _FEW * len(rows)
    if size <= 1 or ("value" in rows[0] and not (drawn and _numbers(rows))):
        return rows
    few = []
    for first in range(0, len(rows), size):
        part = rows[first : first + size]
        sums = {key: sum(row[key] for row in part) for key in COUNTED}
        low = part[0].get("value", part[0].get("from"))
        few.append({"from": low, "to": part[-1].get("value", part[-1].get("to")), **sums})
    return few


def _numbers(rows: Sequence[Mapping[str, Any]]) -> bool:
    return all(type(row["value"]) in (int, float) for row in rows)


def _share(number: int, total: int) -> str:
    return f"{number:,} ({100.0 * number / total:.3g} %)" if total else f"{number:,}"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    cells = [[text.replace("|", "\\|") for text in row] for row in (head, *rows)]
    lines = [f"| {' | '.join(row)} |" for row in cells]
    rule = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join([lines[0], f"| {' | '.join(rule)} |", *lines[1:]])

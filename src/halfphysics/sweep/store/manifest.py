"""The summary of a sweep in four files: manifest, data card (two), failures.

All are written in one pass over the records of the shards, in order, one at a time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from halfphysics.base import json_files
from halfphysics.sweep.plan.layout import Layout

if TYPE_CHECKING:
    from halfphysics.sweep.plan.plan import Plan


def write(plan: Plan, layout: Layout, records: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Write `manifest.jsonl`, `failures.jsonl`, `card.json` and `card.md`.

    Returns:
        The numbers of "shards", "samples", "skipped" and "failures".
    """
    from halfphysics.sweep.store.data_card import DataCard

    card = DataCard(plan)
    folder = layout.folder
    totals = {"shards": 0, "samples": 0, "skipped": 0, "failures": 0}
    with (
        json_files.replacing(folder / "manifest.jsonl") as lines,
        json_files.replacing(folder / "failures.jsonl") as failures,
    ):
        for record in records:
            card.add(record)
            totals["shards"] += 1
            totals["samples"] += record["samples"]
            totals["skipped"] += record["skipped"]
            totals["failures"] += len(record["failures"])
            lines.write(json_files.text_of(_line(layout, record)).encode() + b"\n")
            for failure in record["failures"]:
                failures.write(json_files.text_of(failure).encode() + b"\n")
    json_files.write(folder / "card.json", card.document())
    with json_files.replacing(folder / "card.md") as handle:
        handle.write(card.markdown().encode())
    return totals


def _line(layout: Layout, record: Mapping[str, Any]) -> dict[str, Any]:
    shard = record["shard"]
    files = {
        suffix.lstrip("."): {
            "path": layout.shard_file(shard, suffix).relative_to(layout.folder).as_posix(),
            **file,
        }
        for suffix, file in record["files"].items()
    }
    return {
        "shard": shard,
        "of": record["of"],
        "first": record["first"],
        "variants": record["variants"],
        "samples": record["samples"],
        "skipped": record["skipped"],
        "failures": len(record["failures"]),
        "files": files,
    }

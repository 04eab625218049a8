"""Reopening a sealed shard: its fragments again, except for batches with failures."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

from halfphysics.base.digests import sha256_of
from halfphysics.base.json_files import reported
from halfphysics.errors import FileError
from halfphysics.sweep.plan.layout import Layout
from halfphysics.sweep.store import tar
from halfphysics.sweep.store.contents import DAMAGE
from halfphysics.sweep.store.fragments import Fragments

Files = dict[str, bytes]


def reopen(layout: Layout, fragments: Fragments, record: Mapping[str, Any]) -> None:
    """Make a shard count as open, with the fragments of the batches without failures.

    The fragments are cut out of its tar; without a tar, all batches have to be made again. A driver
    that is killed before the end leaves a sealed shard, and fragments that the next start removes.

    Raises:
        FileError: The tar is damaged, or a file cannot be written.
    """
    shard = record["shard"]
    if ".tar" in record["files"]:
        failed = {failure["number"] // layout.batch for failure in record["failures"]}
        path = layout.shard_file(shard, ".tar")
        _check(path, record["files"][".tar"]["sha256"])
        there = groupby(_samples(path), key=lambda sample: int(sample[0]) // layout.batch)
        batch, samples = next(there, (None, None))
        for wanted in layout.batches_of(shard):
            kept = list(samples or ()) if batch == wanted else []
            if batch == wanted:
                batch, samples = next(there, (None, None))
            if wanted not in failed:
                fragments.write(wanted, kept, _record(layout, wanted, kept, record))
    path = layout.shard_file(shard, ".json")
    with reported(path):
        path.unlink(missing_ok=True)


def _record(
    layout: Layout, batch: int, samples: list[tuple[str, Files]], shard: Mapping[str, Any]
) -> dict[str, Any]:
    """The record of a batch without failures, computed from its samples."""
    from halfphysics.sweep.store.data_card import DataCard

    card = DataCard()
    skipped = len(layout.variants_of(batch)) - len(samples)
    for _, files in samples:
        card.sample(json.loads(files["card.json"]))
    card.skip(skipped)
    # The record of the shard does not list inputs by batch: use all of them.
    return {"skipped": skipped, "failures": [], "sums": card.sums(), "inputs": shard["inputs"]}


def _check(path: Path, expected: str) -> None:
    """Raise if a tar is damaged: reading it would stop at the damage without an error."""
    try:
        found = sha256_of(path)
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    if found != expected:
        raise FileError(
            f"{path}: damaged: found SHA-256 {found[:12]}..., expected {expected[:12]}.... Remove "
            "it: it is made again when the sweep is started"
        )


def _samples(path: Path) -> Iterator[tuple[str, Files]]:
    """Key and files of each sample of a tar."""
    try:
        yield from tar.samples(path)
    except DAMAGE as error:
        raise FileError(f"{path}: cannot be read ({error})") from None

"""The summary of a sweep as text for a terminal, from its data card."""

from __future__ import annotations

import json
from pathlib import Path

from halfphysics.errors import FileError
from halfphysics.sweep.run.driver import Report
from halfphysics.sweep.run.progress import bytes_text

_CAUSES = 5  # number of kinds of failures that are listed
_WIDTH = 100


def summary(report: Report) -> str:
    """Variants, failures by cause, events, and paths of the output.

    Raises:
        FileError: The folder's card or manifest cannot be read.
    """
    folder = report.folder
    try:
        card = json.loads((folder / "card.json").read_bytes())
        sizes = _sizes(folder / "manifest.jsonl")
    except (OSError, ValueError) as error:
        raise FileError(f"{folder}: cannot read what the sweep wrote: {error}") from None
    left_out = f", {report.skipped} left out by its conditions" if report.skipped else ""
    lines = [f"{report.variants} variants: {report.samples} samples{left_out}"]
    if report.samples:
        lines[0] += f", {card['success']} of them a success"
    if report.failures:
        lines[0] += f", {report.failures} failed"
        lines += [f"  {line}" for line in _causes(card["failures"], report.failures)]
    seen = [f"{card['totals'][name]} {name}" for name in ("holds", "slips", "drops")]
    if report.samples:
        lines.append(f"events   {', '.join(seen)}")
    for name, size in sizes.items():
        lines.append(f"{name:<8} {report.shards} shards, {bytes_text(size)}: {folder / 'shards'}")
    lines.append(f"card     {folder / 'card.md'}, {folder / 'card.json'}")
    if report.failures:
        lines.append(f"failures {folder / 'failures.jsonl'}; --retry-failed tries them again")
    return "\n".join(lines)


def _causes(kinds: dict[str, int] | None, failures: int) -> list[str]:
    """Failures by kind, the most frequent first."""
    if kinds is None:
        return ["of many kinds"]
    ordered = sorted(kinds.items(), key=lambda kind: (-kind[1], kind[0]))
    lines = [f"{count} x {_short(cause)}" for cause, count in ordered[:_CAUSES]]
    rest = failures - sum(count for _, count in ordered[:_CAUSES])
    return [*lines, f"{rest} of other kinds"] if rest else lines


def _short(text: str) -> str:
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 3]}..."


def _sizes(manifest: Path) -> dict[str, int]:
    """Total size of the files of all shards, by kind [bytes]."""
    sizes: dict[str, int] = {}
    with manifest.open("rb") as lines:
        for line in lines:
            for kind, file in json.loads(line)["files"].items():
                sizes[kind] = sizes.get(kind, 0) + file["bytes"]
    return sizes

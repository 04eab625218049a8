"""Verifying a sweep: making some of its samples again and comparing them bit by bit."""

from __future__ import annotations

import os
import random
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import FileError, InputError
from halfphysics.sweep.make.making import Maker, Sample
from halfphysics.sweep.make.provenance import changed
from halfphysics.sweep.plan.layout import INPUTS, PLAN, key_of
from halfphysics.sweep.store.contents import DAMAGE
from halfphysics.sweep.store.pieces import Piece, ranges_made
from halfphysics.sweep.store.sources import Sources

#: Variants drawn for each requested sample, as filters may leave most of them out.
_TRIES = 100
#: Largest number of differences that are listed.
_TOLD = 20


@dataclass(frozen=True)
class Report:
    """The result of verifying a sweep.

    Attributes:
        equal: Samples that are equal bit by bit.
        out: Variants that have no sample, neither stored nor made again.
        differences: Descriptions of the differences.
        notes: Other information, such as another version of the program.
    """

    equal: int
    out: int
    differences: tuple[str, ...]
    notes: tuple[str, ...]

    def __str__(self) -> str:
        """The report as lines of text."""
        if not (self.equal or self.out or self.differences):
            return "\n".join(["no sample to compare: none is there", *self.notes])
        lines = [f"{self.equal} sample(s) made again are equal bit by bit"]
        if self.out:
            lines.append(f"{self.out} variant(s) without a sample again have none")
        lines += self.notes
        if self.differences:
            lines.append(f"{len(self.differences)} difference(s):")
            lines += [f"  {text}" for text in self.differences[:_TOLD]]
            if len(self.differences) > _TOLD:
                lines.append(f"  and {len(self.differences) - _TOLD} more")
        return "\n".join(lines)


def verify(
    folder: str | os.PathLike[str],
    count: int = 10,
    seed: int = 0,
    progress: Callable[[int], None] | None = None,
) -> Report:
    """Make some samples of a sweep again, and compare them with the stored ones, bit by bit.

    The SHA-256 of the files that hold the samples, and of the inputs, is compared as well.
    Variants that failed are not tried again.

    Args:
        folder: The folder of the sweep, finished or not.
        count: Number of samples; all if there are fewer.
        seed: Seed of the random choice of samples.
        progress: Called after each sample with the number of samples compared.

    Returns:
        The report, without differences.

    Raises:
        FileError: A sample differs (the report is the message), or the folder has no sweep.
        InputError: The sweep has no samples to compare yet, or `count` is invalid.
    """
    if not is_whole(count, least=1):
        raise InputError(f"verify: count: found {shown(count)}, expected 1 or more samples")
    return _Verifier(Path(folder)).run(count, seed, progress)


class _Verifier:
    """The state of one verification."""

    def __init__(self, folder: Path) -> None:
        from halfphysics.sweep.plan.plan import InputList, Plan
        from halfphysics.sweep.plan.variants import Variants
        from halfphysics.sweep.store.store import Store

        if not (folder / PLAN).is_file():
            raise FileError(
                f"{folder}: no {PLAN} in it, expected the folder that `halfphysics sweep` wrote to"
            )
        plan = Plan.load(folder / PLAN)
        self._folder = folder
        self._variants = Variants(plan, InputList(folder / INPUTS))
        # A new maker: files that other makers of this process have read may have changed since.
        self._maker = Maker(plan, self._variants)
        self._layout = Store(folder, plan).layout
        self._sources = Sources(since=0, base=plan.base)
        self._ranges = list(ranges_made(self._layout))
        self._pieces: dict[int, Piece | None] = {}
        self._equal = self._out = 0
        self._differences: list[str] = []
        self._notes: dict[str, None] = {}

    def run(self, count: int, seed: int, progress: Callable[[int], None] | None) -> Report:
        """Compare `count` samples."""
        if not self._ranges:
            raise InputError(
                f"{self._folder}: nothing to compare yet. Run the sweep, then verify what it made"
            )
        compared: set[int] = set()
        for piece, number in self._chosen(count, random.Random(seed)):
            if number in compared:
                continue
            if number not in piece:
                self._absent(piece, number, count)
                continue
            self._compare(piece, number)
            compared.add(number)
            if progress is not None:
                progress(len(compared))
            if len(compared) == count:
                break
        report = Report(self._equal, self._out, tuple(self._differences), tuple(self._notes))
        if report.differences:
            raise FileError(f"{self._folder}: not what is made now\n{report}")
        return report

    def _chosen(self, count: int, draw: random.Random) -> Iterator[tuple[Piece, int]]:
        """Variants at random, and then samples: conditions may leave out nearly all variants."""
        ends = list(accumulate(map(len, self._ranges)))
        for place in draw.sample(range(ends[-1]), min(ends[-1], _TRIES * count)):
            index = bisect_right(ends, place)
            piece = self._piece(index)
            if piece is not None:
                yield piece, self._ranges[index][place - ends[index]]
        for index in draw.sample(range(len(ends)), len(ends)):
            piece = self._piece(index)
            if piece is not None:
                numbers = piece.numbers()
                yield from ((piece, number) for number in draw.sample(numbers, len(numbers)))

    def _piece(self, index: int) -> Piece | None:
        """A shard or fragment, of which the damage is recorded; None if it cannot be read."""
        if index not in self._pieces:
            self._pieces[index] = None
            damage: list[str] = []
            try:
                piece = Piece.open(self._layout, self._ranges[index])
                damage = piece.damage()
                piece.numbers()  # are its samples found?
                self._pieces[index] = piece
            except FileError as error:
                damage = damage or [str(error)]
            self._differences += damage
        return self._pieces[index]

    def _absent(self, piece: Piece, number: int, most: int) -> None:
        """Check a variant without a sample: it failed, or a condition leaves it out."""
        if number in piece.failed or not self._variants.keeps(self._variants[number]):
            return
        if self._out < most:
            made = self._maker.sample(number)
            if not isinstance(made, Sample) or made.files:
                self._differences.append(f"{key_of(number)}: has no sample there, and is made now")
            self._out += 1

    def _compare(self, piece: Piece, number: int) -> None:
        """Make a sample again, and record its differences."""
        made = self._maker.sample(number)
        if not isinstance(made, Sample) or not made.files:
            why = f"fails: {made['cause']}" if isinstance(made, dict) else "is left out"
            self._differences.append(f"{key_of(number)}: has a sample there, and {why} now")
            return
        changes = [
            f"{name} is not the file any more that samples were made from (SHA-256)"
            for name, digest in self._sources.named(made.inputs).items()
            if piece.inputs.get(name, digest) != digest
        ]
        if changes:  # then all other contents may differ
            self._differences += [text for text in changes if text not in self._differences]
            return
        try:
            card = piece.card(number)
            others = changed(card["versions"])
            self._notes |= {f"made by another program: {text}": None for text in others}
            # Data of another program should be the same except for the versions in the card.
            differ = piece.differ(number, made.files, ("versions",) if others else ())
        except (*DAMAGE, FileError) as error:
            differ = [f"cannot be read ({error})"]
        self._differences += [f"{key_of(number)}: {text}" for text in differ]
        self._equal += not differ

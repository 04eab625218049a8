"""Layout of a sweep: numbers of variants, batches and shards, and the paths of their files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

#: Shards in one folder: larger folders are slow in file systems and hard to read.
PER_FOLDER = 1000
#: Number of digits in names, so that names sort like numbers.
DIGITS = 9
#: Files in the folder of a sweep: the plan, and the resolved inputs.
PLAN, INPUTS = "plan.yaml", "inputs.txt"


def key_of(number: int) -> str:
    """The number of a sample or shard as it is written in names."""
    return f"{number:0{DIGITS}d}"


@dataclass(frozen=True)
class Layout:
    """`variants` variants in batches of `batch` and shards of `per_shard` or a few more.

    A shard consists of whole batches. Everything is computed, nothing is listed: a plan of ten
    million variants takes no more memory than a plan of ten.
    """

    folder: Path
    variants: int
    batch: int
    per_shard: int

    @property
    def batches(self) -> int:
        """Number of batches; the last may be short."""
        return -(-self.variants // self.batch)

    @property
    def batches_per_shard(self) -> int:
        """Number of batches in a shard."""
        return -(-self.per_shard // self.batch)

    @property
    def shards(self) -> int:
        """Number of shards; the last may be short."""
        return -(-self.batches // self.batches_per_shard)

    def batches_of(self, shard: int) -> range:
        """The batches of a shard."""
        first = shard * self.batches_per_shard
        return range(first, min(first + self.batches_per_shard, self.batches))

    def variants_of(self, batch: int) -> range:
        """The variants of a batch."""
        first = batch * self.batch
        return range(first, min(first + self.batch, self.variants))

    def shard_of(self, batch: int) -> int:
        """The shard that a batch belongs to."""
        return batch // self.batches_per_shard

    # -- files ---------------------------------------------------------------------------

    @property
    def work(self) -> Path:
        """The folder of unsealed shards and of notes that are no part of the data."""
        return self.folder / "work"

    @property
    def shard_folder(self) -> Path:
        return self.folder / "shards"

    def shard_file(self, shard: int, suffix: str) -> Path:
        """The file of a shard; `suffix` is ".tar", ".h5", or ".json" (the record of completion)."""
        folder = self.shard_folder / f"{shard // PER_FOLDER:05d}"
        return folder / f"{key_of(shard)}{suffix}"

    def open_shard(self, shard: int) -> Path:
        """The folder of fragments of an unsealed shard."""
        return self.work / key_of(shard)

    def fragment(self, batch: int) -> Path:
        return self.open_shard(self.shard_of(batch)) / f"{batch:08d}.fragment"

    def fragment_record(self, batch: int) -> Path:
        return self.fragment(batch).with_suffix(".json")

    def stats(self, shard: int) -> Path:
        """The file with the state of a sealed shard's input files at the time of reading."""
        return self.work / "stats" / f"{key_of(shard)}.json"

"""Where things of a sweep lie: numbers of variants, batches and shards, and their files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

#: Shards in one folder: file systems and people take long over larger ones.
PER_FOLDER = 1000
#: How many digits numbers have in names, so that names sort as numbers do.
DIGITS = 9
#: In the folder of a sweep: the plan, and the inputs that it came to.
PLAN, INPUTS = "plan.yaml", "inputs.txt"


def key_of(number: int) -> str:
    """A number in names: of a sample in its shard, of a shard."""
    return f"{number:0{DIGITS}d}"


@dataclass(frozen=True)
class Layout:
    """Runs of `variants` variants: `batch` of them make a batch, `per_shard` or a few more a shard.

    A shard is whole batches. Everything is computed, nothing listed: a plan of ten million
    variants takes no more memory than one of ten.
    """

    folder: Path
    variants: int
    batch: int
    per_shard: int

    @property
    def batches(self) -> int:
        """Number of batches, the last of which may be short."""
        return -(-self.variants // self.batch)

    @property
    def batches_per_shard(self) -> int:
        """Number of batches in a shard."""
        return -(-self.per_shard // self.batch)

    @property
    def shards(self) -> int:
        """Number of shards, the last of which may be short."""
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
        """What is not sealed yet, and notes that are no part of the data."""
        return self.folder / "work"

    @property
    def shard_folder(self) -> Path:
        return self.folder / "shards"

    def shard_file(self, shard: int, suffix: str) -> Path:
        """`suffix`: ".tar", ".h5", or ".json" for the record that says it is done."""
        folder = self.shard_folder / f"{shard // PER_FOLDER:05d}"
        return folder / f"{key_of(shard)}{suffix}"

    def open_shard(self, shard: int) -> Path:
        """The folder of fragments of a shard that is not sealed yet."""
        return self.work / key_of(shard)

    def fragment(self, batch: int) -> Path:
        return self.open_shard(self.shard_of(batch)) / f"{batch:08d}.fragment"

    def fragment_record(self, batch: int) -> Path:
        return self.fragment(batch).with_suffix(".json")

    def stats(self, shard: int) -> Path:
        """What the input files of a sealed shard looked like when they were read."""
        return self.work / "stats" / f"{key_of(shard)}.json"

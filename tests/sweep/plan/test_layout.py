"""The layout of a sweep: every variant in one batch, every batch in one shard."""

from __future__ import annotations

from pathlib import Path

import pytest

from halfphysics.sweep.plan.layout import Layout, key_of


def test_a_shard_is_whole_batches():
    layout = Layout(Path("out"), 1000, 16, 100)
    assert layout.batches_per_shard == 7
    assert list(layout.batches_of(1)) == list(range(7, 14))
    counts = [Layout(Path("out"), n, 16, 100).shards for n in (0, 1, 112, 113)]
    assert counts == [0, 1, 1, 2]


@pytest.mark.parametrize("variants", [0, 1, 15, 16, 17, 112, 113, 1000])
def test_every_variant_is_in_one_batch_and_every_batch_in_one_shard(variants):
    layout = Layout(Path("out"), variants, 16, 100)
    shards = [layout.batches_of(shard) for shard in range(layout.shards)]
    batches = [batch for shard in shards for batch in shard]
    assert batches == list(range(layout.batches))
    assert [n for b in batches for n in layout.variants_of(b)] == list(range(variants))
    assert all(layout.shard_of(b) == k for k, shard in enumerate(shards) for b in shard)


def test_names_sort_as_numbers_do_and_no_folder_has_many():
    layout = Layout(Path("out"), 10_000_000, 8, 1000)
    numbers = [0, 9, 10, 999, 1000, 9999]
    files = [layout.shard_file(shard, ".tar") for shard in numbers]
    assert files == sorted(files)
    assert files[4] == Path("out/shards/00001/000001000.tar")
    assert layout.fragment(130) == Path("out/work/000000001/00000130.fragment")
    assert layout.fragment_record(130) == Path("out/work/000000001/00000130.json")
    assert [key_of(n) for n in (7, 10**9 - 1)] == ["000000007", "999999999"]

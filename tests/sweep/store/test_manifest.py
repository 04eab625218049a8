"""The manifest of a sweep, in a few files: also of a partial sweep, and of very many shards."""

from __future__ import annotations

import json
import tracemalloc

from halfphysics.base import json_files
from halfphysics.sweep.store.store import Store
from support.sweeps.sweep_shards import make_batch, plan_of


def test_what_there_is_of_an_interrupted_run(tmp_path):
    with Store(tmp_path / "out", plan_of(tmp_path), "this") as store:
        for batch in store.batches(2):
            make_batch(store, batch)
        store.seal(2)
        assert store.finish() == {"shards": 1, "samples": 6, "skipped": 0, "failures": 0}
        assert [record["shard"] for record in store.records()] == [2]
    assert json.loads((tmp_path / "out/manifest.jsonl").read_text())["first"] == 12


def test_manifest_of_many_shards(tmp_path):
    """In no more memory than for few: records are read one at a time."""
    peaks = []
    for shards in (50, 500):
        plan = plan_of(tmp_path, variants=shards, batch=2, per_shard=2)
        with Store(tmp_path / str(shards), plan, "this") as store:
            make_batch(store, 0)
            store.seal(0)
            record = store.record(0)
            for shard in range(1, shards):
                path = store.layout.shard_file(shard, ".json")
                json_files.write(path, record | {"shard": shard, "first": 2 * shard})
            assert store.finish()["shards"] == shards
            tracemalloc.start()
            store.finish()
            peaks.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()
    assert peaks[1] < peaks[0] + 1_000_000  # 500 records take 11 MB

"""Source files of a sweep: changed files are made again, unchanged ones are not read again."""

from __future__ import annotations

import hashlib
import os

import pytest

from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.store.sources import Sources
from halfphysics.sweep.store.store import Store
from support.sweeps.sweep_shards import make, make_batch, plan_of


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def swept(tmp_path, monkeypatch):
    """A folder made from a file that was long unchanged; gives a new store for it."""
    monkeypatch.setattr("halfphysics.sweep.store.store._CLOCKS", -60_000_000_000)
    plan = plan_of(tmp_path)
    (tmp_path / "mesh.obj").write_bytes(b"v 0 0 0")
    (tmp_path / "big.npz.txt").write_bytes(b"a" * 1000)
    with Store(tmp_path / "out", plan, "this") as store:
        inputs = {str(p): digest(p) for p in (tmp_path / "mesh.obj", tmp_path / "big.npz.txt")}
        for batch in store.batches(0):
            make_batch(store, batch, inputs=inputs)
        store.seal(0)
        make_batch(store, 3, inputs=inputs)
    return lambda: Store(tmp_path / "out", plan, "this")


def test_unchanged_inputs_are_not_read_again(swept, monkeypatch):
    with swept() as store:
        monkeypatch.setattr("hashlib.file_digest", None)
        assert store.done(0)
        assert store.left(1) == [4, 5]


def test_touched_inputs_are_read_again(swept, tmp_path):
    os.utime(tmp_path / "mesh.obj", (1, 1))
    with swept() as store:
        assert store.done(0)
        assert store.left(1) == [4, 5]


def test_changed_inputs_make_it_again(swept, tmp_path):
    (tmp_path / "mesh.obj").write_bytes(b"v 0 0 1")
    with swept() as store:
        assert not store.done(0)
        with pytest.warns(HalfPhysicsWarning, match=r"^mesh\.obj: has changed .* again") as said:
            left = [store.left(0), store.left(1)]
        assert left == [[0, 1, 2], [3, 4, 5]]
        assert len(said) == 1


def test_a_changed_input_of_what_is_not_sealed_is_said(swept, tmp_path):
    (tmp_path / "mesh.obj").write_bytes(b"v 0 0 1")
    with swept() as store, pytest.warns(HalfPhysicsWarning, match=r"mesh\.obj: has changed"):
        assert store.left(1) == [3, 4, 5]


def test_changed_inputs_are_not_kept_for_failures(tmp_path):
    with Store(tmp_path / "out", plan_of(tmp_path), "this") as store:
        inputs = {str(tmp_path / "a.npz"): digest(tmp_path / "a.npz")}
        make(store, failed=(1,), inputs=inputs)
    (tmp_path / "a.npz").write_bytes(b"other")
    with Store(tmp_path / "out", plan_of(tmp_path), "this") as store:
        assert store.drop_failed() == 1
        with pytest.warns(HalfPhysicsWarning, match=r"a\.npz: has changed"):
            assert store.left(0) == [0, 1, 2]


def test_inputs_that_are_gone(swept, tmp_path):
    (tmp_path / "mesh.obj").unlink()
    with swept() as store, pytest.raises(InputError, match=r"mesh\.obj: cannot be reached.*back"):
        store.done(0)


def test_what_changed_since_the_run_began_is_not_trusted(tmp_path):
    path = tmp_path / "clip.npz"
    path.write_bytes(b"new")
    changed = path.stat().st_ctime_ns
    assert Sources(changed, tmp_path).stats({"clip.npz": "old"}) == {}
    assert Sources(changed + 1, tmp_path).stats({"clip.npz": "old"}) != {}


def test_inputs_that_change_while_they_are_read(tmp_path):
    plan = plan_of(tmp_path)
    with Store(tmp_path / "out", plan) as store:
        for batch, sha in zip(store.batches(0), ("1" * 64, "1" * 64, "2" * 64), strict=True):
            make_batch(store, batch, inputs={str(tmp_path / "a.npz"): sha})
        with pytest.raises(InputError, match=r"a\.npz: changed while the sweep read it"):
            store.seal(0)
        assert store.left(0) == [0, 1, 2]


@pytest.mark.parametrize("linked", ["out", "proj"])
def test_inputs_are_found_again_from_a_linked_folder(tmp_path, monkeypatch, linked):
    """A worker reads the plan in the folder of results, whose base leads over the link."""
    monkeypatch.setattr("halfphysics.sweep.store.store._CLOCKS", -60_000_000_000)
    (tmp_path / "far" / "away").mkdir(parents=True)
    (tmp_path / linked).symlink_to(tmp_path / "far" / "away")
    (tmp_path / "proj").mkdir(exist_ok=True)
    plan, out = plan_of(tmp_path / "proj"), tmp_path / "out"
    with Store(out, plan, "this") as store:
        there = Plan.load(out / "plan.yaml")
        worker = Store(out, there, "this")
        sha = digest(tmp_path / "proj" / "a.npz")
        for batch in store.batches(0):
            make_batch(worker, batch, inputs={str(there.base / "a.npz"): sha})
        worker.seal(0)
    monkeypatch.setattr("hashlib.file_digest", None)  # nothing is read again
    with Store(out, plan, "this") as store:
        assert store.record(0)["inputs"] == {"a.npz": sha}
        assert store.done(0)

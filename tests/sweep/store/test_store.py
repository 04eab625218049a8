"""The folder of a sweep: its contents, no work lost, no partial files."""

from __future__ import annotations

import json
import os
import signal
import sys
import tarfile
from pathlib import Path

import numpy as np
import pytest

from halfphysics.errors import FileError, InputError, MissingDependencyError
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.store.store import Store
from support.sweeps.sweep_shards import (
    make,
    make_batch,
    plan_of,
    record_of,
    run,
    sample,
    tree,
    write_tar,
)

posix = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
BOTH = ("webdataset", "hdf5")


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """Eleven values for two files: 22 variants, 11 batches, 4 shards."""
    pytest.importorskip("h5py")
    return plan_of(tmp_path_factory.mktemp("library"), formats=BOTH)


@pytest.fixture(scope="module")
def undisturbed(plan, tmp_path_factory):
    """The content of the folder after an uninterrupted run."""
    folder = tmp_path_factory.mktemp("undisturbed") / "out"
    assert run(folder, plan) == {"shards": 4, "samples": 20, "skipped": 2, "failures": 0}
    return tree(folder)


# -- contents ------------------------------------------------------------------------------


def test_what_is_in_the_folder(undisturbed):
    shards = [f"shards/00000/{k:09d}{s}" for k in range(4) for s in (".h5", ".json", ".tar")]
    notes = ["card.json", "card.md", "failures.jsonl", "inputs.txt", "manifest.jsonl", "plan.yaml"]
    assert sorted(undisturbed) == sorted([*shards, *notes, "program.json"])


def test_a_shard_is_what_tarfile_writes_in_one_go(undisturbed, tmp_path):
    kept = [sample(n) for n in range(6) if n != 3]
    whole = write_tar(tmp_path / "a.tar", kept).read_bytes()
    assert undisturbed["shards/00000/000000000.tar"] == whole


def test_manifest_says_what_the_files_are(undisturbed):
    import hashlib

    lines = [json.loads(line) for line in undisturbed["manifest.jsonl"].splitlines()]
    assert [line["first"] for line in lines] == [0, 6, 12, 18]
    assert [line["samples"] for line in lines] == [5, 5, 6, 4]
    for line in lines:
        assert line["files"].keys() == {"tar", "h5"}
        for file in line["files"].values():
            data = undisturbed[file["path"]]
            assert (len(data), hashlib.sha256(data).hexdigest()) == (file["bytes"], file["sha256"])


def test_order_and_process_do_not_matter(plan, undisturbed, tmp_path):
    with Store(tmp_path / "out", plan, "this") as store:
        rng = np.random.default_rng(0)
        for batch in rng.permutation(store.layout.batches):
            # Each as its own process would, twice where a worker was assumed dead.
            for _ in range(rng.integers(1, 3)):
                make_batch(Store(tmp_path / "out", plan, "this"), int(batch))
        for shard in rng.permutation(store.layout.shards):
            Store(tmp_path / "out", plan, "this").seal(int(shard))
        store.finish()
    assert tree(tmp_path / "out") == undisturbed


def test_formats(tmp_path, undisturbed):
    """Without the tar the HDF5 file is the same, and the intermediate tar is removed."""
    run(tmp_path / "out", plan_of(tmp_path, formats=("hdf5",)))
    there = tree(tmp_path / "out")
    assert not [name for name in there if name.endswith(".tar")]
    for k in range(4):
        name = f"shards/00000/{k:09d}.h5"
        assert there[name] == undisturbed[name]


def test_a_batch_of_nothing(tmp_path):
    with Store(tmp_path / "out", plan_of(tmp_path, variants=2, per_shard=2)) as store:
        for batch in range(store.layout.batches):
            store.write_fragment(batch, [], record_of(store, batch) | {"skipped": 2})
        for shard in range(store.layout.shards):
            store.seal(shard)
        assert store.finish() == {"shards": 2, "samples": 0, "skipped": 4, "failures": 0}
    with tarfile.open(tmp_path / "out/shards/00000/000000000.tar") as archive:
        assert archive.getnames() == []


@pytest.mark.parametrize("numbers", [[1, 0], [0, 0], [0, 5]])
def test_samples_in_order_and_of_the_batch(tmp_path, numbers):
    with Store(tmp_path / "out", plan_of(tmp_path)) as store:
        with pytest.raises(InputError, match="expected keys from 000000000 to 000000001"):
            store.write_fragment(0, [sample(n) for n in numbers], {})
        assert store.left(0) == [0, 1, 2]
    assert list((tmp_path / "out/work/000000000").iterdir()) == []


# -- never lose work -----------------------------------------------------------------------


def test_leftovers_of_a_kill_go(plan, undisturbed, tmp_path):
    run(tmp_path / "out", plan)
    late = tmp_path / "out/work/000000002"
    late.mkdir()
    (late / "00000006.fragment").write_bytes(b"a worker that was thought dead")
    for folder in (".", "shards/00000", "work/000000002", "work/stats"):
        (tmp_path / "out" / folder / ".a.tar.x1.part").write_bytes(b"half")
    run(tmp_path / "out", plan)
    assert tree(tmp_path / "out") == undisturbed
    assert not late.exists()
    assert not list((tmp_path / "out").rglob(".*"))


@pytest.mark.parametrize(
    "damage",
    [
        lambda path: path.with_suffix(".json").unlink(),
        lambda path: path.with_suffix(".json").write_text('{"of": '),
        lambda path: path.with_suffix(".json").write_text("[]"),
        lambda path: path.with_suffix(".json").write_bytes(b"\xff\xfe"),
        lambda path: path.unlink(),
        lambda path: path.write_bytes(path.read_bytes()[:-1]),
    ],
)
def test_a_fragment_that_does_not_count(plan, tmp_path, damage):
    with Store(tmp_path / "out", plan, "this") as store:
        for batch in store.batches(0):
            make_batch(store, batch)
        assert store.left(0) == []
        damage(tmp_path / "out/work/000000000/00000001.fragment")
        assert store.left(0) == [1]
        with pytest.raises(FileError, match=r"00000001\.fragment: missing, or not what was"):
            store.seal(0)


def test_bits_that_changed_on_the_disk(plan, undisturbed, tmp_path):
    with Store(tmp_path / "out", plan, "this") as store:
        for batch in store.batches(0):
            make_batch(store, batch)
        path = tmp_path / "out/work/000000000/00000001.fragment"
        data = bytearray(path.read_bytes())
        data[1000] ^= 1
        path.write_bytes(data)
        with pytest.raises(FileError, match="not what was written"):
            store.seal(0)
        assert store.left(0) == [1]
        make(store)
    assert tree(tmp_path / "out") == undisturbed


def test_another_program_makes_it_again(plan, tmp_path):
    with Store(tmp_path / "out", plan, "old") as store:
        make_batch(store, 0)
        for batch in store.batches(1):
            make_batch(store, batch)
        store.seal(1)
    with pytest.raises(InputError, match=r"another program: the program \(old.*--remake"):
        Store(tmp_path / "out", plan, "new").begin()
    assert Store(tmp_path / "out", plan, "old").done(1), "nothing is lost"
    with Store(tmp_path / "out", plan, "new", remake=True) as store:
        assert not store.done(1)
        assert store.left(0) == [0, 1, 2]
        assert store.left(1) == [3, 4, 5]
        make(store)
    assert tree(tmp_path / "out") == _made(tmp_path / "other", plan, "new")


def test_which_program_it_was_is_not_needed_to_see_that_it_was_another(plan, tmp_path):
    run(tmp_path / "out", plan, "old")
    (tmp_path / "out/program.json").unlink()
    with pytest.raises(InputError, match="not known"):
        Store(tmp_path / "out", plan, "new").begin()
    run(tmp_path / "out", plan, "old")
    assert (tmp_path / "out/program.json").exists()


def test_a_worker_with_another_program_is_refused(plan, tmp_path):
    with Store(tmp_path / "out", plan, "this"):
        Store(tmp_path / "out", plan, "this").join()
        with pytest.raises(InputError, match="a worker has another program"):
            Store(tmp_path / "out", plan, "other").join()


def _made(folder, plan, program):
    run(folder, plan, program)
    return tree(folder)


@pytest.mark.parametrize("suffix", [".tar", ".h5", ".json"])
def test_a_shard_whose_file_is_gone_is_not_done(plan, undisturbed, tmp_path, suffix):
    run(tmp_path / "out", plan)
    (tmp_path / "out/shards/00000/000000001").with_suffix(suffix).unlink()
    with Store(tmp_path / "out", plan, "this") as store:
        assert [store.done(k) for k in range(4)] == [True, False, True, True]
        make(store)
    assert tree(tmp_path / "out") == undisturbed


@pytest.mark.slow
@pytest.mark.parametrize("key", ["files", "inputs", "sums", "failures"])
def test_a_record_that_somebody_edited_does_not_count(plan, undisturbed, tmp_path, key):
    run(tmp_path / "out", plan)
    path = tmp_path / "out/shards/00000/000000001.json"
    record = json.loads(path.read_text())
    del record[key]
    path.write_text(json.dumps(record))
    with Store(tmp_path / "out", plan, "this") as store:
        assert [store.done(k) for k in range(4)] == [True, False, True, True]
        make(store)
    assert tree(tmp_path / "out") == undisturbed


def test_sealing_twice_changes_nothing(plan, undisturbed, tmp_path):
    run(tmp_path / "out", plan)
    tar = tmp_path / "out/shards/00000/000000001.tar"
    before = tar.stat().st_mtime_ns
    with Store(tmp_path / "out", plan, "this") as store:
        store.seal(1)
    assert tar.stat().st_mtime_ns == before


# -- the wrong folder ----------------------------------------------------------------------


def test_another_plan_in_the_folder(tmp_path):
    run(tmp_path / "out", plan_of(tmp_path))
    before = tree(tmp_path / "out")
    with pytest.raises(InputError, match=r"holds another plan: seed is 0 there and 3 now.*--out"):
        Store(tmp_path / "out", plan_of(tmp_path, seed=3)).begin()
    assert tree(tmp_path / "out") == before
    # The output folder does not affect the results.
    Store(tmp_path / "out", plan_of(tmp_path), "this").begin()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda base: (base / "c.npz").write_bytes(b""), r"1 new \(file c\.npz 0\)"),
        (lambda base: (base / "a.npz").unlink(), r"1 gone \(file a\.npz 0\)"),
        (lambda base: (base / "a.npz").rename(base / "z.npz"), r"1 new .*; 1 gone"),
    ],
)
def test_other_inputs(tmp_path, change, said):
    plan = plan_of(tmp_path)
    run(tmp_path / "out", plan)
    change(tmp_path)
    store = Store(tmp_path / "out", plan, "this")
    with pytest.raises(InputError, match=f"inputs are not those.*{said}.*put them back"):
        store.begin()
    # The folder is not left locked.
    plan_of(tmp_path)
    for name in ("c.npz", "z.npz"):
        (tmp_path / name).unlink(missing_ok=True)
    store.begin()
    store.close()


@pytest.mark.parametrize("given", ["absolute", "relative"])
def test_another_folder_than_the_plan_s_is_no_input(tmp_path, monkeypatch, given):
    plan_of(tmp_path)
    document = {"inputs": {"files": ["**/*.npz", "*/"]}, "outputs": {"folder": "else/where"}}
    (tmp_path / "clips").mkdir()
    plan = Plan.from_document(document, tmp_path)
    monkeypatch.chdir(tmp_path / "clips")
    out = tmp_path / "data" if given == "absolute" else Path("../data")
    for _ in range(2):
        with Store(out, plan, "this"):
            (tmp_path / "data" / "x.npz").touch()
    lines = (tmp_path / "data" / "inputs.txt").read_text().splitlines()
    assert lines == [f"file\t{name}\t0" for name in ("a.npz", "b.npz", "clips")]


def test_a_folder_of_something_else(tmp_path):
    plan = plan_of(tmp_path)
    with pytest.raises(InputError, match=r"found a\.npz, b\.npz and no plan\.yaml"):
        Store(tmp_path, plan).begin()
    with pytest.raises(FileError, match="a file, expected a folder"):
        Store(tmp_path / "a.npz", plan).begin()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.npz", "b.npz"]


@posix
def test_one_driver_at_a_time(tmp_path):
    plan = plan_of(tmp_path)
    read, write = os.pipe()
    done, finish = os.pipe()
    child = os.fork()
    if not child:
        os.close(finish)
        Store(tmp_path / "out", plan).begin()
        os.write(write, b"x")
        os.read(done, 1)
        os._exit(0)
    os.read(read, 1)
    second = Store(tmp_path / "out", plan)
    try:
        with pytest.raises(InputError, match=rf"another sweep works.*process {child} on "):
            second.begin()
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    second.begin()
    with pytest.raises(InputError, match=r"another sweep works.*this process"):
        Store(tmp_path / "out", plan).begin()
    second.close()
    for end in (read, write, done, finish):
        os.close(end)


def test_what_is_missing_is_said_at_once(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingDependencyError, match=r"halfphysics\[hdf5\]"):
        Store(tmp_path / "out", plan_of(tmp_path, formats=BOTH)).begin()
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written(tmp_path):
    plan = plan_of(tmp_path)
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="cannot write"):
        Store(tmp_path / "file" / "out", plan).begin()


# -- failures ------------------------------------------------------------------------------


def test_failures_are_listed_and_can_be_tried_again(plan, undisturbed, tmp_path):
    with Store(tmp_path / "out", plan, "this") as store:
        assert make(store, failed=(1, 13)) == {
            "shards": 4, "samples": 18, "skipped": 2, "failures": 2,
        }  # fmt: skip
    lines = (tmp_path / "out/failures.jsonl").read_text().splitlines()
    assert [json.loads(line)["number"] for line in lines] == [1, 13]
    assert json.loads(lines[0])["cause"] == "InputError: the clip is broken"
    with Store(tmp_path / "out", plan, "this") as store:
        assert store.drop_failed() == 2
        assert [store.done(k) for k in range(4)] == [False, True, False, True]
        # Only the batches of 1 and 13 are made again.
        assert [store.left(k) for k in range(4)] == [[0], [], [6], []]
        make(store)
    assert tree(tmp_path / "out") == undisturbed


def test_failures_without_a_tar_make_the_shard_again(tmp_path):
    with Store(tmp_path / "out", plan_of(tmp_path, formats=("hdf5",)), "this") as store:
        make(store, failed=(1,))
        assert store.drop_failed() == 1
        assert store.left(0) == [0, 1, 2]


def test_damaged_shards_are_not_reopened(plan, tmp_path):
    with Store(tmp_path / "out", plan, "this") as store:
        make(store, failed=(1,))
        tar = tmp_path / "out/shards/00000/000000000.tar"
        data = tar.read_bytes()
        tar.write_bytes(data[:20_000] + bytes([255]) * (len(data) - 20_000))
        with pytest.raises(FileError, match=r"000000000\.tar: damaged.*Remove it"):
            store.drop_failed()


def test_failures_of_open_shards_can_be_tried_again(plan, tmp_path):
    with Store(tmp_path / "out", plan, "this") as store:
        for batch in store.batches(0):
            make_batch(store, batch, failed=(2,))
        assert store.drop_failed() == 1
        assert store.left(0) == [1]

"""Sweeps that are killed, or run out of disk space, at any moment: the same end result."""

from __future__ import annotations

import os
import shutil
import signal
import sys
import time

import numpy as np
import pytest

from halfphysics.errors import FileError, HalfPhysicsError
from halfphysics.sweep.store.store import Store
from support.sweeps.sweep_shards import make, plan_of, run, tree

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


def changes_something(event, arguments, folder):
    """Whether an event of the interpreter writes in a folder."""
    path = arguments[0] if arguments else None
    if not isinstance(path, str | os.PathLike) or not str(path).startswith(str(folder)):
        return False
    if event == "open":
        return bool(arguments[2] & (os.O_WRONLY | os.O_RDWR))
    if event == "os.mkdir":
        return not os.path.exists(path)
    there = {"os.rename", "os.remove", "os.rmdir", "os.chmod", "os.truncate"}
    return event in there and os.path.exists(path)


def disturbed(folder, work, at, what):
    """Do work in another process, in which `what()` runs before operation `at` on `folder`.

    Returns its exit code: 0 if there are fewer operations, 2 if it came to its end
    nevertheless, 3 after an error of ours that names the folder.
    """
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    count = 0

    def hook(event, arguments):
        nonlocal count
        if changes_something(event, arguments, folder):
            count += 1
            if count == at:
                what()

    sys.addaudithook(hook)
    try:
        work()
    except HalfPhysicsError as error:
        os._exit(3 if str(folder) in str(error) else 4)
    except BaseException:
        os._exit(5)
    os._exit(2 if count >= at else 0)


def full():
    raise OSError(28, "No space left on device")


@posix
@pytest.mark.parametrize(
    ("what", "code", "formats", "every"),
    [(lambda: os._exit(9), 9, BOTH, 1), (full, 3, BOTH[:1], 2)],
    ids=["killed", "full"],
)
def test_disturbed_at_every_operation(tmp_path, what, code, formats, every):
    """Killed, or out of disk space, before any single file operation: the same bytes in the end."""
    if "hdf5" in formats:
        pytest.importorskip("h5py")
    plan = plan_of(tmp_path, variants=1, formats=formats)
    run(tmp_path / "whole", plan)
    expected = tree(tmp_path / "whole")
    codes = []
    while 0 not in codes:
        at = 1 + every * len(codes)
        folder = tmp_path / f"out{at}"
        codes.append(disturbed(folder, lambda f=folder: run(f, plan), at, what))
        run(folder, plan)
        assert tree(folder) == expected, f"operation {at}"
    assert at > 40
    # Cleaning up may fail silently.
    assert set(codes[:-1]) <= {code, 2}
    assert codes.count(2) < 5


@posix
def test_killed_at_random(plan, undisturbed, tmp_path):
    rng = np.random.default_rng(5)
    killed = 0
    while True:
        child = os.fork()
        if not child:
            run(tmp_path / "out", plan)
            os._exit(0)
        time.sleep(rng.uniform(0.0, 0.01 * (killed + 4)))
        os.kill(child, signal.SIGKILL)
        if os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0:
            break
        killed += 1
    assert killed >= 3
    assert tree(tmp_path / "out") == undisturbed


@posix
@pytest.mark.parametrize("limit", [100, 20_000, 100_000])
def test_a_full_disk(plan, undisturbed, tmp_path, limit):
    """The limit of a file's size stops writing in the middle of a file."""
    import resource

    read, write = os.pipe()
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        try:
            run(tmp_path / "out", plan)
        except FileError as error:
            os.write(write, str(error).encode())
        os._exit(0)
    os.close(write)
    os.waitpid(child, 0)
    with open(read) as pipe:
        said = pipe.read()
    assert str(tmp_path / "out") in said
    assert "Make room on the disk" in said
    assert not list((tmp_path / "out").rglob(".*.part"))
    run(tmp_path / "out", plan)
    assert tree(tmp_path / "out") == undisturbed


@posix
def test_disturbed_while_failures_are_tried_again(tmp_path):
    plan = plan_of(tmp_path, variants=2, batch=1, per_shard=4)  # batch 3 has no samples
    run(tmp_path / "whole", plan)
    expected = tree(tmp_path / "whole")
    with Store(tmp_path / "failed", plan, "this") as store:
        make(store, failed=(1,))

    def reopen(folder, then=lambda store: None):
        with Store(folder, plan, "this") as store:
            store.drop_failed()
            then(store)

    codes = []
    while 0 not in codes:
        at = 1 + 2 * len(codes)
        folder = tmp_path / f"out{at}"
        shutil.copytree(tmp_path / "failed", folder)
        codes.append(disturbed(folder, lambda f=folder: reopen(f), at, lambda: os._exit(9)))
        reopen(folder, make)
        assert tree(folder) == expected, f"operation {at}"
    assert at > 20

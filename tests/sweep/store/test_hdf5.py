"""HDF5 shards: the tar's content, the same bytes each time, and errors."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import numpy as np
import pytest

from halfphysics.errors import FileError, MissingDependencyError
from halfphysics.sweep.store.hdf5 import convert
from halfphysics.sweep.store.reading import read
from support.paths import ROOT
from support.sweeps.sweep_shards import sample, sample_with_card, write_tar

h5py = pytest.importorskip("h5py")


@pytest.fixture
def tar(tmp_path):
    return write_tar(tmp_path / "000000000.tar", [sample(k) for k in (0, 1, 4)])


def same(a, b):
    assert a.keys() == b.keys()
    for key, value in a.items():
        if isinstance(value, dict) and key != "card":
            same(value, b[key])
        elif isinstance(value, np.ndarray):
            np.testing.assert_array_equal(value, b[key])
            assert value.shape == b[key].shape
            if value.dtype.kind != "U":
                assert value.dtype == b[key].dtype
        else:
            assert value == b[key]


def test_the_same_samples_as_the_tar(tar, tmp_path):
    convert(read(tar), tmp_path / "a.h5")
    from_tar, from_h5 = list(read(tar)), list(read(tmp_path / "a.h5"))
    assert [s["key"] for s in from_h5] == ["000000000", "000000001", "000000004"]
    for a, b in zip(from_tar, from_h5, strict=True):
        same(a, b)


def test_laid_out_for_people(tar, tmp_path):
    convert(read(tar), tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        group = file["000000004"]
        assert json.loads(group.attrs["card"])["number"] == 4
        assert group["human/poses"].shape == (30, 156)
        assert group["human/gender"].asstr()[()] == "neutral"
        assert group["contact/body"].compression == "gzip"
        assert group["contact/body"].id.get_storage_size() < 5_000
        assert group["human/poses"].compression is None
        assert [str(n) for n in group["object/joints"].asstr()] == ["door/hinge", "door/handle"]
        assert group["contact/nothing"].shape == (0, 3)
        assert group["contact/body:cup"].shape == (30, 1000)


def test_the_same_bytes_at_another_time(tar, tmp_path):
    convert(read(tar), tmp_path / "a.h5")
    time.sleep(1.1)  # the library's dates have whole seconds
    (tmp_path / "elsewhere").mkdir()
    convert(read(tar), tmp_path / "elsewhere" / "b.h5")
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "elsewhere" / "b.h5").read_bytes()


def test_a_long_card(tmp_path):
    long = sample_with_card(2, {"number": 2, "notes": "ö" * 80_000})
    tar = write_tar(tmp_path / "a.tar", [long])
    convert(read(tar), tmp_path / "a.h5")
    (only,) = read(tmp_path / "a.h5")
    assert only["card"]["notes"] == "ö" * 80_000


def test_parts(tar, tmp_path):
    convert(read(tar), tmp_path / "a.h5")
    for one in read(tmp_path / "a.h5", ["card"]):
        assert one.keys() == {"key", "card"}


def test_no_file(tmp_path):
    (tmp_path / "a.h5").write_bytes(b"no HDF5 at all")
    with pytest.raises(FileError, match=r"a\.h5: damaged, or no shard"):
        list(read(tmp_path / "a.h5"))


def test_without_h5py(tar, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingDependencyError, match=r"halfphysics\[hdf5\]"):
        convert(read(tar), tmp_path / "a.h5")


@pytest.mark.skipif(sys.platform == "win32", reason="no limits there")
def test_a_full_disk(tmp_path):
    """The library reports it in its own ways; here it is an error of the system."""
    tar = write_tar(tmp_path / "a.tar", [sample(k) for k in range(8)])
    code = (
        "import resource, sys\n"
        "from pathlib import Path\n"
        "from halfphysics.sweep.store.hdf5 import convert\n"
        "from halfphysics.sweep.store.reading import read\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))\n"
        "try:\n"
        "    convert(read(Path(sys.argv[1])), Path(sys.argv[2]))\n"
        "except OSError as error:\n"
        "    print('stopped:', error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, tar, tmp_path / "a.h5"],
        capture_output=True,
        text=True,
        env={"PYTHONPATH": str(ROOT / "src")},
    )
    assert "stopped:" in done.stdout, done.stderr
    assert done.returncode == 0, done.stderr

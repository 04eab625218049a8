"""Loading a sweep's output: our reader, tarfile, WebDataset, h5py, and its documentation."""

from __future__ import annotations

import glob
import io
import json
import re
import runpy
import shutil
import tarfile
import zipfile

import numpy as np
import pytest

import halfphysics.sweep
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.sweep.store.data_card import DataCard
from halfphysics.sweep.store.reading import read
from halfphysics.sweep.store.store import Store
from support.paths import ROOT
from support.sweeps.sweep_shards import (
    arrays_of,
    make,
    make_batch,
    plan_of,
    run,
    sample,
    write_tar,
)

NUMBERS = [n for n in range(22) if n not in (3, 8)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A finished sweep with both formats."""
    pytest.importorskip("h5py")
    base = tmp_path_factory.mktemp("library")
    run(base / "out", plan_of(base, formats=("webdataset", "hdf5")))
    return base / "out"


def check(one, number):
    """Whether a sample equals the written one."""
    key, files = sample(number)
    assert one["key"] == key
    assert one["card"] == json.loads(files["card.json"])
    assert one.keys() == {"key", "card", "human", "object", "contact"}
    for part in ("human", "object", "contact"):
        expected = arrays_of(files[f"{part}.npz"])
        assert one[part].keys() == expected.keys()
        for name, value in expected.items():
            np.testing.assert_array_equal(one[part][name], value)


def test_read_a_folder(folder):
    samples = list(halfphysics.sweep.read(folder))
    assert len(samples) == len(NUMBERS)
    for one, number in zip(samples, NUMBERS, strict=True):
        check(one, number)


@pytest.mark.parametrize("suffix", [".tar", ".h5"])
def test_read_a_shard(folder, suffix):
    shard = folder / f"shards/00000/000000001{suffix}"
    for one, number in zip(read(shard), [6, 7, 9, 10, 11], strict=True):
        check(one, number)


def test_read_what_is_sealed_so_far(folder, tmp_path):
    there = tmp_path / "shards" / "00000"
    there.mkdir(parents=True)
    for name in ("000000001.tar", "000000001.json", "000000002.tar"):
        (there / name).write_bytes((folder / "shards/00000" / name).read_bytes())
    assert [one["key"] for one in read(tmp_path)][:2] == ["000000006", "000000007"]
    assert len(list(read(tmp_path))) == 5


def test_samples_of_two_programs_are_not_mixed(tmp_path):
    """While a sweep is made again, its folder has shards of the old program too."""
    plan = plan_of(tmp_path)
    run(tmp_path / "out", plan, "old")
    with Store(tmp_path / "out", plan, "new", remake=True) as store:
        for batch in store.batches(1):
            make_batch(store, batch)
        store.seal(1)
        with pytest.warns(HalfPhysicsWarning, match=r"000000000\.json: .* --remake") as said:
            keys = [one["key"] for one in read(tmp_path / "out")]
        assert len(said) == 1
        with tarfile.open(tmp_path / "out/shards/00000/000000001.tar") as archive:
            assert sorted(set(keys)) == sorted({n.partition(".")[0] for n in archive.getnames()})
        assert store.finish()["samples"] == len(keys) > 0
        make(store)
    assert len(list(read(tmp_path / "out"))) == len(NUMBERS)


def test_only_the_parts_that_are_asked_for(folder):
    for one in read(folder, parts=("card", "human")):
        assert one.keys() == {"key", "card", "human"}
    with pytest.raises(InputError, match=r"several names, such as \('human',\)"):
        read(folder, parts="human")


def test_samples_are_read_when_asked_for(folder, monkeypatch):
    opened = []
    whole = tarfile.open
    monkeypatch.setattr(tarfile, "open", lambda *how: opened.append(how) or whole(*how))
    samples = read(folder)
    assert opened == []
    next(samples)
    assert len(opened) == 1


def test_several_people(tmp_path):
    key, files = sample(0)
    files = {**files, "human.1.npz": files["human.npz"]}
    (one,) = read(write_tar(tmp_path / "a.tar", [(key, files)]))
    np.testing.assert_array_equal(one["human.1"]["trans"], one["human"]["trans"])


class _Trap:
    def __reduce__(self):
        return (pytest.fail, ("unpickled",))


def test_nothing_is_unpickled(tmp_path):
    key, files = sample(0)
    inner = io.BytesIO()
    with zipfile.ZipFile(inner, "w") as archive:
        header = io.BytesIO()
        np.lib.format.write_array(header, np.array([_Trap()], dtype=object), allow_pickle=True)
        archive.writestr("poses.npy", header.getvalue())
    assert b"unpickled" in inner.getvalue()
    bad = write_tar(tmp_path / "a.tar", [(key, {**files, "human.npz": inner.getvalue()})])
    with pytest.raises(FileError, match=r"a\.tar: damaged, or no shard"):
        list(read(bad))


@pytest.mark.parametrize("damage", ["cut", "between", "header", "other", "text", "name"])
def test_damaged_shards(folder, tmp_path, damage):
    shard = tmp_path / "a.tar"
    data = (folder / "shards/00000/000000000.tar").read_bytes()
    if damage == "cut":
        shard.write_bytes(data[: len(data) // 2 + 7])
    elif damage == "between":  # after a whole member, which tarfile would not notice
        with tarfile.open(folder / "shards/00000/000000000.tar") as archive:
            shard.write_bytes(data[: archive.getmembers()[5].offset])
    elif damage == "header":
        with tarfile.open(folder / "shards/00000/000000000.tar") as archive:
            at = archive.getmembers()[5].offset
        shard.write_bytes(data[:at] + bytes([255]) * 512 + data[at + 512 :])
    elif damage == "other":
        shard.write_bytes(bytes(range(256)) * 40)
    elif damage == "text":
        write_tar(shard, [("000000000", {"card.json": b"{"})])
    else:
        write_tar(shard, [("no", {"": b""})])
    with pytest.raises(FileError, match=r"a\.tar: damaged, or no shard of a sweep"):
        list(read(shard))


def test_a_shard_that_was_deleted(folder, tmp_path):
    shutil.copytree(folder / "shards", tmp_path / "shards")
    (tmp_path / "shards/notes.json").write_text("{}")
    assert len(list(read(tmp_path))) == len(NUMBERS), "what is no record is passed over"
    for suffix in (".tar", ".h5"):
        (tmp_path / "shards/00000/000000000").with_suffix(suffix).unlink(missing_ok=True)
    with pytest.raises(FileError, match=r"000000000: neither .* it is made again"):
        list(read(tmp_path))


def test_the_page_of_a_data_set_says_how_webdataset_reads_it(folder, monkeypatch):
    webdataset = pytest.importorskip("webdataset")
    code = DataCard().markdown().partition("as well: `WebDataset(")[2].partition(")`. ")[0]
    monkeypatch.chdir(folder)
    assert code == 'sorted(glob.glob("shards/*/*.tar"))'
    shards = sorted(glob.glob("shards/*/*.tar"))
    samples = webdataset.WebDataset(shards, shardshuffle=False, empty_check=False)
    assert len(list(samples)) == len(NUMBERS)


def test_wrong_paths(tmp_path):
    with pytest.raises(FileError, match=r"no such file, expected a folder of a sweep"):
        read(tmp_path / "missing")
    with pytest.raises(FileError, match="no shards here"):
        read(tmp_path)


def test_webdataset_reads_it(folder):
    """A sample is one to WebDataset too: keys, files, types."""
    webdataset = pytest.importorskip("webdataset")
    shards = sorted(str(path) for path in folder.glob("shards/*/*.tar"))
    data = webdataset.WebDataset(shards, shardshuffle=False, empty_check=False).decode()
    for one, number in zip(data, NUMBERS, strict=True):
        key, files = sample(number)
        assert one["__key__"] == key
        assert {name for name in one if not name.startswith("__")} == files.keys()
        assert one["card.json"]["number"] == number
        for name, value in arrays_of(files["human.npz"]).items():
            np.testing.assert_array_equal(one["human.npz"][name], value)


def test_plain_tarfile_reads_it(folder):
    with tarfile.open(folder / "shards/00000/000000003.tar") as archive:
        members = archive.getmembers()
        data = archive.extractfile("000000018.human.npz").read()
    names = list(sample(18)[1])
    assert [m.name for m in members] == [f"{n:09d}.{name}" for n in range(18, 22) for name in names]
    assert {(m.mtime, m.uid, m.gid, m.mode, m.uname) for m in members} == {(0, 0, 0, 0o644, "")}
    assert data == sample(18)[1]["human.npz"]


# -- the documentation and its code ----------------------------------------------------------


def loader_of(name):
    """The function `load` of an example, as text."""
    text = (ROOT / "examples" / name).read_text(encoding="utf-8")
    return re.search(r"^def load\(.*?(?=\n\n\n)", text, re.DOTALL | re.MULTILINE)[0]


@pytest.mark.parametrize(
    ("name", "package"),
    [
        ("05_load_a_sweep_webdataset.py", "webdataset"),
        ("06_load_a_sweep_hdf5.py", "h5py"),
    ],
)
def test_loaders_of_ten_lines(folder, name, package, capsys):
    pytest.importorskip(package)
    lines = [line for line in loader_of(name).splitlines() if line.strip()]
    assert len(lines) <= 10
    # The same lines are in the document about sweeps.
    assert loader_of(name) in (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
    example = runpy.run_path(str(ROOT / "examples" / name), run_name="example")
    loaded = list(example["load"](folder))
    assert len(loaded) == len(NUMBERS)
    for (factors, poses, trans, _), number in zip(loaded, NUMBERS, strict=True):
        human = arrays_of(sample(number)[1]["human.npz"])
        assert factors == {"mass": 0.5}
        np.testing.assert_array_equal(poses, human["poses"])
        np.testing.assert_array_equal(trans, human["trans"])
    assert example["main"](folder) == len(NUMBERS)
    assert "mass 0.5" in capsys.readouterr().out


def test_our_reader_in_the_docs(folder):
    """Its code block runs unchanged."""
    text = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(import halfphysics\.sweep\n.*?)```", text, re.DOTALL)
    names = {}
    exec(block.replace('"data"', repr(str(folder))), names)
    assert names["poses"].shape == (30, 156)

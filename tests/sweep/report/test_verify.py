"""Verifying a sweep: equal to the last bit, and every difference is found and located."""

from __future__ import annotations

import hashlib
import io
import json
import shutil
import tarfile
from pathlib import Path

import numpy as np
import pytest

from halfphysics.base.npz_bytes import npz_bytes
from halfphysics.errors import FileError, InputError
from halfphysics.scenarios import load
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.report.verify import Report, verify
from halfphysics.sweep.run.work import Task, do, opened
from halfphysics.sweep.store.comparing import contents_differ, files_differ
from halfphysics.sweep.store.store import Store
from support.sweeps.sweep_shards import arrays_of

#: Two clips of 12 frames with a ball of four masses, one of which is filtered out before it is
#: simulated, and one afterwards.
DOCUMENT = {
    "inputs": [{"files": ["clip?.npz"]}],
    "scenes": ["room.yaml"],
    "factors": {"object.ball.mass": [0.5, 1.0, 2.0, 4.0]},
    "keep": ["object.ball.mass != 1.0"],
    "keep_after": ["object.ball.mass != 2.0"],
    "outputs": {"batch": 2, "variants_per_shard": 4},
}
ROOM = "objects: {ball: {shape: sphere, radius: 0.1, mass: 1.0, position: [3, 0, 0.5]}}\n"


def made(folder: Path, seal=(0, 1), formats=("webdataset",)) -> Path:
    """A sweep, of which these shards are sealed."""
    motion = load("kick_ball").motions[0][10:22]
    for name in ("clip0.npz", "clip1.npz"):
        motion.save(folder / name)
    (folder / "room.yaml").write_text(ROOM)
    document = {**DOCUMENT, "outputs": {**DOCUMENT["outputs"], "formats": list(formats)}}
    plan = Plan.from_document(document, folder)
    out = folder / "out"
    with Store(out, plan) as store:
        for batch in range(store.layout.batches):
            done = do(str(out), Task("batches", store.layout.shard_of(batch), batch))
            assert done.stop == ""
            assert done.causes == ()
        for shard in seal:
            assert do(str(out), Task("seal", shard)).stop == ""
        store.finish()
    opened.cache_clear()
    return out


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return made(tmp_path_factory.mktemp("sweep"))


@pytest.fixture
def sweep(finished, tmp_path):
    """A copy that a test may spoil."""
    shutil.copytree(finished.parent, tmp_path / "all")
    return tmp_path / "all" / "out"


def differences(folder, **options):
    with pytest.raises(FileError) as caught:
        verify(folder, **options)
    return str(caught.value)


def rewritten(tar: Path, member: str, change) -> None:
    """Change a file of a shard, and its record, as a bug or another machine would."""
    with tarfile.open(tar) as archive:
        files = {m.name: archive.extractfile(m).read() for m in archive}
    files[member] = change(files[member])
    with tarfile.open(tar, "w", format=tarfile.USTAR_FORMAT) as archive:
        for name, data in files.items():
            if data is not None:
                info = tarfile.TarInfo(name)
                info.size = len(data)
                archive.addfile(info, io.BytesIO(data))
    honest(tar)


def honest(tar: Path) -> None:
    """Let the record of a shard have its file's present SHA-256."""
    record = json.loads(tar.with_suffix(".json").read_text())
    record["files"][".tar"]["sha256"] = hashlib.sha256(tar.read_bytes()).hexdigest()
    tar.with_suffix(".json").write_text(json.dumps(record))


SHARD = Path("shards/00000/000000000.tar")


def test_what_is_made_again_is_equal(finished):
    told = []
    report = verify(finished, count=100, progress=told.append)
    assert (report.equal, report.out) == (4, 2)  # of 8 variants: 2 filtered, 2 left out afterwards
    assert report.differences == report.notes == ()
    assert told == [1, 2, 3, 4]
    assert str(report) == (
        "4 sample(s) made again are equal bit by bit\n2 variant(s) without a sample again have none"
    )


def test_as_many_as_asked_and_others_with_another_seed(finished, monkeypatch):
    from halfphysics.sweep.make.making import Maker

    tried = []
    sample = Maker.sample
    monkeypatch.setattr(Maker, "sample", lambda self, n: (tried.append(n), sample(self, n))[1])
    chosen = []
    for seed in range(4):
        tried.clear()
        assert verify(finished, count=1, seed=seed).equal == 1
        chosen.append(tuple(tried))
    assert len(set(chosen)) > 1
    tried.clear()
    verify(finished, count=1, seed=3)
    assert tuple(tried) == chosen[3]


def test_one_bit_of_one_number_is_found(sweep):
    def change(data):
        fields = arrays_of(data)
        fields["poses"][7, 3] = np.nextafter(fields["poses"][7, 3], 9.0)
        return npz_bytes(fields)

    rewritten(sweep / SHARD, "000000000.human.npz", change)
    text = differences(sweep)
    assert "3 sample(s) made again are equal" in text
    assert "1 difference(s):\n  000000000: human.npz: poses[7, 3] is " in text
    assert f"(1 of {12 * 156:,} entries differ)" in text


def test_a_card_that_differs_is_found(sweep):
    def change(data):
        card = json.loads(data)
        card["objects"]["ball"]["travel"] += 1.0
        return json.dumps(card).encode()

    rewritten(sweep / SHARD, "000000000.card.json", change)
    assert "000000000: card.json: objects.ball.travel is 1." in differences(sweep)


def test_a_file_that_is_missing_is_found(sweep):
    rewritten(sweep / SHARD, "000000003.contact.npz", lambda data: None)
    assert "000000003: contact.npz is missing there" in differences(sweep)


def test_a_sample_that_is_missing_is_found(sweep):
    with tarfile.open(sweep / SHARD) as archive:
        names = [name for name in archive.getnames() if name.startswith("000000003.")]
    for name in names:
        rewritten(sweep / SHARD, name, lambda data: None)
    assert "000000003: has no sample there, and is made now" in differences(sweep)


def test_a_damaged_shard_is_found(sweep):
    path = sweep / SHARD
    data = bytearray(path.read_bytes())
    data[700] ^= 1  # in the first file of the first sample
    path.write_bytes(data)
    text = differences(sweep)
    assert f"{path}: is not what was written (SHA-256" in text
    assert "000000000: " in text


def test_a_shard_cut_short_is_found(sweep):
    path = sweep / SHARD
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(FileError, match=r"000000000\.tar"):
        verify(sweep)


def test_an_input_that_changed_is_found(sweep):
    clip = sweep.parent / "clip1.npz"
    motion = load("kick_ball").motions[0][11:23]
    motion.save(clip)
    text = differences(sweep)
    # Two samples are made from it, and it is reported once.
    assert "2 sample(s) made again are equal" in text
    assert text.count("clip1.npz is not the file any more") == 1


def test_an_input_that_has_gone_is_found(sweep):
    (sweep.parent / "clip0.npz").unlink()
    text = differences(sweep)
    assert "000000000: has a sample there, and fails: " in text
    assert "2 sample(s) made again are equal" in text


def test_another_program_is_told_and_its_numbers_are_compared(sweep):
    def change(data):
        card = json.loads(data)
        card["versions"] |= {"program": "ff" * 32, "numpy": "0.9"}
        return json.dumps(card).encode()

    rewritten(sweep / SHARD, "000000000.card.json", change)
    report = verify(sweep)
    assert report.equal == 4
    assert any(note.startswith("made by another program: numpy 0.9 there") for note in report.notes)

    def more(data):
        card = json.loads(data)
        return json.dumps({**card, "frames": 13}).encode()

    rewritten(sweep / SHARD, "000000000.card.json", more)
    text = differences(sweep)
    assert "card.json: frames is 13 there, 12 here" in text
    assert "made by another program" in text


def test_a_sweep_that_is_not_finished_can_be_verified(tmp_path):
    """A shard, and fragments of another; as HDF5 alone, which has no files to compare."""
    out = made(tmp_path, seal=(0,), formats=("hdf5",))
    report = verify(out)
    assert (report.equal, report.out) == (4, 2)
    h5 = out / SHARD.with_suffix(".h5")
    import h5py

    with h5py.File(h5, "r+") as file:
        file["000000000/human/trans"][4, 1] += 1.0
    text = differences(out)
    assert "000000000: human.npz: trans[4, 1] is " in text
    assert f"{h5}: is not what was written" in text
    assert "delete it and run the sweep" in text


def test_samples_are_found_where_nearly_all_variants_have_none(sweep, monkeypatch):
    """No drawn variant has a sample: a sample is compared nevertheless."""
    monkeypatch.setattr("halfphysics.sweep.report.verify._TRIES", 1)
    reports = [verify(sweep, count=1, seed=seed) for seed in range(8)]
    assert [report.equal for report in reports] == [1] * 8
    assert {report.out for report in reports} == {0, 1}


def test_a_batch_without_samples_is_verified_before_its_shard_is_sealed(tmp_path):
    """Its fragment has no bytes."""
    text = "inputs: {scenarios: kick_ball}\nfactors: {scenario.fps: [10], motion.yaw: [0, 1]}\n"
    (tmp_path / "plan.yaml").write_text(f"{text}keep: motion.yaw > 0\noutputs: {{batch: 1}}\n")
    with Store(tmp_path / "out", Plan.load(tmp_path / "plan.yaml")) as store:
        for batch in range(store.layout.batches):
            assert do(str(tmp_path / "out"), Task("batches", 0, batch)).stop == ""
        assert store.layout.fragment(0).stat().st_size == 0
    opened.cache_clear()
    assert str(verify(tmp_path / "out")) == "1 sample(s) made again are equal bit by bit"


def test_every_shard_that_cannot_be_read_is_listed(sweep):
    first, second = (sweep / f"shards/00000/00000000{k}.tar" for k in (0, 1))
    first.unlink()
    second.write_bytes(second.read_bytes()[:5000])
    text = differences(sweep)
    assert "2 difference(s)" in text
    (line,) = (line for line in text.splitlines() if str(first) in line)
    assert line.endswith(": cannot be read (No such file or directory). To have what is missing "
                         "made again, run the sweep")  # fmt: skip
    assert f"{second}: is not what was written (SHA-256" in text


def test_where_there_is_nothing_to_verify(tmp_path, sweep):
    with pytest.raises(FileError, match=r"no plan\.yaml"):
        verify(tmp_path / "none")
    assert str(Report(0, 0, (), ())) == "no sample to compare: none is there"
    for record in sweep.glob("shards/*/*.json"):
        edited = json.loads(record.read_text())
        del edited["files"]
        record.write_text(json.dumps(edited))
    with pytest.raises(FileError, match="expected the record of a shard"):
        verify(sweep)
    shutil.rmtree(sweep / "shards")
    with pytest.raises(InputError, match="nothing to compare yet"):
        verify(sweep)
    for count in (0, 2.0, True):
        with pytest.raises(InputError, match="count"):
            verify(sweep, count=count)


def test_differences_are_those_of_bits():
    nan, zero = np.array([np.nan, 0.0]), np.array([np.nan, -0.0])
    assert contents_differ("a.npz", {"x": nan}, {"x": nan.copy()}) == []
    assert contents_differ("a.npz", {"x": nan}, {"x": zero}) == [
        "a.npz: x[1] is 0.0 there, -0.0 here (1 of 2 entries differ)"
    ]
    one = {"x": np.zeros((2, 3)), "text": np.array("ab"), "none": np.zeros((0, 3))}
    assert contents_differ("a.npz", one, one) == []
    assert contents_differ("a.npz", one, {**one, "x": np.zeros((3, 2))}) == [
        "a.npz: x is float64 of shape (2, 3) there, float64 of (3, 2) here"
    ]
    assert contents_differ("a.npz", one, {**one, "text": np.array("aB")}) == [
        "a.npz: text[] is 'ab' there, 'aB' here (1 of 1 entries differ)"
    ]
    assert contents_differ("card.json", {"a": [1, 2]}, {"a": [1, 2.0]}) == [
        "card.json: a[1] is 2 there, 2.0 here"
    ]
    assert contents_differ("card.json", {"a": 1, "b": 2}, {"a": 1}) == [
        "card.json: b is there only"
    ]
    assert contents_differ("card.json", {"v": 1}, {"v": 2}, ("v",)) == []
    files = {"a.npz": npz_bytes(one), "card.json": b'{"a": 1}'}
    assert files_differ(files, files) == []
    assert files_differ(files, {**files, "card.json": b'{"a":1}'}) == [
        "card.json: the bytes differ, what is in it is the same"
    ]
    (text,) = files_differ(files, {**files, "a.npz": b"PK"})
    assert text.startswith("a.npz: cannot be read (")

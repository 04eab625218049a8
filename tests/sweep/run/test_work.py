"""Tasks of a sweep: the same bytes from any worker, and failures are reported and kept."""

from __future__ import annotations

import io
import json
import shutil
import tarfile
import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.sweep.make import making
from halfphysics.sweep.run.work import Task, do
from support.sweeps.sweep_case import PLAN, begun, data, planned


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A sweep done in order: its folder, and how its tasks ended."""
    folder = tmp_path_factory.mktemp("whole")
    store = begun(folder / "out", planned(folder))
    ends = [do(str(folder / "out"), Task("batches", 0, b)) for b in range(4)]
    ends.append(do(str(folder / "out"), Task("seal", 0)))
    ends.append(do(str(folder / "out"), Task("batches", 1, 4, 2)))
    ends.append(do(str(folder / "out"), Task("seal", 1)))
    store.finish()
    return folder / "out", ends


def samples_in(path):
    found = {}
    with tarfile.open(path) as archive:
        for member in archive:
            key, _, name = member.name.partition(".")
            found.setdefault(key, {})[name] = archive.extractfile(member).read()
    return found


def test_what_is_done_is_counted(whole):
    _, ends = whole
    assert [(e.kept, e.skipped, e.causes, e.stop) for e in ends] == [
        *[(2, 0, (), "")] * 4,
        (0, 0, (), ""),
        (3, 1, (), ""),
        (0, 0, (), ""),
    ]
    assert [e.variants for e in ends] == [2, 2, 2, 2, 0, 4, 0]
    assert all(e.size > 1000 for e in ends if e.kept)


def test_samples_are_what_simulate_says(whole):
    folder, _ = whole
    files = samples_in(folder / "shards/00000/000000001.tar")
    assert sorted(files) == ["000000008", "000000009", "000000010"], "the last is left out"
    card = json.loads(files["000000009"]["card.json"])
    assert card["factors"]["objects.friction"] == 0.4
    assert card["factors"]["objects.mass_factor"] == 2
    case = hp.scenarios.load("kick_ball", fps=10)
    scene = hp.Scene(gravity=case.scene.gravity)
    for static in case.scene.statics.values():
        scene.add_static(
            static.name, static.shape, position=static.position, quaternion=static.quaternion,
            friction=static.friction,
        )  # fmt: skip
    (ball,) = case.scene.objects.values()
    scene.add_object(
        ball.name, ball.shape, mass=2 * ball.mass, friction=0.4, restitution=ball.restitution,
        position=ball.position, quaternion=ball.quaternion,
    )  # fmt: skip
    result = hp.simulate(case.motion, scene, body=case.body, settings=case.settings)
    with np.load(io.BytesIO(files["000000009"]["object.npz"])) as found:
        assert np.array_equal(found["trans"], result.objects[ball.name].position)
    with np.load(io.BytesIO(files["000000009"]["human.npz"])) as found:
        assert np.array_equal(found["trans"], result.motion.translation)


def test_the_bytes_are_the_same_in_any_order_and_in_any_grouping(whole, tmp_path):
    folder, _ = whole
    out = tmp_path / "out"
    store = begun(out, planned(tmp_path))
    for task in (
        Task("batches", 1, 5), Task("batches", 0, 2, 2), Task("batches", 1, 4),
        Task("batches", 0, 0, 2), Task("batches", 0, 3), Task("seal", 1), Task("seal", 0),
        Task("seal", 0),
    ):  # fmt: skip
        assert do(str(out), task).stop == ""
    store.finish()
    ours, theirs = data(out), data(folder)
    del ours["plan.yaml"], theirs["plan.yaml"]  # it says which folder its paths are relative to
    assert ours == theirs


def test_what_fails_is_kept_with_its_cause_and_the_rest_goes_on(tmp_path, monkeypatch, capfd):
    (tmp_path / "bad.npz").write_bytes(b"no clip")
    text = PLAN.replace("inputs:", "inputs:\n  - files: bad.npz").split("factors:")[0]
    begun(tmp_path / "out", planned(tmp_path, f"{text}factors:\n  objects.friction: [0.5]\n"))
    done = do(str(tmp_path / "out"), Task("batches", 0, 0))
    assert done.kept == 1
    (cause,) = done.causes
    assert cause.startswith("bad.npz: "), "as the plan has it"
    assert capfd.readouterr().err == ""

    def bug(*_):
        raise KeyError("nothing")

    monkeypatch.setattr(making, "card_of", bug)
    done = do(str(tmp_path / "out"), Task("batches", 0, 0))
    assert done.kept == 0
    assert "KeyError: 'nothing' (a bug" in done.causes[1]
    assert capfd.readouterr().err.count("Traceback") == 1
    assert "a bug" in do(str(tmp_path / "out"), Task("batches", 0, 0)).causes[1]
    assert capfd.readouterr().err == "", "the same one is not told again"


def test_what_kills_its_process_is_recorded_and_not_made(tmp_path, monkeypatch):
    begun(tmp_path / "out", planned(tmp_path))
    out, made = str(tmp_path / "out"), []
    before = making.Maker.sample
    monkeypatch.setattr(
        making.Maker,
        "sample",
        lambda self, number, limit: made.append(number) or before(self, number, limit),
    )
    done = do(out, Task("batches", 0, 2, dead=((5, "it died"),)))
    assert done.causes == ("it died",)
    assert made == [4]
    record = json.loads((tmp_path / "out/work/000000000/00000002.json").read_text())
    (failure,) = record["failures"]
    assert (failure["number"], failure["input"]) == (5, "kick_ball")
    assert failure["factors"]["objects.mass_factor"] == 1
    assert record["sums"]["numbers"] == {"samples": 1, "skipped": 0, "failed": 1, "success": 1}


def test_what_a_process_needs_to_begin_is_not_the_tasks(tmp_path, monkeypatch):
    """Otherwise the first task would predict ten times the real total."""
    begun(tmp_path / "out", planned(tmp_path))
    before, naps = making.Maker.sample, [1.0]

    def sample(self, number, limit=None):
        if naps:
            time.sleep(naps.pop())
        return before(self, number, limit)

    monkeypatch.setattr(making.Maker, "sample", sample)
    first = do(str(tmp_path / "out"), Task("batches", 0, 0, 2)).seconds
    naps.append(1.0)
    later = do(str(tmp_path / "out"), Task("batches", 0, 2, 2)).seconds
    assert later > 1.0
    assert first < later - 0.5  # both grow alike on a busy machine


def test_to_try_a_variant_leaves_nothing(tmp_path):
    begun(tmp_path / "out", planned(tmp_path))
    before = sorted((tmp_path / "out").rglob("*"))
    assert do(str(tmp_path / "out"), Task("variants", 0, 4, 1)).stop == ""
    assert sorted((tmp_path / "out").rglob("*")) == before


def test_outputs_that_cannot_be_written_stop_it(tmp_path):
    begun(tmp_path / "out", planned(tmp_path))
    shutil.rmtree(tmp_path / "out/work", ignore_errors=True)
    (tmp_path / "out/work").write_text("in the way")
    done = do(str(tmp_path / "out"), Task("batches", 0, 0))
    assert "cannot write" in done.stop
    assert done.variants == 0


def test_a_folder_that_is_no_sweep(tmp_path):
    assert "plan.yaml" in do(str(tmp_path / "nothing"), Task("seal", 0)).stop


def test_want_of_memory_is_no_failure_of_one_try(tmp_path, monkeypatch):
    """It is a death: the process ends, and its work is tried again elsewhere."""
    begun(tmp_path / "out", planned(tmp_path))

    def full(*_):
        raise MemoryError

    monkeypatch.setattr(making, "card_of", full)
    with pytest.raises(MemoryError):
        do(str(tmp_path / "out"), Task("batches", 0, 0))
    assert list((tmp_path / "out/work/000000000").iterdir()) == [], "nothing half written"


def test_conditions_on_what_came_of_it(tmp_path):
    text = f"{PLAN}keep_after: contacts > 1000000\n"
    begun(tmp_path / "out", planned(tmp_path, text))
    done = do(str(tmp_path / "out"), Task("batches", 0, 0))
    assert (done.kept, done.skipped, done.size) == (0, 2, 0)


def test_labels_of_other_data_sets(tmp_path):
    text = f"{PLAN}labels: {{also: [behave, omomo, chois, arctic]}}\n"
    plan = planned(tmp_path, text.replace("batch: 2", "batch: 1").replace("shard: 8", "shard: 1"))
    begun(tmp_path / "out", plan)
    for kind in ("batches", "seal"):
        assert do(str(tmp_path / "out"), Task(kind, 0, 0)).stop == ""
    (sample,) = samples_in(tmp_path / "out/shards/00000/000000000.tar").values()
    assert set(sample) == {
        "card.json", "human.npz", "object.npz", "contact.npz",
        *(f"contact.{name}.npz" for name in ("behave", "omomo", "chois", "arctic")),
    }  # fmt: skip
    with np.load(io.BytesIO(sample["contact.chois.npz"])) as found:
        assert found["contact"].shape == (56, 4)
    with np.load(io.BytesIO(sample["contact.behave.npz"])) as found:
        assert found["contact_label"].shape[0] == 56

"""Attack scenes: a sample of `campaigns.attacks`, a few frames each, judged at every substep."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from campaigns import attacks
from campaigns.attacks import (
    MOST_WORK,
    Case,
    campaign,
    complaints,
    fuzz_cases,
    options_of,
    run,
    set_up,
    simulate,
    table,
)
from support.attacks.families import FAMILIES

pytest.importorskip("trimesh")

#: Family -> frames until its contacts are many. No frame of these took the old core seconds.
SAMPLE = {
    "needles": 6,
    "slivers": 5,
    "sheet_stack": 5,
    "ring": 8,
    "slot": 8,
    "thin_poles": 6,
    "wall_drive": 6,
    "stamp": 12,
    "two_flailing": 10,
}


#: Of the fuzz: (family, seed) -> frames until the costliest. The first frames of the first five
#: took 0.2 to 0.7 s that no budget knew; the others cost 3 to 16 budgets, since whoever came out of
#: something, was as strong as a human or turned fast tried again after the budget's end.
#: Of the last one ends of tries deep in a shell were looked at for touches, triangle by triangle.
COSTLY = {
    ("thrown_at", 49000): 3,
    ("two_clearance", 3001): 3,
    ("slot", 21001): 3,
    ("mesh_stamp", 40002): 3,
    ("ring_net", 37000): 3,
    ("object_pile", 159000): 8,
    ("object_pile", 265002): 15,
    ("thrown_at", 412001): 2,
    ("two_and_things", 422002): 17,
    ("heavy_on_light", 118001): 17,
    ("limp_soup", 453000): 12,
    ("thin_shell", 6173002): 9,
}


#: Of the fuzz, people and things that start inside something: (family, seed) -> frames. A finger
#: without a way out came clear by itself and was held by nothing for the substep in which that was
#: found; balls with their middles outside a mesh were not known to be in it; where people who were
#: stuck tried another way out, arms that had been clear went it too, through the mesh.
INSIDE = {("two_and_things", 59002): 3, ("object_pile", 69000): 4, ("many_substeps", 1375000): 1}

#: Of the fuzz, people whom the edge of a thin triangle touches: (family, seed) -> frames. Along the
#: triangle's normal that is as deep as the arm is thick: one was told to be inside, another went in
#: by 2.3 mm, as that did not grow.
EDGES = {("fine_tube", 5007001): 24, ("fine_tube", 4743000): 24, ("fine_tube", 5821000): 96}


def clearness(row):
    """The complaints that do not depend on the machine."""
    return [text for text in complaints(row) if "took" not in text]


@pytest.mark.parametrize("family", SAMPLE)
def test_attacks_leave_everybody_clear(family):
    row = run(Case(family, 0), SAMPLE[family])
    assert clearness(row) == []
    assert row["start_mm"] is None or row["start_mm"] > 0.0
    assert row["frames"] == SAMPLE[family]


@pytest.mark.parametrize(("family", "seed"), INSIDE)
def test_what_is_not_told_to_be_inside_is_clear(family, seed):
    row = run(Case(family, seed, fuzz=True), INSIDE[family, seed])
    assert row["start_mm"] < 0.0
    assert clearness(row) == []


@pytest.mark.parametrize(("family", "seed"), EDGES)
def test_edges_that_touch_stay_out(family, seed):
    row = run(Case(family, seed, fuzz=True), EDGES[family, seed])
    assert row["start_mm"] > 0.0
    assert row["breaches"] == 0
    assert clearness(row) == []


def test_pieces_that_all_islands_make_are_clear():
    """An elbow that was clear at the end of its step went 39 um into a mesh with the share that
    things elsewhere could make of theirs."""
    row = run(Case("heavy_on_light", 3070002, fuzz=True), 10)
    assert row["start_mm"] > 0.0
    assert row["breaches"] == 0
    assert clearness(row) == []


@pytest.mark.parametrize(("family", "seed"), COSTLY)
def test_no_frame_costs_much_more_than_its_budget(family, seed):
    """Of what is charged; what is not, the CPU time of `campaigns.attacks` shows."""
    row = run(Case(family, seed, fuzz=True), COSTLY[family, seed], judge=False)
    assert row["work"] <= MOST_WORK


def test_there_are_35_families():
    assert len(FAMILIES) >= 35


def test_a_case_is_the_same_attack_every_time():
    for case in (Case("leaves", 1), Case("leaves", 1, fuzz=True)):
        a, b = set_up(case), set_up(case)
        np.testing.assert_array_equal(a.motions[0].translation, b.motions[0].translation)
        assert list(a.scene.statics) == list(b.scene.statics)
        assert a.settings == b.settings


def test_fuzzing_mixes_two_families_and_draws_settings():
    cases = fuzz_cases(2, 100)
    some = [next(cases) for _ in range(8)]
    assert len({c.id for c in some}) == 8
    attack = set_up(some[0])
    assert {"substeps", "stiffness", "drive_time"} <= set(attack.settings)
    ran = simulate(attack, 2)
    assert len(ran.frames) == len(ran.seconds) == len(ran.work) == 2


def _ten_frames(task):
    """The row of a case that was not run."""
    row = {"id": task[0].id, "people": 1, "frames": 10, "slowest": [[0.0, 1]], "seconds": 1.0}
    row |= {"work": 0.0, "contacts": 0, "planes": 0, "lost": 0.0, "memory_mb": None, "breaches": 0}
    return row | {"finite": True}


def test_shards_share_the_cases_and_the_frames(tmp_path, monkeypatch):
    monkeypatch.setattr(attacks, "_work", _ten_frames)
    ids = []
    for k in range(2):
        log = tmp_path / f"{k}.jsonl"
        options = options_of(
            ["--fuzz", "100", "--seeds", "2", "--shard", f"{k}/2", "--log", str(log)]
        )
        rows = campaign(fuzz_cases(2, 100), options)
        assert 100 <= sum(row["frames"] for row in rows) < 150
        assert campaign(fuzz_cases(2, 100), options) == rows  # all are in the log
        ids.append([row["id"] for row in rows])
    some = [case.id for case in itertools.islice(fuzz_cases(2, 100), sum(map(len, ids)))]
    assert ids == [some[::2], some[1::2]]


@pytest.mark.parametrize("part", ["2/2", "1", "a/b", "0/0"])
def test_a_shard_that_would_leave_cases_out_is_refused(part, capsys):
    """The second of two is 1/2: "2/2" left out the first case, and said nothing."""
    with pytest.raises(SystemExit):
        options_of(["--shard", part])
    assert "expected k/n with k from 0 to n - 1" in capsys.readouterr().err


def test_a_row_complains_of_time_memory_and_depth():
    row = run(Case("ring", 0), 1, judge=False)
    assert "ring-0" in table([row])
    bad = {"slowest": [[9.0, 1]], "memory_mb": 99.0, "start_mm": 1.0, "gap_mm": -1.0}
    bad |= {"inside": 1, "crossed": 1, "later": 1, "pair": "a/b"}
    found = complaints(row | bad)
    assert len(found) == 5
    assert sum("UNREPORTED" in text for text in found) == 2
    assert len(complaints(row | bad | {"breaches": 1})) == 4

"""Tables of verdicts: text, CSV and JSON of values that are given."""

from __future__ import annotations

import csv
import json

import pytest

from halfphysics.cli.judge_tables import COLUMNS, csv_text, json_text, shown_names, text
from halfphysics.judging.judge import Judged
from halfphysics.metrics import judge
from halfphysics.metrics.measures import MEASURES
from halfphysics.metrics.verdict import Verdict
from support.made_clips import walk


def verdict(**values: float) -> Verdict:
    return Verdict(values=values, missing={"rte_percent": "takes a truth"}, frames=9, fps=30.0)


def people(count: int) -> list[Judged]:
    made = [
        Judged(f"clips/c{k}.npz", verdict(float_mm=float(k), bose_percent=90.0 - k))
        for k in range(count)
    ]
    return [*made, Judged("clips/bad.npz", error="clips/bad.npz: no known motion format " * 20)]


def test_few_clips_have_a_column_each():
    said = text(people(COLUMNS))
    head, _, *rows = said.splitlines()
    assert head.split() == ["c0.npz", "c1.npz", "c2.npz", "c3.npz", "better"]
    assert rows[0].split() == ["Float", "[mm]", "0", "1", "2", "3", "lower"]
    assert "not judged: clips/bad.npz: no known motion format" in said
    assert max(map(len, said.splitlines())) < 250
    assert "not measured, takes a truth: FootSkateFromContacts" in said


def test_what_is_missing_has_the_reason_of_the_clips():
    short = {"jerk": "takes at least 4 frames, found 2", "contact_f1": "takes tracks"}
    measured = Verdict(values={"float_mm": 1.0}, missing=short, frames=2, fps=30.0)
    said = text([Judged("a.npz", measured)])
    (line,) = (x for x in said.splitlines() if "takes at least 4 frames, found 2" in x)
    assert line == "not measured, takes at least 4 frames, found 2: jerk"
    assert "not measured, takes tracks: contact F1" in said


def test_a_clip_of_two_frames_beside_its_truth_lacks_no_truth():
    motion = walk()[:2]
    said = text([Judged("a.npz", judge(motion, truth=motion))])
    assert "takes a truth:" not in said
    assert "takes at least 3 frames, found 2: Accel" in said


def test_many_clips_are_summed_up():
    rows = [line.split() for line in text(people(11)).splitlines()]
    assert rows[0] == ["11", "clips", "mean", "median", "worst", "better", "worst", "clip"]
    assert ["Float", "[mm]", "5", "5", "10", "lower", "c10.npz"] in rows
    # More is better: the least is the worst.
    assert ["BoSE", "[%]", "85", "85", "80", "higher", "c10.npz"] in rows


def test_csv_has_a_row_for_each_clip():
    some = [Judged("a, b.npz", verdict(float_mm=0.1, bose_percent=float("nan"))), *people(1)]
    rows = list(csv.DictReader(csv_text(some).splitlines()))
    assert [row["clip"] for row in rows] == ["a, b.npz", "clips/c0.npz", "clips/bad.npz"]
    assert float(rows[0]["float_mm"]) == 0.1
    assert rows[0]["bose_percent"] == ""
    assert (rows[1]["frames"], rows[1]["fps"], rows[1]["error"]) == ("9", "30.0", "")
    assert rows[2]["error"].startswith("clips/bad.npz: no known motion format")


def test_json_has_definitions_values_and_reasons():
    some = [
        Judged("a.npz", verdict(float_mm=float("nan")), warnings=("y is up",)),
        Judged("b.npz", error="b.npz: gone"),
    ]
    document = json.loads(json_text(some))
    assert [m["key"] for m in document["measures"]] == [m.key for m in MEASURES]
    assert document["measures"][0]["source"].startswith("PhysDiff")
    first, second = document["clips"]
    assert first["values"] == {"float_mm": None}
    assert first["missing"] == {"rte_percent": "takes a truth"}
    assert first["warnings"] == ["y is up"]
    assert second == {"clip": "b.npz", "error": "b.npz: gone"}


@pytest.mark.parametrize(
    ("names", "shown"),
    [
        (["d/a.npz", "d/e/b.npz"], ["a.npz", "e/b.npz"]),
        (["/x/a.npz", "y/a.npz"], ["/x/a.npz", "y/a.npz"]),
        (["a.npz"], ["a.npz"]),
        (["/x/a.npz"], ["a.npz"]),
    ],
)
def test_common_folders_are_not_shown(names, shown):
    assert list(shown_names([Judged(name) for name in names]).values()) == shown

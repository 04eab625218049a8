"""Soft scenes at random: a sample of `campaigns.soft`, judged at every committed pose."""

from __future__ import annotations

import json
import warnings

import numpy as np
import pytest

from campaigns import soft
from support.soft.fuzz import KINDS, Case, set_up

pytest.importorskip("coal")
pytest.importorskip("trimesh")


@pytest.fixture(scope="module")
def rows():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return [soft.run(Case(7, index)) for index in range(8)]


def test_no_frame_is_entered(rows):
    told = [f"{row['id']}: {text}" for row in rows for text in soft.complaints(row)]
    told = [text for text in told if "took" not in text]
    assert not told, "\n".join(told)
    assert sum(row["pressed"] for row in rows) > 0


def test_a_foot_that_a_stiff_layer_throws_off_is_not_set_into_its_frame():
    """What a solve gave stayed once no sample was pressed any more, and was nobody's contact."""
    row = soft.run(soft.case_of("person-1-136"))
    assert (row["inside"], row["crossed"], row["breaches"]) == (0, 0, 0)


@pytest.mark.parametrize("case", ["things-0-69", "things-0-641", "things-2-117"])
def test_a_fast_thing_at_an_edge_gets_no_energy(case):
    """Normals turned within a step: pushes along those of its end gave more than there was."""
    row = soft.run(soft.case_of(case), judge=False)
    assert row["gained"] < 0.02


def test_a_case_is_the_same_every_time():
    """As scenes, and what comes of them."""
    for index in (1, 2):
        a, b = set_up(Case(3, index)), set_up(Case(3, index))
        assert list(a.simulator.world.scene.statics) == list(b.simulator.world.scene.statics)
        for setup in (a, b):
            setup.simulator.reset(setup.poses(0))
        for t in range(1, 4):
            one, other = a.simulator.step(a.poses(t)), b.simulator.step(b.poses(t))
            np.testing.assert_array_equal(one.substeps, other.substeps)


def test_cases_take_turns_and_have_names():
    some = [case for case, _ in zip(soft.cases(2), range(16), strict=False)]
    assert len({case.id for case in some}) == 16
    assert {case.kind for case in some} == set(KINDS)
    assert all(soft.case_of(case.id) == case for case in some)


def test_a_campaign_goes_on_where_it_was(tmp_path, monkeypatch):
    log, done = tmp_path / "soft.jsonl", []

    def quick(case):
        done.append(case.id)
        return {
            "id": case.id, "kind": case.kind, "frames": 10, "steps": 10, "pressed": 1,
            "finite": True, "slowest": 0.001, "people": 0, "gained": 0.0, "fastest": 1.0,
            "lost": 0.0, "breaches": 0, "gap_mm": 1.0,
        }  # fmt: skip

    monkeypatch.setattr(soft, "run", quick)
    for frames in (30, 50):
        options = soft.options_of(["--frames", str(frames), "--log", str(log), "--seeds", "2"])
        rows = soft.campaign(options)
    assert len(done) == len(set(done)) == 5 == len(rows)
    assert len(log.read_text().splitlines()) == 5
    assert json.loads(log.read_text().splitlines()[0])["id"] == "person-0-0"
    assert "all" in soft.summary(rows)


def test_a_row_complains():
    good = {
        "finite": True, "slowest": 0.001, "people": 1, "gained": 0.0, "fastest": 1.0,
        "lost": 0.0, "breaches": 0, "gap_mm": 0.5, "inside": 0, "crossed": 0, "pair": "a/b",
        "first_crossed": None,
    }  # fmt: skip
    assert soft.complaints(good) == []
    bad = good | {"slowest": 0.06, "gained": 0.02, "fastest": 99.0, "lost": 0.1, "lost_hard": 0.01}
    bad |= {"gap_mm": -0.01, "inside": 1, "crossed": 1}
    assert len(soft.complaints(bad)) == 6
    assert soft.complaints(good | {"finite": False}) == ["not finite"]

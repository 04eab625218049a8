"""tools/compare_results.py: the smallest change is found, and the record has every case."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass

import numpy as np
import pytest

from support.paths import ROOT


@pytest.fixture(scope="module", autouse=True)
def tools():
    sys.path.insert(0, str(ROOT / "tools"))
    yield
    sys.path.remove(str(ROOT / "tools"))


@dataclass
class Report:
    number: float
    _private: object = None


def test_every_bit_counts():
    from result_cases.digests import digest

    x = np.array([0.0, 1.0, np.nan])
    others = [
        x * -1.0,  # the sign of a zero
        np.nextafter(x, 2.0),
        x.astype(np.float32),
        x[None],
        x[:2],
        list(x),
        x.tobytes(),
        (x, None),
        {"x": x},
        Report(1.0),
        Report(1.0 + 1e-15),
        {"a": 1, "b": 2},
        {"b": 2, "a": 1},
        [1],
        [True],
        ["1"],
        [["a"], "b"],
        ["a", ["b"]],
        "ab",
        b"ab",
    ]
    found = [digest(value) for value in (x, *others)]
    assert len(set(found)) == len(found)
    assert digest(x[::-1][::-1]) == digest(x.copy())
    assert digest(Report(1.0, _private=object())) == digest(Report(1.0))
    with pytest.raises(TypeError, match="no way to hash object"):
        digest(object())


def test_a_case_comes_out_the_same_twice_and_a_nudge_is_seen():
    from result_cases import digests, live

    first, again, nudged = (
        digests.digests(live.piled(clearance=c)) for c in (1e-3, 1e-3, 1e-3 + 1e-12)
    )
    assert first == again
    assert nudged[0] != first[0]
    assert nudged[1]["objects"] != first[1]["objects"]
    assert nudged[1]["joints"] == first[1]["joints"]


def test_a_quick_comparison_has_a_case_of_every_family(shared_data):
    from result_cases import all_cases

    cases = all_cases()
    families = {name.split("/")[0] for name in cases}
    quick = {name.split("/")[0] for name, case in cases.items() if case.quick}
    played = {"push_door", "sit_on_sofa", "kick_ball", "grasp_glass"}  # others represent them
    assert families - quick <= played | {"file.gltf"}


def test_what_is_said_of_a_comparison(tmp_path, capsys):
    import compare_results

    file, head = tmp_path / "record.json", {"halfphysics": "here", "python": "3.11"}
    same = {"hash": "a", "values": {"x": "1", "y": "2"}}
    file.write_text(json.dumps({"about": {"python": "3.10"}, "cases": {"one": same, "two": same}}))
    assert compare_results.compare(file, head, [("one", same)]) == 0
    said = capsys.readouterr().out
    assert "another python: 3.10" in said
    other = {"hash": "b", "values": {"x": "1", "y": "3"}}
    outcomes = {"one": same, "two": other, "three": same, "four": {"error": "ValueError: no"}}
    assert compare_results.compare(file, head, outcomes.items()) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == "1 equal, 1 different, 1 failed, 1 unrecorded"
    assert any(line.startswith("different") and line.endswith("two: y") for line in lines)
    assert any(
        line.startswith("failed") and line.endswith("four: ValueError: no") for line in lines
    )


def test_a_case_that_fails_leaves_the_others(monkeypatch):
    import compare_results
    import result_cases
    from result_cases.case import Case

    def broken():
        raise ValueError("no")

    cases = {"good": Case("good", lambda: {"x": 1.0}), "bad": Case("bad", broken)}
    monkeypatch.setattr(result_cases, "all_cases", lambda: cases)
    assert compare_results.outcome_of("bad") == {"error": "ValueError: no"}
    assert set(compare_results.outcome_of("good")["values"]) == {"x"}

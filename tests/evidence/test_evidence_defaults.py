"""What changes under the defaults: both settings are measured, and only ours are judged."""

from __future__ import annotations

import json

import pytest

from evidence import model
from evidence.model import Options
from evidence.runner import function_of
from evidence.sections import defaults

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def compared():
    """The values of a quick report, as they come back from JSON."""
    found = {}
    for task in defaults.SECTION.tasks(Options(quick=True)):
        outcome = function_of(task)(**json.loads(json.dumps(dict(task.arguments))))
        found[task.key] = json.loads(json.dumps(model.plain(outcome.values, task.function)))
    return found


def test_tasks():
    few, all_ = (defaults.SECTION.tasks(Options(quick=quick)) for quick in (True, False))
    assert len(few) == 2 * len(defaults.QUICK)
    assert len(all_) == 2 * len(defaults.CASES) == len({task.key for task in all_})


def test_who_walks_over_the_floor_comes_down_to_it(compared):
    """30 mm up, the paper's setting walks on air; the defaults on the floor."""
    paper, ours = (compared[f"a-walk-30-mm-over-the-floor/{end}"] for end in ("paper", "default"))
    assert paper["floats"] > 25.0
    assert ours["floats"] < 5.0
    assert ours["pelvis at the end over the reference"] < -25.0
    assert abs(paper["pelvis at the end over the reference"]) < 0.1


def test_rows_and_verdicts(compared):
    content = defaults.SECTION.content(Options(quick=True), compared)
    model.to_dict(content)
    assert [row.setting for row in content.rows] == ["Settings.paper()", "Settings()"] * 2
    for row in content.rows:
        judged = [figure for figure in row.figures if figure.reproduced is not None]
        assert len(judged) == (2 if row.setting == "Settings()" else 0)
        assert all(figure.reproduced for figure in judged), row.name
    assert defaults.SECTION.content(Options(quick=True), {}).rows == ()


def test_what_fails_is_said_to_fail(compared):
    key = "sinking-into-a-sofa/default"
    worse = {**compared[key], "weight carried by nothing": 5.1, "beyond a joint's range": 2.1}
    (row,) = defaults.content(Options(quick=True), {key: worse}).rows
    wrong = {figure.name for figure in row.figures if figure.reproduced is False}
    assert wrong == {"weight carried by nothing", "beyond a joint's range"}

"""Pressures on foam: the table of what is published, and its judge."""

from __future__ import annotations

import json

import pytest

from evidence import interface_pressures as published
from evidence import model
from evidence.model import Options
from evidence.runner import function_of
from evidence.sections import pressures

pytestmark = pytest.mark.slow

#: Not yet human: 496 cm^2, where people on two chairs have 217 to 493. The report shows it as not
#: reproduced.
OPEN = {"area of the seat over 4 kPa"}


@pytest.fixture(scope="module")
def measured():
    found = {}
    for task in pressures.SECTION.tasks(Options(quick=True)):
        outcome = function_of(task)(**json.loads(json.dumps(dict(task.arguments))))
        found[task.key] = json.loads(json.dumps(model.plain(outcome.values, task.function)))
    return found


def test_the_table_has_sources_and_ranges():
    assert {row.posture for row in published.TABLE} == set(pressures.POSTURES)
    for row in published.TABLE:
        assert 0.0 < row.low < row.high
        assert len(row.source) > 40
        assert row.how
    assert len({(row.posture, row.measure) for row in published.TABLE}) == len(published.TABLE)


def test_every_published_measure_is_measured(measured):
    content = pressures.SECTION.content(Options(quick=True), measured)
    model.to_dict(content)
    assert len(content.rows) == len(published.TABLE) + 1
    assert all(row.figures[0].ours is not None for row in content.rows)


def test_pressures_are_those_of_people(measured):
    content = pressures.SECTION.content(Options(quick=True), measured)
    wrong = [
        f"{row.name}: {row.figures[0].ours:.2f}, expected {row.figures[0].expected}"
        for row in content.rows
        if not row.figures[0].reproduced and row.figures[0].name not in OPEN
    ]
    assert not wrong, "\n".join(wrong)


def test_a_hard_floor_would_not_pass():
    """Peaks on a hard floor are beyond the table, and the judge says so."""
    found = {"lying": {row.measure: 1e3 for row in published.rows("lying")}}
    content = pressures.SECTION.content(Options(quick=True), found)
    assert not any(row.figures[0].reproduced for row in content.rows)
    assert pressures.SECTION.content(Options(quick=True), {}).rows == ()

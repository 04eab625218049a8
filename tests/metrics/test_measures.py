"""The list of measures: complete, each with a function that exists, and in the documents."""

from __future__ import annotations

import inspect

import pytest

from halfphysics import metrics
from halfphysics.metrics.measures import BY_KEY, MEASURES, WANTED
from support.paths import ROOT


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.key)
def test_a_measure_has_a_function_with_its_definition_and_is_in_the_documents(measure):
    function = getattr(metrics, measure.function)
    assert inspect.getdoc(function)
    assert measure.definition
    assert measure.source
    assert measure.needs in ("", *WANTED)
    row = next(
        line
        for line in (ROOT / "docs" / "metrics.md").read_text(encoding="utf-8").splitlines()
        if line.startswith(f"| `{measure.key}` |")
    )
    assert [cell.strip() for cell in row.strip("| ").split(" | ")][1:] == [
        measure.name,
        measure.definition,
        measure.unit or "–",
        measure.better,
        measure.needs or "–",
        measure.source,
    ]


def test_keys_are_distinct():
    assert len(BY_KEY) == len(MEASURES)
    assert BY_KEY["foot_sliding_mm"].label == "FS [mm]"
    assert BY_KEY["gmd_skating_ratio"].label == "skating ratio"

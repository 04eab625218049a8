"""One row of the campaign of spins."""

from __future__ import annotations

import pytest

from campaigns import torsion


def test_a_row(monkeypatch):
    monkeypatch.setattr(torsion, "SHAPES", ("square",))
    monkeypatch.setattr(torsion, "FLOORS", ("plane",))
    monkeypatch.setattr(torsion, "SIZES", {0.2: ((60, None),)})
    rows = list(torsion.spins())
    assert [row[:3] for row in rows] == [("square", "plane", 0.2), ("square", "turned plane", 0.2)]
    assert [row[3] for row in rows] == pytest.approx([1.0, 1.0], abs=0.02)

"""A walk over one mat, and who stands on one: rows of the campaign."""

from __future__ import annotations

import halfphysics as hp
from campaigns import mats


def test_a_row_of_each(monkeypatch):
    monkeypatch.setattr(mats, "WALKS", (("mat", 0.05),))
    monkeypatch.setattr(mats, "STEPS", ((30.0, 4),))
    body = hp.Body.default()
    ((material, thickness, figures),) = mats.walks(body)
    assert (material, thickness) == ("mat", 0.05)
    assert figures.end < 0.05
    ((fps, substeps, depth, share),) = mats.sinks(body, "mat", 0.10)
    assert (fps, substeps) == (30.0, 4)
    assert 0.0 < depth < 0.10
    assert abs(share - 1.0) < 0.01

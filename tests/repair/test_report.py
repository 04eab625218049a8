"""Measures before and after: those of `halfphysics.metrics`, of each motion by itself."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.repair.report import measures
from support.damage import floating
from support.made_clips import standing

EXACT = 1e-12


def test_numbers_are_those_of_the_metrics():
    body = hp.Body.default()
    repair = hp.fix(floating(standing(), body))
    found = {m.name: m for m in measures(repair)}
    for name, field in (("Float", "float_mm"), ("Phys-Err", "phys_err_mm")):
        for motion, value in (
            (repair.originals[0], found[name].before),
            (repair.motion, found[name].after),
        ):
            assert abs(value - getattr(hp.metrics.physdiff(motion, body), field)) < EXACT
    way = body.joints(repair.motion) - body.joints(repair.originals[0])
    moved = 1000.0 * np.linalg.norm(way, axis=-1).mean()
    assert abs(found["joints moved"].after - moved) < 1e-6


def test_a_single_step_has_no_jerk():
    assert {m.name for m in measures(hp.fix(standing(3)))}.isdisjoint({"jerk", "Skate"})

"""Pressures of pairs by frame, from rows that are known."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.results.contacts import Contacts
from halfphysics.results.layer_pressure import SHOWN, carried_share, pressures
from halfphysics.results.result import PersonResult, Result
from halfphysics.results.soft_contacts import SoftContacts


def touches():
    """In frame 1 the bed pushes with 3 N s along its normal, and its friction takes back 1."""
    return Contacts(
        frame=np.array([1, 1]),
        person=np.zeros(2, dtype=int),
        part=np.zeros(2, dtype=int),
        other=np.zeros(2, dtype=int),
        position=np.zeros((2, 3)),
        normal=np.tile([0.0, 0.0, 1.0], (2, 1)),
        impulse=np.array([[0.0, 0.0, 3.0], [0.0, 0.0, -1.0]]),
        subject=np.full(2, -1),
        other_part=np.full(2, -1),
    )


@pytest.fixture(scope="module")
def result():
    """Frame 1 of 3: two samples of the person under 2 and 4 kPa, one under too little to show."""
    body = hp.Body.default()
    scene = hp.Scene()
    scene.add_static("bed", hp.Plane(), soft="mattress")
    motion = hp.Motion(np.zeros((3, 3)), np.zeros((3, 55, 3)), 30.0)
    rows = SoftContacts(
        frame=np.array([1, 1, 1]),
        layer=np.zeros(3, dtype=int),
        other=np.ones(3, dtype=int),
        part=np.zeros(3, dtype=int),
        vertex=np.arange(3),
        position=np.zeros((3, 3)),
        normal=np.tile([0.0, 0.0, 1.0], (3, 1)),
        depth=np.full(3, 0.01),
        pressure=np.array([2e3, 4e3, 0.5 * SHOWN]),
        area=np.array([0.03, 0.01, 1.0]),
    )
    return Result(
        people=(PersonResult(name="person", motion=motion, reference=motion, body=body),),
        objects={},
        scene=scene,
        names=("bed", "person"),
        contacts=touches(),
        clearance=np.zeros(3),
        lost_time=np.zeros(3),
        settings=hp.Settings(),
        soft_contacts=rows,
    )


def test_peak_mean_area_and_force_of_a_pair(result):
    (pair,) = pressures(result)
    assert (pair.layer, pair.other) == ("bed", "person")
    assert pair.peak.tolist() == [0.0, 4e3, 0.0]
    assert pair.area == pytest.approx([0.0, 0.04, 0.0])
    assert pair.mean == pytest.approx([0.0, (60.0 + 40.0) / 0.04, 0.0])
    assert pair.force[1] == pytest.approx([0.0, 0.0, 100.0 + 0.5 * SHOWN])


def test_the_share_of_the_weight_that_is_carried(result):
    weight = result.people[0].body.mass * 9.81
    assert carried_share(result, 0) == pytest.approx([0, 2.0 * 30.0 / weight, 0])


def test_the_summary_tells_it(result):
    lines = result.summary()
    assert "pressed on bed in frame 1 (0.03 s): peak 4 kPa in frame 1" in lines
    assert "2.5 kPa mean on 400 cm²" in lines


def test_nothing_soft_has_none(result):
    from dataclasses import replace

    hard = replace(result, soft_contacts=None, people=result.people, scene=result.scene)
    assert pressures(hard) == ()
    assert not carried_share(hard, 0).any()
    assert "pressed" not in hard.summary()


def test_indices_out_of_range_are_refused(result):
    from dataclasses import replace

    rows = replace(result.soft_contacts, layer=np.full(3, 7))
    with pytest.raises(hp.errors.InputError, match=r"soft_contacts\.layer: found 7 to 7"):
        replace(result, soft_contacts=rows, scene=result.scene)

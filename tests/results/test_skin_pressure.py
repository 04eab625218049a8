"""Pressure on skins: forces are kept, on the side that is pressed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics.body.skin_samples import vertex_areas
from halfphysics.errors import InputError
from halfphysics.results.skin_pressure import skin_pressure
from support.results.soft_results import FRAMES, soft_result


def area_of(body):
    return vertex_areas(body.rest_vertices, body.faces)[0]


def test_the_force_on_the_skin_is_that_of_its_samples():
    result = soft_result()
    body = result.people[0].body
    pressure = skin_pressure(result)
    assert pressure.shape == (FRAMES, len(body.rest_vertices))
    assert pressure.dtype == np.float32
    rows = result.soft_contacts
    mine = rows.other == 2
    force = np.bincount(rows.frame[mine], (rows.pressure * rows.area)[mine], FRAMES)
    np.testing.assert_allclose(pressure @ area_of(body), force, rtol=1e-5, atol=1e-4)
    assert force[-1] > 10.0


def test_the_back_is_pressed_and_the_front_is_not():
    """The person lies: what is pressed is on the lower half of the body."""
    result = soft_result()
    person = result.people[0]
    last = skin_pressure(result)[-1]
    z = person.body.vertices(person.motion, frames=[FRAMES - 1])[0][:, 2]
    pressed = last > 50.0
    assert pressed.sum() > 100
    assert z[pressed].max() < np.median(z)


def test_the_largest_is_near_that_of_the_samples():
    """Spreading over a sample's width takes off what a peak has of curvature."""
    result = soft_result()
    largest = result.soft_contacts.pressure[result.soft_contacts.other == 2].max()
    assert 0.5 * largest < skin_pressure(result).max() < 1.1 * largest


def test_what_presses_into_a_skin_presses_where_it_is():
    """A sample with the person as its layer: the vertices nearest to it."""
    result = soft_result()
    person = result.people[0]
    skin = person.body.vertices(person.motion, frames=[3])[0]
    rows = result.soft_contacts.at(3)[[0]]
    nose = int(skin[:, 2].argmax())
    into = dataclasses.replace(
        rows,
        layer=np.array([2]),
        other=np.array([1]),
        part=np.array([-1]),
        vertex=np.array([-1]),
        position=skin[[nose]] + 1e-4,
        pressure=np.array([1000.0]),
        area=np.array([4e-4]),
    )
    pressure = skin_pressure(dataclasses.replace(result, soft_contacts=into))
    assert pressure[3] @ area_of(person.body) == pytest.approx(0.4, rel=1e-5)
    assert np.linalg.norm(skin[pressure[3].argmax()] - skin[nose]) < 0.01
    assert not pressure[4].any()


def test_a_vertex_that_the_body_does_not_have():
    result = soft_result()
    rows = result.soft_contacts[result.soft_contacts.vertex >= 0][[0]]
    other = dataclasses.replace(rows, vertex=np.array([10**6]))
    with pytest.raises(InputError, match="found vertex 1000000, but the skin of"):
        skin_pressure(dataclasses.replace(result, soft_contacts=other))


def test_there_is_no_such_person():
    with pytest.raises(InputError, match="person: found 1, expected 0 to 0"):
        skin_pressure(soft_result(), 1)

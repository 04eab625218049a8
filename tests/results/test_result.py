"""Results in memory: their checks and their descriptions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import InputError
from support.results.random_result import make_result, touching


@pytest.fixture(scope="module")
def body():
    return Body.default()


def test_lengths_must_agree(body):
    with pytest.raises(InputError, match=r"found lengths .*'lost_time': 3.*expected 5"):
        make_result(body, lost_time=np.zeros(3))
    with pytest.raises(InputError, match=r"found lengths .*passes.*: 3.*expected 5"):
        make_result(body, diagnostics={"passes": np.zeros(3)})
    with pytest.raises(InputError, match="people: found none"):
        make_result(body, people=0)
    with pytest.raises(InputError, match="names: found"):
        make_result(body, names=("person0", "ball", "stick"))


def test_results_are_read_only(body):
    result = make_result(body)
    with pytest.raises(dataclasses.FrozenInstanceError):
        result.clearance = np.zeros(5)  # type: ignore[misc]
    for array in (result.clearance, result.contacts.impulse, result.objects["ball"].position):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_contacts_are_chosen_by_mask_and_index(body):
    contacts = make_result(body, seed=1).contacts
    assert len(contacts) > 3
    mask = np.arange(len(contacts)) % 2 == 0
    assert len(contacts[mask]) == mask.sum()
    np.testing.assert_array_equal(contacts[2].impulse, contacts.impulse[2:3])
    np.testing.assert_array_equal(contacts[1:3].part, contacts.part[1:3])


def test_free_frames(body):
    touched = touching([10, 20], [0, 0], [0, 0], [[0.0, 0.0, 1.0]] * 2)
    result = make_result(body, frames=40, contacts=touched)
    free = result.free_frames(settle=0.1)  # 3 frames at 29.97 fps
    expected = np.ones(40, dtype=bool)
    expected[10:14] = expected[20:24] = False
    np.testing.assert_array_equal(free, expected)
    with pytest.raises(InputError, match="person: found 1"):
        result.free_frames(1)
    assert not result.free_frames(settle=1e300)[10:].any()
    assert result.free_frames(settle=1e300)[:10].all()
    for wrong in (-0.1, np.nan, None, "0.1"):
        with pytest.raises(InputError, match=r"settle: expected a number of at least 0 \[s\]"):
            result.free_frames(settle=wrong)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("body", "body.npz", r"body: found 'body\.npz', expected a halfphysics Body"),
        ("body", Body, "body: found <class .*expected a halfphysics Body"),
        ("motion", None, "motion: found None, expected a halfphysics Motion"),
        ("reference", 3, "reference: found 3, expected a halfphysics Motion"),
    ],
)
def test_a_person_of_wrong_things(body, field, value, message):
    person = make_result(body).people[0]
    with pytest.raises(InputError, match=message):
        dataclasses.replace(person, **{field: value})


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("people", [3], r"people\[0\]: found 3, expected a halfphysics PersonResult"),
        ("scene", "room.yaml", "scene: found 'room.yaml', expected a halfphysics Scene"),
        ("contacts", [], r"contacts: found \[\], expected a halfphysics Contacts"),
        ("settings", {}, r"settings: found \{\}, expected a halfphysics Settings"),
    ],
)
def test_a_result_of_wrong_things(body, field, value, message):
    with pytest.raises(InputError, match=message):
        dataclasses.replace(make_result(body), **{field: value})

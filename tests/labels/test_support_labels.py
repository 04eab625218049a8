"""Support labels: the values of `PersonResult.support`, in the kinds that docs/labels.md states."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.npz_bytes import npz_bytes
from halfphysics.errors import InputError
from halfphysics.labels import support_labels


@pytest.fixture(scope="module")
def result():
    """Two people who shake hands, on a floor."""
    told = hp.scenarios.load("shake_hands")
    motions = [motion[:8] for motion in told.motions]
    return hp.simulate(motions, told.scene, body=told.bodies, settings=told.settings)


def test_every_person_has_the_values_of_the_result(result):
    found = support_labels(result)
    assert list(found["people"]) == [person.name for person in result.people]
    for before, person in zip(("", f"{result.people[1].name}/"), result.people, strict=True):
        support = person.support
        assert tuple(found[f"{before}surfaces"]) == support.names
        for name in ("force", "cop", "torque", "power", "residual", "required", "com"):
            value = found[before + name]
            assert value.dtype == np.float32
            np.testing.assert_array_equal(value, getattr(support, name).astype(np.float32))
        np.testing.assert_array_equal(found[f"{before}unsupported"], support.unsupported)
        np.testing.assert_array_equal(found[f"{before}airborne"], support.airborne)


def test_pressures_add_up_to_the_force_of_a_surface(result):
    found, floor = support_labels(result), result.people[0].support.names.index("floor")
    assert len(found["pressure/frame"]) > 0
    rows = found["pressure/surface"] == floor
    total = np.zeros((len(result.motion), 3))
    np.add.at(total, found["pressure/frame"][rows], found["pressure/force"][rows])
    # Float32 has a resolution of 6e-5 N at 700 N; about a hundred rows are added.
    np.testing.assert_allclose(total, found["force"][:, floor], atol=1e-2)


def test_indices_keep_their_values(result):
    found, pressure = support_labels(result), result.people[0].support.pressure
    for name in ("frame", "vertex", "part", "surface"):
        np.testing.assert_array_equal(found[f"pressure/{name}"], getattr(pressure, name))


def test_a_loaded_result_has_the_same_labels(result, tmp_path):
    """Support is not stored: it is found again from what is, with the same bits."""
    path = tmp_path / "result.npz"
    result.save(path)
    loaded = hp.Result.load(path)
    assert npz_bytes(support_labels(loaded)) == npz_bytes(support_labels(result))
    for one, two in zip(loaded.people, result.people, strict=True):
        for name in ("force", "cop", "torque", "residual", "required", "power", "com"):
            np.testing.assert_array_equal(getattr(one.support, name), getattr(two.support, name))


def test_other_things_than_results():
    with pytest.raises(InputError, match="result"):
        support_labels(3)

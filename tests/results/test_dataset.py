"""A result as a dataset of xarray: nothing is lost, and everything has names and units."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

import halfphysics as hp
from support import small_results as small

VECTORS = ("position", "normal", "impulse")
INDICES = ("person", "part", "other", "subject", "other_part")


@pytest.fixture(scope="module")
def dataset():
    return small.result().to_xarray()


def test_the_result_can_be_made_again(dataset):
    """Every number of motions, objects, joints and diagnostics is there, bit for bit."""
    result = small.result()
    assert dataset["time"].values.tolist() == [k / 30.0 for k in range(small.FRAMES)]
    for person in result.people:
        its = dataset.sel(person=person.name)
        assert np.array_equal(its["translation"], person.motion.translation)
        assert np.array_equal(its["rotation"], person.motion.rotations)
        assert np.array_equal(its["reference_translation"], person.reference.translation)
        assert np.array_equal(its["reference_rotation"], person.reference.rotations)
        assert np.array_equal(its["torque"], person.torque)
        assert np.array_equal(its["clock"], person.clock)
        assert np.array_equal(its["corrected"], person.corrected)
        assert np.array_equal(its["joint_position"], person.body.joints(person.motion))
    for name, track in result.objects.items():
        its = dataset.sel(object=name)
        assert np.array_equal(its["object_position"], track.position)
        assert np.array_equal(its["object_quaternion"], track.quaternion)
    assert np.array_equal(dataset["articulation_door.hinge"], result.joints["door/hinge"])
    assert np.array_equal(dataset["clearance"], result.clearance)
    assert np.array_equal(dataset["lost_time"], result.lost_time)
    for name, values in result.diagnostics.items():
        assert np.array_equal(dataset[f"diagnostic_{name}"], values)


def test_substeps(dataset):
    substeps = small.result().substeps
    second = dataset.sel(person="person1")
    assert np.array_equal(second["substep_rotation"], substeps.motions[1].rotations)
    crate = dataset["substep_object_position"].sel(object="crate")
    assert np.array_equal(crate, substeps.objects["crate"].position)
    assert float(dataset["substep"][-1]) == pytest.approx(float(dataset["time"][-1]), abs=1e-12)


def test_contacts_are_the_rows_with_names(dataset):
    result = small.result()
    contacts = result.contacts
    for name in VECTORS:
        assert np.array_equal(dataset[f"contact_{name}"], getattr(contacts, name))
    assert np.array_equal(dataset["contact_frame"], contacts.frame)
    persons = [person.name for person in result.people]
    known = {"person": persons, "part": hp.JOINT_NAMES, "other_part": hp.JOINT_NAMES}
    for name in INDICES:
        names = [*known.get(name, result.names), ""]
        found = [names.index(text) for text in dataset[f"contact_{name}"].values.tolist()]
        expected = np.where(getattr(contacts, name) < 0, len(names) - 1, getattr(contacts, name))
        assert found == expected.tolist()


def test_dimensions_and_units(dataset):
    assert dataset["torque"].dims == ("person", "time", "joint", "xyz")
    assert dataset["torque"].attrs["units"] == "N m"
    assert dataset["rotation"].attrs["units"] == "rad"
    assert dataset["contact_impulse"].dims == ("contact", "xyz")
    assert dataset["contact_impulse"].attrs["units"] == "N s"
    assert dataset["time"].attrs["units"] == "s"
    assert dataset["joint"].values.tolist() == list(hp.JOINT_NAMES)
    assert dataset.sizes["inside"] == 0
    height = dataset["joint_position"].sel(joint="head", xyz="z", person="person0")
    assert height.dims == ("time",)
    assert "z-up" in dataset.attrs["description"]
    assert dataset.attrs["fps"] == 30.0
    assert dataset.attrs["gender"] == "neutral, neutral"


def test_goes_into_a_netcdf_file(dataset, tmp_path):
    """Of version 3, the one that scipy writes: it has no text in lists and no long integers."""
    xarray = pytest.importorskip("xarray")
    dataset.to_netcdf(tmp_path / "r.nc", engine="scipy")
    with xarray.open_dataset(tmp_path / "r.nc", engine="scipy") as again:
        assert again.sizes == dataset.sizes
        for name in dataset.variables:
            assert np.array_equal(again[name], dataset[name]), name


def test_of_one_person_without_substeps():
    found = small.alone().to_xarray(joints=False)
    assert "joint_position" not in found
    assert "substep" not in found.dims
    assert found.sizes["person"] == 1


def test_recorded_motion_and_betas_where_they_are():
    result = small.alone()
    person = result.people[0]
    recorded = person.reference.with_frames(
        person.reference.translation + 0.01, person.reference.rotations
    )
    adapted = replace(person.reference, recorded=recorded, betas=np.array([0.5, -1.0]))
    moved = replace(person.motion, betas=np.array([0.5, -1.0]))
    other = replace(result, people=(replace(person, reference=adapted, motion=moved),))
    found = other.to_xarray(joints=False)
    assert np.array_equal(found["recorded_translation"][0], recorded.translation)
    assert found["betas"].values.tolist() == [[0.5, -1.0]]
    assert "recorded_translation" not in result.to_xarray(joints=False)


def test_vertices_when_asked_for():
    result = small.alone()
    person = result.people[0]
    found = result.to_xarray(joints=False, vertices=True)["vertex_position"]
    assert found.dims == ("person", "time", "vertex", "xyz")
    expected = person.body.vertices(person.motion, frames=[5])[0]
    assert np.array_equal(found[0, 5], expected)


def test_people_of_different_skins():
    import halfphysics.results.dataset as module

    class Person:
        def __init__(self, name, count):
            self.name = name
            self.body = type("", (), {"rest_vertices": np.zeros((count, 3))})()

    result = type("", (), {"people": (Person("a", 4), Person("b", 5))})()
    with pytest.raises(
        hp.errors.InputError, match=r"skins of different sizes \({'a': 4, 'b': 5}\)"
    ):
        module._skins(result)


def test_xarray_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(hp.errors.MissingDependencyError, match=r"datasets need xarray: pip inst"):
        small.alone().to_xarray()


def test_a_free_joint_is_a_position_and_a_quaternion(tmp_path):
    """A box that falls, of an articulated object, with a lid on a ball joint."""
    scene = hp.Scene()
    scene.add_articulated(
        "thing",
        '<mujoco><worldbody><body name="base" pos="0.6 0 1"><freejoint name="f"/>'
        '<geom type="box" size=".1 .1 .1" mass="1"/><body name="lid" pos="0 0 .12">'
        '<joint name="b" type="ball"/><geom type="box" size=".1 .1 .02" mass=".3"/></body></body>'
        "</worldbody></mujoco>",
    )
    still = hp.Motion(np.tile([0.0, 3.0, 1.0], (6, 1)), np.zeros((6, 55, 3)), 30.0)
    result = hp.simulate(still, scene)
    found = result.to_xarray(joints=False)
    base = result.objects["thing/base"]
    place, turn = found["articulation_thing.f_position"], found["articulation_thing.f_quaternion"]
    assert (place.dims, turn.dims) == (("time", "xyz"), ("time", "wxyz"))
    assert place.attrs == {"units": "m"}
    assert place[-1, 2] < 0.9
    np.testing.assert_allclose(place, base.position, atol=1e-12)
    assert np.array_equal(np.hstack([place, turn]), result.joints["thing/f"])
    assert found["articulation_thing.b"].dims == ("time", "wxyz")
    found.to_netcdf(tmp_path / "free.nc", engine="scipy")

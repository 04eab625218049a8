"""Contact labels as arrays: names, shapes, kinds, and dense labels against sparse ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.labels import contact_labels
from halfphysics.labels.solver_contacts import solver_contacts
from halfphysics.results.result import Result


@cache
def story(name: str, start: int, end: int) -> Result:
    """A scenario from one frame to another."""
    told = hp.scenarios.load(name)
    motions = [motion[start:end] for motion in told.motions]
    return hp.simulate(motions, told.scene, body=list(told.bodies), settings=told.settings)


def test_one_person_and_one_object_have_the_plain_keys_of_grab():
    result = story("kick_ball", 60, 110)
    labels = contact_labels(result)
    arrays = labels.arrays()
    frames, skin = len(result.motion), len(result.people[0].body.rest_vertices)
    surface = len(labels.objects[0].vertices)
    expected = {
        "body": ((frames, skin), np.int8),
        "object": ((frames, surface), np.int8),
        "human_parts": ((frames, 55), np.bool_),
        "scene_parts": ((frames, 55), np.bool_),
        "people_parts": ((frames, 55), np.bool_),
        "hands_feet": ((frames, 4), np.bool_),
        "force": ((frames, 55, 3), np.float32),
        "force_objects": ((frames, 55, 3), np.float32),
        "object_vertices": ((surface, 3), np.float32),
    }
    for key, (shape, kind) in expected.items():
        assert arrays[key].shape == shape, key
        assert arrays[key].dtype == kind, key
    assert not any("ball" in key or key.startswith("person") for key in arrays)
    assert float(arrays["threshold_m"]) == result.settings.clearance + 1e-3
    # The label of a vertex is its part and 1; that part is then among those in contact.
    frame, vertex = np.nonzero(arrays["body"])
    assert len(frame) > 0
    part = arrays["body"][frame, vertex] - 1
    assert (part == labels.people[0].vertex_part[vertex]).all()
    assert arrays["human_parts"][frame, part].all()


def test_every_impulse_has_a_label_and_counts_in_a_force():
    result = story("kick_ball", 60, 110)
    labels, contacts = contact_labels(result), result.contacts
    ball = result.names.index("ball")
    pushed = (contacts.person == 0) & (contacts.strength > 0.0)
    who = labels.people[0]
    for row in np.flatnonzero(pushed):
        parts = who.human_parts if contacts.other[row] == ball else who.scene_parts
        assert parts[contacts.frame[row], contacts.part[row]]
    total = contacts.impulse[pushed].sum(axis=0) * result.fps
    np.testing.assert_allclose(who.force.sum(axis=(0, 1)), total, rtol=1e-12, atol=1e-9)
    kicks = pushed & (contacts.other == ball)
    assert kicks.any()
    total = contacts.impulse[kicks].sum(axis=0) * result.fps
    np.testing.assert_allclose(who.force_objects.sum(axis=(0, 1)), total, rtol=1e-12, atol=1e-9)


def test_two_people_have_keys_of_their_own():
    result = story("shake_hands", 90, 110)
    arrays = contact_labels(result).arrays(scene=True)
    skins = [len(person.body.rest_vertices) for person in result.people]
    frames = len(result.motion)
    assert arrays["scene"].shape == (frames, skins[0])
    assert arrays["person1/scene"].shape == (frames, skins[1])
    assert arrays["object"].shape == (frames, 0)
    assert list(arrays["people"]) == ["person0", "person1"]
    contacts = result.contacts
    between = (contacts.other_part >= 0) & (contacts.strength > 0.0)
    assert between.any()
    for row in np.flatnonzero(between):
        key = ("" if contacts.person[row] == 0 else "person1/") + "people_parts"
        assert arrays[key][contacts.frame[row], contacts.part[row]]


def test_links_are_objects_one_by_one_and_what_no_joint_moves_stands():
    result = story("open_drawer", 70, 80)
    labels = contact_labels(result)
    names = [item.name for item in labels.objects]
    fixed = {
        name
        for item in result.scene.articulated.values()
        for name, link in zip(item.link_names, item.links, strict=True)
        if link.fixed
    }
    assert fixed
    assert len(names) > 1
    assert not fixed & set(names)
    arrays = labels.arrays()
    for name in names[1:]:
        assert f"body/{name}" in arrays
        assert f"object/{name}" in arrays
        assert f"object_vertices/{name}" in arrays
    assert list(arrays["objects"]) == names


def test_farther_than_clearance_and_a_millimetre_is_no_contact():
    result = story("kick_ball", 60, 110)
    with pytest.raises(InputError, match=r"expected at most 0\.002 m"):
        contact_labels(result, threshold=0.0021)
    labels = contact_labels(result, threshold=0.0005, reach=0.01)
    assert labels.threshold_m == 0.0005
    with pytest.raises(InputError, match=r"contact_labels\(result, reach=0\.02\)"):
        labels.skin_near(0.02)
    with pytest.raises(InputError, match="person 1 and object 0, expected one of 1 people"):
        labels.skin_near(0.01, person=1)
    for wrong in ("ball", None, [0], 0.0, -1, True):
        with pytest.raises(InputError, match=r"and object .*by their index \(0: ball\)"):
            labels.skin_near(0.01, item=wrong)
    with pytest.raises(InputError, match="within: expected a number of at least 0"):
        labels.skin_near([0.01])
    with pytest.raises(InputError, match="Result"):
        contact_labels(result.motion)


def test_ids_are_of_people_and_objects_that_are_there():
    labels = contact_labels(story("kick_ball", 60, 70))
    for wrong in ("ball", 1, -1, None):
        with pytest.raises(InputError, match=r"labels: found person 0 and object .*\(0: ball\)"):
            labels.object_ids(item=wrong)
        with pytest.raises(InputError, match=r"labels: found object .*, expected one of 1 objects"):
            labels.people[0].body(wrong)
        with pytest.raises(InputError, match=r"labels: found person .* and object 0"):
            labels.object_ids(person=wrong)


def test_without_objects_the_first_has_no_vertices():
    motion = hp.scenarios.load("kick_ball").motions[0][60:64]
    labels = contact_labels(hp.simulate(motion, hp.Scene()))
    assert labels.object.shape == (4, 0)
    assert not labels.body.any()
    with pytest.raises(InputError, match=r"expected one of 1 people and of 0 objects"):
        labels.object_ids(item=1)
    with pytest.raises(InputError, match="expected one of 0 objects"):
        labels.people[0].body(1)


def test_what_has_bounced_far_off_by_the_end_of_the_frame_has_no_distance():
    """0.8 m a frame: the ball meets the wall and is beyond the reach of 0.1 m again."""
    scene = hp.Scene(gravity=0.0)
    scene.add_static("wall", hp.Box((0.2, 4.0, 4.0)), position=(3.1, 0.0, 0.0), restitution=0.9)
    ball = {"mass": 1.0, "position": (2.5, 0.0, 0.0), "velocity": (8.0, 0.0, 0.0)}
    scene.add_object("ball", hp.Sphere(0.1), restitution=0.9, **ball)
    motion = hp.Motion(np.zeros((4, 3)), np.zeros((4, 55, 3)), 10.0)
    result = hp.simulate(motion, scene, settings=hp.settings.Settings(weight=False))
    found = solver_contacts(result)
    assert np.isposinf(found.distance).any()
    assert np.isposinf(found.arrays()["distance"]).any()
    with pytest.raises(InputError, match="NaN"):
        replace(found, distance=np.full(len(found), np.nan))


def test_pressures_on_soft_things_are_among_the_arrays():
    hard = hp.scenarios.load("sit_on_sofa")
    scene = hp.Scene()
    for name, item in hard.scene.statics.items():
        soft = "sofa" if name == "seat" else None
        scene.add_static(name, item.shape, position=item.position, soft=soft)
    result = hp.simulate(hard.motion[40:60], scene, body=hard.body, settings=hard.settings)
    labels = contact_labels(result)
    arrays = labels.arrays()
    rows = result.soft_contacts
    assert len(rows) > 0
    assert {k.removeprefix("soft/") for k in arrays if k.startswith("soft/")} == set(rows.columns())
    assert np.array_equal(arrays["soft/pressure"], rows.pressure)
    assert (arrays["soft/part"].dtype, arrays["soft/vertex"].dtype) == (np.int8, np.int32)
    # What presses touches: by its distance from the surface, into which it sinks.
    assert labels.people[0].scene_parts[rows.frame, rows.part].mean() > 0.95

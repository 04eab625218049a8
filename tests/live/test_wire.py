"""From frames to messages, and from messages to poses."""

from __future__ import annotations

import json

import numpy as np
import pytest
from msgspec import UNSET

import halfphysics as hp
from halfphysics.live import schema
from halfphysics.live.scene_items import MOST_FACES, person_item, scene_items, shape_document
from halfphysics.live.session import Session
from halfphysics.live.wire import Subscription, frame_message, incoming_poses


@pytest.fixture
def frame(session):
    """Two people who stand on the floor."""
    for _ in range(3):
        made = session.step()
    return made


def test_a_frame_says_what_the_simulator_has(frame):
    message = frame_message(frame, Subscription())
    person = message.people["person0"]
    np.testing.assert_array_equal(person.translation, frame.poses["person0"].translation)
    np.testing.assert_array_equal(person.rotations, frame.poses["person0"].rotations)
    np.testing.assert_array_equal(message.objects["ball"].position, frame.objects["ball"][0])
    assert message.frame == 3
    assert person.tracking == "waiting"
    assert len(message.contacts) == len(frame.contacts.part) > 0
    for row, contact in enumerate(message.contacts):
        assert contact.other in frame.names
        np.testing.assert_allclose(contact.force, 90.0 * frame.contacts.impulse[row])
        if frame.contacts.person[row] < 0:
            assert (contact.subject, contact.part) == ("ball", None)


@pytest.mark.parametrize(
    ("subscribe", "fields"),
    [
        ({"parts": ["poses"]}, {"translation", "rotations"}),
        ({"parts": ["targets"]}, {"target_translation", "target_rotations"}),
        ({"parts": []}, set()),
    ],
)
def test_what_is_not_wanted_is_left_out(frame, subscribe, fields):
    wanted = Subscription.of(schema.Subscribe(**subscribe))
    data = json.loads(schema.encode(frame_message(frame, wanted), False))
    assert not {"objects", "joints", "contacts"} & set(data)
    assert set(data["people"]["person0"]) - {"tracking", "stamp"} == fields


def test_some_people(frame):
    wanted = Subscription.of(schema.Subscribe(people=["person1", "nobody"]))
    assert list(frame_message(frame, wanted).people) == ["person1"]


def test_poses_of_one_message(session):
    person = schema.PersonPose((1.0, 2.0, 3.0), [(0.1, 0.2, 0.3)] * 55, [False] * 55)
    message = schema.PoseMessage({"ada": person, "ben": person}, float("nan"))
    poses = incoming_poses(message, "ws:1")
    assert [(pose.person, pose.source, pose.time) for pose in poses] == [
        ("ada", "ws:1", None),
        ("ben", "ws:1", None),
    ]
    np.testing.assert_array_equal(poses[0].pose.translation, (1, 2, 3))
    assert not poses[0].tracked.any()


def test_items_of_the_scene(scene):
    statics, objects = scene_items(scene)
    assert [item.name for item in statics] == ["floor", "wall"]
    assert statics[1].shape == {"kind": "box", "size": [0.2, 4.0, 2.0]}
    assert objects[0].shape == {"kind": "sphere", "radius": 0.1}
    assert objects[0].mass == 1.0
    person = person_item("ada", hp.Body.default())
    assert np.shape(person.joints) == (55, 3)


def test_pressures_go_to_who_names_them():
    """A ball on a mattress: pair by pair, to a tenth of a pascal."""
    scene = hp.Scene()
    scene.add_static("bed", hp.Box((1, 1, 0.4)), soft="mattress")
    scene.add_object("ball", hp.Sphere(0.1), mass=5.0, position=(0, 0, 0.29))
    session = Session(scene, start=[hp.Pose((0, 3, 0), np.zeros((55, 3)))], fps=30)
    for _ in range(5):
        frame = session.step()
    bed = scene_items(scene)[0][0]
    assert bed.soft == scene.statics["bed"].soft.document
    for nobody in (Subscription(), Subscription.of(schema.Subscribe())):
        assert frame_message(frame, nobody).pressures is UNSET
    asked = Subscription.of(schema.Subscribe(["pressures"]))
    data = schema.encode(frame_message(frame, asked), True)
    (got,) = schema.from_server(data).pressures
    rows = frame.simulated.soft_contacts
    assert (got.layer, got.other) == ("bed", "ball")
    np.testing.assert_allclose(got.pressure, rows.pressure, atol=0.051)
    np.testing.assert_allclose(got.position, rows.position, atol=5.1e-6)
    np.testing.assert_allclose(got.depth, rows.depth, atol=5.1e-7)
    assert len(data) < 100 * len(rows) + 500


def test_shapes():
    assert shape_document(hp.Plane()) == {"kind": "plane"}
    assert shape_document(hp.Capsule(0.1, 0.5)) == {"kind": "capsule", "radius": 0.1, "length": 0.5}
    assert shape_document(hp.Cylinder(0.1, 0.5))["kind"] == "cylinder"
    cube = hp.Mesh(*hp.Box((1, 2, 3)).triangles()[:2])
    assert len(shape_document(cube)["faces"]) == 12
    faces = np.tile(cube.faces, (MOST_FACES // 12 + 1, 1))
    large = shape_document(hp.Mesh(cube.vertices, faces))
    assert large == {"kind": "bounds", "low": [-0.5, -1.0, -1.5], "high": [0.5, 1.0, 1.5]}

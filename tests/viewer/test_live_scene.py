"""What a session describes, as things to draw."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.live.scene_items import person_item, scene_items
from halfphysics.live.schema import (
    Contact,
    Pressed,
    SceneItem,
    SceneMessage,
    encode,
    from_server,
)
from halfphysics.viewer.contacts import NO_PERSON, OBJECT, PERSON, SCENE
from halfphysics.viewer.live_scene import LivePerson, LiveTouches, pressures_of, scene_of

#: Positions of a described shape agree with the described ones to rounding [m].
EXACT = 1e-12


def every_shape():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(), position=(0, 0, -1))
    scene.add_static("wall", hp.Box((1, 2, 3)), position=(1, 2, 3), quaternion=(0.8, 0.6, 0, 0))
    scene.add_object("ball", hp.Sphere(0.2), mass=2.0, position=(0, 0, 1))
    scene.add_object("pill", hp.Capsule(0.1, 0.5), mass=1.0, position=(0, 1, 1))
    scene.add_object("can", hp.Cylinder(0.1, 0.3), mass=1.0, position=(0, 2, 1))
    return scene


def test_a_scene_comes_back_as_it_was_described():
    given = every_shape()
    found = scene_of(*scene_items(given))
    for mine, theirs in ((found.statics, given.statics), (found.objects, given.objects)):
        assert list(mine) == list(theirs)
        for name, item in mine.items():
            other = theirs[name]
            assert type(item.shape) is type(other.shape)
            np.testing.assert_allclose(item.position, other.position, atol=EXACT)
            np.testing.assert_allclose(item.quaternion, other.quaternion, atol=EXACT)
            np.testing.assert_allclose(item.mesh()[0], other.mesh()[0], atol=EXACT)


def test_a_soft_scene_is_soft_as_it_was_described():
    given = hp.Scene()
    given.add_static("bed", hp.Box((2, 1, 0.5)), soft="mattress")
    given.add_object("ball", hp.Sphere(0.1), mass=1.0, soft=hp.Soft(0.05, 2e4, law="linear"))
    statics, objects = (from_wire(items) for items in scene_items(given))
    found = scene_of(statics, objects)
    assert found.statics["bed"].soft == given.statics["bed"].soft
    soft = found.objects["ball"].soft
    assert (soft.thickness, soft.stiffness, soft.law) == (0.05, 2e4, "linear")


def from_wire(items):
    """Items of a scene as a client has them: through the bytes of a message."""
    message = SceneMessage(list(items), [])
    return from_server(encode(message, True)).statics


def pressed(**changed):
    numbers = {
        "position": [[0.0, 0.0, 0.1], [0.1, 0.0, 0.1]],
        "normal": [[0.0, 0.0, 1.0]] * 2,
        "depth": [0.01, 0.02],
        "pressure": [100.0, 200.0],
        "area": [1e-4, 2e-4],
    }
    return Pressed("bed", "ball", **(numbers | changed))


def test_pressures_of_a_frame_are_a_table():
    gone = Pressed("sofa", "ball", [[0.0] * 3], [[0.0] * 3], [1.0], [1.0], [1.0])
    table = pressures_of([gone, pressed()], ("bed", "ball", "person"))
    np.testing.assert_array_equal(table.layer, [0, 0])
    np.testing.assert_array_equal(table.other, [1, 1])
    np.testing.assert_array_equal(table.depth, [0.01, 0.02])
    np.testing.assert_allclose(table.force, [[0, 0, 0.01], [0, 0, 0.04]])
    assert len(pressures_of([gone], ("bed", "ball"))) == 0


@pytest.mark.parametrize(
    "changed", [{"normal": [[0.0, 1.0]]}, {"area": [1.0]}, {"depth": [-1.0, 0.0]}]
)
def test_pressures_that_do_not_fit_are_refused(changed):
    with pytest.raises(InputError, match=r"pressures|soft_contacts"):
        pressures_of([pressed(**changed)], ("bed", "ball"))


def item(**shape):
    return SceneItem("thing", shape, [1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], 1.0)


def test_meshes_and_bounds():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    mesh = scene_of([item(kind="mesh", vertices=vertices, faces=faces)], []).statics["thing"]
    np.testing.assert_allclose(sorted(mesh.mesh()[0].tolist()), sorted(map(list, vertices)))
    box = scene_of([item(kind="bounds", low=[0, 0, 0], high=[2, 4, 6])], []).statics["thing"]
    np.testing.assert_allclose(box.shape.size, [2, 4, 6])
    # Half a turn about z: the middle (1, 2, 3) is at (-1, -2, 3) from the item's place.
    np.testing.assert_allclose(box.position, [0, -2, 3], atol=EXACT)


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        ({"kind": "torus"}, "torus"),
        ({"kind": "sphere"}, "incomplete"),
        ({"kind": "sphere", "radius": -1}, "radius"),
        ({}, "None"),
    ],
)
def test_a_shape_that_is_none(shape, said):
    with pytest.raises(InputError, match=said):
        scene_of([item(**shape)], [])


def test_joints_are_where_the_session_has_them():
    """Of another body than the default one, too, and at any pose."""
    own = hp.Body.default(stature=1.62)
    person = LivePerson(person_item("ann", own))
    assert person.own_skin
    rng = np.random.default_rng(0)
    pose = hp.Pose(rng.normal(size=3), 0.5 * rng.normal(size=(55, 3)))
    places, turns = person.frames(pose)
    wanted = own.joint_frames(pose)
    np.testing.assert_allclose(places, wanted[0], atol=EXACT)
    np.testing.assert_allclose(turns, wanted[1], atol=EXACT)
    described = person_item("bea", own)
    described.joints = (1.1 * np.array(described.joints)).tolist()
    assert not LivePerson(described).own_skin


def test_a_person_of_too_few_joints():
    described = person_item("ann", hp.Body.default())
    described.joints = described.joints[:20]
    with pytest.raises(InputError, match="55"):
        LivePerson(described)


def contact(subject, other, part="left_hand"):
    part = "left_wrist" if subject in ("ann", "bea") else None
    return Contact(subject, part, other, None, [0, 0, 1], [0, 0, 1], [0, 0, 5])


def test_kinds_of_contacts():
    touches = LiveTouches(["floor"], ["ann", "bea"])
    pairs = [("ann", "floor"), ("ann", "ball"), ("ann", "bea"), ("ball", "floor")]
    touches.contacts = [contact(*pair) for pair in pairs]
    found = touches.at(0)
    assert found.kind.tolist() == [SCENE, OBJECT, PERSON, NO_PERSON]
    np.testing.assert_array_equal(found.force, [[0, 0, 5]] * 4)
    part, position, force = touches.of("ann")
    assert part.tolist() == [hp.JOINT_NAMES.index("left_wrist")] * 3
    assert position.shape == (3, 3)
    assert force.tolist() == [5, 5, 5]
    touches.contacts = ()
    assert touches.at(0).position.shape == (0, 3)
    assert touches.of("ann")[1].shape == (0, 3)

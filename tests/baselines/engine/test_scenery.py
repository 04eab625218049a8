"""A scene in MuJoCo: poses, contact pairs and their friction."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from halfphysics.baselines import EngineKinematic, EngineVelocity
from halfphysics.baselines.engine.scenery import add_scene
from halfphysics.body.body import Body
from halfphysics.body.mjcf_person import add_person
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.people import along_x


@pytest.fixture(scope="module")
def body():
    return Body.default()


def compiled(scene, *bodies):
    """The model and data of a scene, and the item of each geom; people are named a/, b/, ..."""
    spec = mujoco.MjSpec()
    people = [f"{chr(ord('a') + i)}/" for i in range(len(bodies))]
    for prefix, body in zip(people, bodies, strict=True):
        add_person(spec, body.variant, prefix, position=(0.0, 0.0, 0.0))
    owner = add_scene(spec, scene, people=people)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data, owner


def touching(model, data, owner):
    """(item or person's geom, the other) -> friction of their contacts."""
    found = {}
    for contact in data.contact:
        pair = sorted(owner.get(n, n) for n in (model.geom(g).name for g in contact.geom))
        found.setdefault(tuple(pair), set()).add(round(float(contact.friction[0]), 12))
    return found


def slab(scene, name, z, friction, static=False):
    """A box of 1 m a side that overlaps the box 1 m lower by a centimetre."""
    shape, place = Box((1.0, 1.0, 1.0)), (5.0, 0.0, 0.99 * z)
    if static:
        scene.add_static(name, shape, position=place, friction=friction)
    else:
        scene.add_object(name, shape, mass=1.0, position=place, friction=friction)


def test_a_pair_has_the_smaller_friction():
    scene = Scene()
    slab(scene, "low", 0, 0.9, static=True)
    slab(scene, "ice", 1, 0.1)
    slab(scene, "brick", 2, 0.6)
    slab(scene, "glue", 3, 3.0)
    slab(scene, "tar", 4, 2.0)
    expected = {
        ("ice", "low"): {0.1},
        ("brick", "ice"): {0.1},
        ("brick", "glue"): {0.6},
        # Both rougher than a person: an explicit pair.
        ("glue", "tar"): {2.0},
    }
    assert touching(*compiled(scene)) == expected
    for (a, b), mu in expected.items():
        assert mu == {scene.friction_of(a, b)}


def test_what_is_said_of_pairs_holds():
    scene = Scene()
    slab(scene, "low", 0, 0.9, static=True)
    slab(scene, "one", 1, 0.5)
    slab(scene, "two", 2, 0.5)
    slab(scene, "three", 3, 0.5)
    scene.friction("low", "one", 0.05)
    scene.friction("two", "three", 1.5)
    scene.ignore("one", "two")
    assert touching(*compiled(scene)) == {("low", "one"): {0.05}, ("three", "two"): {1.5}}


def test_what_is_said_of_people_and_parts_holds(body):
    scene = Scene()
    # The whole person is in it.
    scene.add_static("bath", Box((4.0, 4.0, 4.0)))
    scene.add_object("ball", Sphere(0.6), mass=1.0, position=(0.0, 0.0, 2.5))
    assert touching(*compiled(scene, body))[("a/pelvis", "bath")] == {1.0}
    scene.friction("person", "bath", 0.3)
    scene.friction("person/left_foot", "bath", 0.7)
    scene.ignore("person/right_foot", "bath")
    found = touching(*compiled(scene, body))
    assert found[("a/pelvis", "bath")] == {0.3}
    assert found[("a/left_foot", "bath")] == {0.7}
    assert ("a/right_foot", "bath") not in found
    assert found[("ball", "bath")] == {scene.friction_of("ball", "bath")} == {0.8}
    scene.ignore("person", "bath")
    assert set(touching(*compiled(scene, body))) == {("ball", "bath")}


def test_an_ignored_static_stays_where_it_is(body):
    scene = Scene()
    scene.add_static("wall", Plane((0.0, 0.6, 0.8), 0.05), position=(1.0, 0.1, -0.1))
    plain, before, _ = compiled(scene, body)
    scene.ignore("person", "wall")
    model, after, _ = compiled(scene, body)
    for data in (before, after):
        mujoco.mj_kinematics(plain if data is before else model, data)
    a, b = plain.geom("static/wall/0").id, model.geom("static/wall/0").id
    np.testing.assert_allclose(after.geom_xpos[b], before.geom_xpos[a], atol=1e-15)
    np.testing.assert_allclose(after.geom_xmat[b], before.geom_xmat[a], atol=1e-15)


def two_boxes():
    """An L of two boxes as one mesh: two convex solids, smaller than their hull."""
    vertices, faces = [], []
    for size, centre in (((1.0, 0.2, 0.2), (0.0, 0.0, 0.1)), ((0.2, 0.2, 1.0), (0.6, 0.0, 0.5))):
        v, f = Box(size).triangles()
        faces.append(f + 8 * len(vertices))
        vertices.append(v + np.array(centre))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def test_a_mesh_touches_as_its_convex_pieces(body):
    """A ball rests in the corner of an L; a hull would throw it out."""
    scene = Scene()
    scene.add_static("corner", two_boxes())
    scene.add_object("ball", Sphere(0.05), mass=1.0, position=(0.4, 0.0, 0.25))
    settings = EngineKinematic()
    with pytest.warns(HalfPhysicsWarning, match="'corner'.*convex pieces, 2 of them") as said:
        result = simulate(along_x(0.0, 31, start=-9.0), scene, body=body, settings=settings)
    assert said[0].filename == __file__
    np.testing.assert_allclose(result.objects["ball"].position[-1], [0.4, 0.0, 0.25], atol=1e-3)
    assert {result.names[i] for i in result.contacts.other} == {"corner"}


def test_a_convex_mesh_touches_as_it_is(body, recwarn):
    scene = Scene()
    scene.add_static("block", Mesh(*Box((1.0, 1.0, 1.0)).triangles()))
    scene.add_object("ball", Sphere(0.05), mass=1.0, position=(0.0, 0.0, 0.55))
    settings = EngineKinematic()
    result = simulate(along_x(0.0, 11, start=-9.0), scene, body=body, settings=settings)
    np.testing.assert_allclose(result.objects["ball"].position[-1], [0.0, 0.0, 0.55], atol=1e-3)
    assert not [w for w in recwarn if issubclass(w.category, HalfPhysicsWarning)]


def test_an_object_touches_as_its_pieces(body):
    """The L lies on the floor with a ball in its corner."""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("corner", two_boxes(), mass=5.0)
    scene.add_object("ball", Sphere(0.05), mass=0.1, position=(0.4, 0.0, 0.25))
    settings = EngineVelocity()
    result = simulate(along_x(0.0, 31, start=-9.0, z=2.0), scene, body=body, settings=settings)
    np.testing.assert_allclose(result.objects["ball"].position[-1], [0.4, 0.0, 0.25], atol=2e-3)
    np.testing.assert_allclose(result.objects["corner"].position[-1], 0.0, atol=2e-3)
    pairs = {
        (result.names[a], result.names[b])
        for a, b in zip(result.contacts.subject, result.contacts.other, strict=True)
    }
    assert pairs == {("corner", "floor"), ("corner", "ball")}


def test_without_anything_to_answer_nothing_is_cut(body, monkeypatch):
    from halfphysics.baselines.engine import scenery

    monkeypatch.setattr(scenery, "decompose", None)
    scene = Scene()
    scene.add_static("corner", two_boxes())
    scene.add_moving("lift", Box((0.1, 0.1, 0.1)), [[3.0, 0.0, 0.0], [4.0, 0.0, 0.0]], fps=1.0)
    settings = EngineKinematic()
    result = simulate(along_x(0.0, 31, start=-9.0), scene, body=body, settings=settings)
    np.testing.assert_allclose(result.objects["lift"].position[-1], [4.0, 0.0, 0.0], atol=1e-12)

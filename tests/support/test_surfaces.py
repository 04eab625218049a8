"""Which things of a scene can hold somebody up, and when."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.support.surfaces import surfaces_of
from support import standing


def names(scene, *more):
    return tuple(s.name for s in surfaces_of(scene, {}, *more, 5))


def test_statics_and_resting_objects():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("crate", hp.Box((1, 1, 1)), mass=20.0, position=(2.0, 0.0, 0.5))
    assert names(scene, (), None) == ("floor", "crate")
    scene.ignore("person", "crate")
    assert names(scene, (), None) == ("floor",)


def test_an_object_holds_where_it_rests_on_something_fixed():
    """A person stands on a crate on the floor; a ball in the air holds nobody."""
    body = hp.Body.default(mass=60.0)
    motion = standing.standing(body, frames=30)
    up = standing.raised(motion, 0.4)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("crate", hp.Box((1, 1, 0.398)), mass=40.0, position=(0.0, -0.4, 0.2))
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(3.0, 0.0, 2.0))
    result = hp.simulate(up, scene, body=body)
    found = {
        s.name: s for s in surfaces_of(scene, result.objects, result.names, result.contacts, 30)
    }
    assert set(found) == {"floor", "crate"}
    assert found["crate"].holds[15:].all()
    support = result.people[0].support
    on = support.names.index("crate")
    share = support.force[15:-5, on, 2] / support.weight
    assert np.abs(share - 1.0).max() < 0.02

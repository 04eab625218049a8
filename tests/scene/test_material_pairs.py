"""Friction and disabled contact of one part of a person."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.people import t_pose


def test_what_is_said_of_a_part_counts_first():
    scene = Scene()
    scene.add_static("floor", Plane(), friction=0.9)
    scene.friction("person", "floor", 0.5)
    scene.friction("person/left_foot", "floor", 0.1)
    scene.ignore("person/head", "floor")
    assert scene.friction_of("person/left_foot", "floor") == 0.1
    assert scene.friction_of("floor", "person/right_foot") == 0.5
    assert scene.friction_of("person/left_foot", "person/left_foot") == 1.0
    assert scene.ignores("person/head", "floor")
    assert not scene.ignores("person/jaw", "floor")
    with pytest.raises(InputError, match=r"did you mean 'person/left_foot'\? Parts are"):
        scene.friction("person/left_fot", "floor", 0.1)
    with pytest.raises(InputError, match=r"nothing called 'flor'; did you mean 'floor'\? It has"):
        scene.friction("flor", "person", 0.1)
    with pytest.raises(InputError, match=r"nothing called 'xyz'\. It has: floor, person"):
        scene.friction("xyz", "person", 0.1)
    with pytest.raises(InputError, match=r"the scene has nothing called array\("):
        scene.friction(np.zeros(2), "floor", 0.1)


def test_files(tmp_path):
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.friction("person/left_foot", "floor", 0.1)
    scene.ignore("person/head", "floor")
    scene.save(tmp_path / "s.yaml")
    back = Scene.load(tmp_path / "s.yaml")
    assert back.friction_pairs == scene.friction_pairs
    assert back.ignored_pairs == scene.ignored_pairs


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_the_core_hears_of_it(contact):
    """A plate moves down on a hand and along it: each pair's friction sets the drag."""
    body, motion = Body.default(), t_pose(np.zeros((20, 3)))
    hand = body.joints(motion)[0, 20]

    def dragged(part=None):
        scene = Scene()
        path = np.zeros((20, 3))
        path[:] = hand
        path[:, 2] += 0.25 - 0.2 * np.arange(20) / 19.0  # moves down on the hand
        path[:, 0] += 0.3 * np.arange(20) / 19.0
        scene.add_moving("plate", Box((0.6, 0.3, 0.1)), path, fps=30.0)
        scene.friction("person", "plate", 0.0)
        for name in part or []:
            scene.friction(f"person/{name}", "plate", 1.0)
        result = simulate(motion, scene, body=body, settings=Settings(contact=contact))
        touched = result.contacts
        along = touched.impulse - np.sum(
            touched.impulse * touched.normal, axis=1, keepdims=True
        ) * (touched.normal)
        return touched.part, np.linalg.norm(along, axis=1), np.linalg.norm(touched.impulse, axis=1)

    part, along, whole = dragged()
    assert len(part) > 0
    assert (along < 1e-6 * whole.max()).all()  # friction is off
    rough = [int(j) for j in np.unique(part)][:1]
    part, along, whole = dragged([JOINT_NAMES[j] for j in rough])
    mine = np.isin(part, rough)
    assert (along[mine] > 0.1 * whole[mine]).any()
    assert (along[~mine] < 1e-6 * whole.max()).all()


def test_one_part_passes_through():
    body, motion = Body.default(), t_pose(np.zeros((10, 3)))
    hand = body.joints(motion)[0, 20]
    scene = Scene(gravity=0.0)
    scene.add_object("ball", Sphere(0.05), mass=1, position=hand + np.array([0, 0, 0.3]))
    scene.add_moving("post", Box((0.1, 0.1, 0.1)), [hand + np.array([0.5, 0, 0]), hand], fps=4)
    assert len(simulate(motion, scene, body=body).contacts) > 0
    for name in JOINT_NAMES:
        scene.ignore(f"person/{name}", "post")
    assert len(simulate(motion, scene, body=body).contacts) == 0

"""A world from what is kept of its people equals one that nothing was kept for."""

from __future__ import annotations

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import scenarios
from support.results.bits import bits


def again(story, frames=40):
    motions = [motion[:frames] for motion in story.motions]
    return hp.simulate(motions, story.scene, body=list(story.bodies), settings=story.settings)


def unknown(body):
    """A body of the same content of which nothing is kept."""
    return dataclasses.replace(hp.Body.default() if body is None else body)


@pytest.mark.parametrize("name", ["walk_into_wall", "lift_suitcase", "open_drawer", "shake_hands"])
@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_equal_bits_the_second_time(name, contact):
    story = scenarios.load(name)
    settings = dataclasses.replace(story.settings, contact=contact)
    story = dataclasses.replace(story, settings=settings)
    fresh = dataclasses.replace(story, body=tuple(unknown(body) for body in story.bodies))
    assert bits(again(fresh)) == bits(again(story)) == bits(again(story)) == bits(again(fresh))


def test_a_scene_that_was_changed():
    def room(extra):
        scene = hp.Scene()
        scene.add_static("floor", hp.Plane())
        scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0.4, 0.0, 0.1))
        if extra:
            scene.add_static("wall", hp.Box((0.1, 2.0, 2.0)), position=(0.8, 0.0, 1.0))
            scene.friction("ball", "floor", 0.1)
        return scene

    walk = scenarios.load("walk_into_wall").motion[:40]
    scene = room(False)
    before = bits(hp.simulate(walk, scene))
    scene.add_static("wall", hp.Box((0.1, 2.0, 2.0)), position=(0.8, 0.0, 1.0))
    scene.friction("ball", "floor", 0.1)
    after = bits(hp.simulate(walk, scene))
    assert after == bits(hp.simulate(walk, room(True)))
    assert before == bits(hp.simulate(walk, room(False))) != after


def test_a_body_is_not_the_callers_arrays():
    default = hp.Body.default()
    rest = np.array(default.rest_vertices)
    body = dataclasses.replace(default, rest_vertices=rest)
    rest *= 2.0
    assert np.array_equal(body.rest_vertices, default.rest_vertices)


def test_nothing_of_the_core_outlives_the_interpreter():
    code = (
        "import numpy as np, halfphysics as hp\n"
        "still = hp.Motion(np.zeros((3, 3)), np.zeros((3, 55, 3)), 30.0)\n"
        "hp.simulate(still)"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "leaked" not in ran.stderr + ran.stdout


def test_a_world_is_of_the_scene_as_it_was():
    scene = hp.Scene()
    scene.add_object("ball", hp.Sphere(0.1), mass=3.0)
    simulator, alike = hp.Simulator(scene), hp.Simulator(scene)
    scene.add_object("other", hp.Sphere(0.1), mass=1.0)
    assert simulator.world.model.nbody == simulator.world.joined.nbody == 1 + 55 + 1
    assert simulator.world.signature == alike.world.signature
    assert simulator.world.signature != hp.Simulator(scene).world.signature

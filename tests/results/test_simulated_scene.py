"""The scene of a result, when its owner goes on building."""

from __future__ import annotations

import copy
import dataclasses

import numpy as np
import pytest

import halfphysics as hp


@pytest.fixture
def simulated():
    """A scene, and the result of five frames in it."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(2.0, 0.0, 0.1))
    translation = np.tile([0.0, 0.0, 2.0], (5, 1))
    return scene, hp.simulate(hp.Motion(translation, np.zeros((5, 55, 3)), 30.0), scene)


def test_while_nothing_changes_it_is_the_one_that_was_given(simulated):
    scene, result = simulated
    assert result.scene is scene


def add_static(scene):
    scene.add_static("late", hp.Box((1, 1, 1)), position=(0.0, 9.0, 0.0))


def add_object(scene):
    scene.add_object("late", hp.Sphere(0.1), mass=1.0, position=(0.0, 9.0, 0.1))


@pytest.mark.parametrize("change", [add_static, add_object])
def test_what_is_added_later_is_not_in_it(simulated, change, tmp_path):
    scene, result = simulated
    change(scene)
    assert "late" not in {**result.scene.statics, **result.scene.objects}
    assert len(result.parts()) == 5
    result.save(tmp_path / "out.npz")
    for other in (hp.Result.load(tmp_path / "out.npz"), copy.deepcopy(result)):
        assert "late" not in {**other.scene.statics, **other.scene.objects}
        assert len(other.parts()) == 5


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: scene.friction("floor", "ball", 0.1),
        lambda scene: scene.ignore("ball", "person"),
    ],
)
def test_pairs_are_those_of_the_simulation(simulated, change):
    scene, result = simulated
    change(scene)
    assert (result.scene.friction_pairs, result.scene.ignored_pairs) == ((), ())


def test_a_result_that_is_made_of_another_keeps_what_was_simulated(simulated):
    scene, result = simulated
    other = dataclasses.replace(result, lost_time=result.lost_time)
    assert other.scene is scene
    add_static(scene)
    assert "late" not in other.scene.statics
    assert other.parts() is not None


def test_what_is_added_to_a_result_s_scene_is_not_in_what_was_simulated(simulated, tmp_path):
    scene, result = simulated
    add_static(scene)
    result.scene.add_static("mine", hp.Box((1, 1, 1)), position=(0.0, 9.0, 0.0))
    result.save(tmp_path / "r.npz")
    assert set(hp.Result.load(tmp_path / "r.npz").scene.statics) == {"floor"}

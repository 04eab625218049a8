"""Sleeping objects: they are held until another body touches them."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator

STILL = 1e-12


def run(scene, frames):
    simulator = Simulator(scene, body=[])
    seen = [simulator.reset([])] + [simulator.step([]) for _ in range(frames)]
    return {n: np.array([f.objects[n][0] for f in seen]) for n in scene.objects}, simulator


def test_it_hangs_in_the_air_until_it_is_hit():
    """From the same substep on it moves as an awake object does."""

    def scene(start, gravity):
        made = Scene(gravity=gravity)
        made.add_object("lamp", Sphere(0.1), mass=1.0, position=(0, 0, 2), start=start)
        made.add_object(
            "ball", Sphere(0.1), mass=1.0, position=(-1, 0, 2), velocity=(3, 0, 0), restitution=1.0
        )
        return made

    asleep, _ = run(scene("asleep", 0.0), 30)
    awake, _ = run(scene("awake", 0.0), 30)
    np.testing.assert_array_equal(asleep["lamp"], awake["lamp"])
    np.testing.assert_array_equal(asleep["ball"], awake["ball"])
    assert asleep["lamp"][-1, 0] > 1.0

    falls = scene("asleep", 9.81)
    tracks, _ = run(falls, 5)
    assert np.abs(tracks["lamp"] - [0, 0, 2]).max() <= STILL


def test_it_stays_to_the_last_digit_and_for_good():
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("shelf", Box((1, 1, 0.1)), mass=5, position=(0, 0, 1.3), start="asleep")
    scene.add_object("vase", Box((0.1, 0.1, 0.4)), mass=1, position=(0, 0, 1.55), start="asleep")
    scene.add_object("far", Sphere(0.1), mass=1, position=(5, 0, 0.1), start="asleep")
    tracks, _ = run(scene, 60)
    for name, track in tracks.items():
        assert np.abs(track - scene.objects[name].position).max() <= STILL


def test_what_lies_on_it_wakes_too():
    """The shelf is hit from below; the objects on it do not stay in the air."""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("shelf", Box((1, 1, 0.1)), mass=5, position=(0, 0, 1.3), start="asleep")
    scene.add_object("vase", Box((0.1, 0.1, 0.4)), mass=1, position=(0, 0, 1.55), start="asleep")
    scene.add_object("far", Sphere(0.1), mass=1, position=(5, 0, 2.0), start="asleep")
    scene.add_object("ball", Sphere(0.05), mass=0.1, position=(0.4, 0, 1.0), velocity=(0, 0, 4))
    tracks, _ = run(scene, 90)
    assert tracks["shelf"][-1, 2] < 0.2
    assert tracks["vase"][-1, 2] < 0.6
    assert np.abs(tracks["far"] - [5, 0, 2]).max() <= STILL


@pytest.mark.parametrize("gap", [0.0, 5e-4, 0.01])
def test_resting_it_wakes_without_a_jump(gap):
    """It was held at its own distance from the floor; awake it falls by that and no more."""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object(
        "box", Box((0.3, 0.3, 0.3)), mass=2, position=(0, 0, 0.15 + gap), start="asleep"
    )
    scene.add_object(
        "ball",
        Sphere(0.05),
        mass=0.5,
        position=(-1, 0, 0.25),
        velocity=(6, 0, 0.5),
        restitution=0.5,
    )
    tracks, _ = run(scene, 60)
    z = tracks["box"][:, 2]
    assert tracks["box"][-1, 0] > 1e-3
    assert z[:3].min() == z[:3].max() == 0.15 + gap
    assert z.min() >= 0.15 - 1e-9  # rounding of distances
    assert z[-1] < 0.15 + max(min(gap, 1e-3), 0.0) + 2e-4


def test_a_moving_thing_and_a_person_wake_it():
    from support.people import along_x

    path = np.outer(np.arange(31) / 30.0, [1.0, 0.0, 0.0]) + np.array([0.0, 0.0, 1.0])
    scene = Scene(gravity=0.0)
    scene.add_moving("bat", Box((0.1, 1, 1)), path, fps=30.0)
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.5, 0, 1), start="asleep")
    tracks, _ = run(scene, 30)
    assert tracks["ball"][-1, 0] == pytest.approx(1.15 + 1e-3, abs=2e-4)

    body = Body.default()
    motion = along_x(1.5, 31, start=-1.0)
    hand = body.joints(motion)[0, 20]
    scene = Scene(gravity=0.0)
    scene.add_object(
        "ball", Sphere(0.1), mass=0.3, position=(0.0, hand[1], hand[2]), start="asleep"
    )
    simulator = Simulator(scene, body=body)
    frames = [simulator.reset(motion[0])] + [simulator.step(motion[t]) for t in range(1, 31)]
    x = np.array([f.objects["ball"][0][0] for f in frames])
    touched = np.array([len(f.contacts.part) > 0 for f in frames])
    first = int(np.argmax(touched))
    assert touched.any()
    assert np.abs(x[:first]).max() <= STILL
    assert x[-1] > 0.1


def test_the_state_knows_who_sleeps():
    def make():
        scene = Scene()
        scene.add_object("lamp", Sphere(0.1), mass=1.0, position=(0, 0, 2), start="asleep")
        scene.add_object("ball", Sphere(0.1), mass=1.0, position=(-0.5, 0, 2.1), velocity=(3, 0, 0))
        return Simulator(scene, body=[])

    a, b = make(), make()
    a.reset([])
    b.reset([])
    before = a.get_state()
    for _ in range(8):
        a.step([])
    later = a.get_state()
    lamp = [a.step([]).objects["lamp"] for _ in range(8)]
    assert lamp[-1][0][2] < 1.9
    b.set_state(later)
    for seen in lamp:
        np.testing.assert_array_equal(b.step([]).objects["lamp"][0], seen[0])
    b.set_state(before)  # asleep again
    assert np.abs(b.step([]).objects["lamp"][0] - [0, 0, 2]).max() <= STILL
    np.testing.assert_array_equal(a.reset([]).objects["lamp"][0], [0, 0, 2])
    assert np.abs(a.step([]).objects["lamp"][0] - [0, 0, 2]).max() <= STILL


def test_files_and_errors(tmp_path):
    scene = Scene()
    scene.add_object("lamp", Sphere(0.1), mass=1.0, start="asleep")
    scene.save(tmp_path / "s.yaml")
    assert Scene.load(tmp_path / "s.yaml").objects["lamp"].start == "asleep"
    with pytest.raises(InputError, match="start: expected"):
        scene.add_object("a", Sphere(0.1), mass=1.0, start="tired")
    with pytest.raises(InputError, match="does not move"):
        scene.add_object("a", Sphere(0.1), mass=1.0, start="asleep", velocity=(1, 0, 0))

"""Rows of the core in terms of names, parts and vertices."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

import halfphysics as hp
from halfphysics.body.skin_samples import skin_samples
from halfphysics.simulation.soft_rows import COLUMNS, EDGEWISE, rows_of, soft_rows


def world(contact="skin", soft=True):
    """Statics floor and bed, object ball, one person with two shapes."""
    body = hp.Body.default()
    return SimpleNamespace(
        soft=soft,
        names=("floor", "bed", "ball", "person"),
        people=(None,),
        bodies=(body,),
        settings=hp.Settings(contact=contact),
        static_name=np.array([0, 1]),
        shape_name=np.array([3, 3, 2]),
        shape_part=np.array([0, 7, -1]),
    )


def row(static, under, shape, sample, area=1e-4, pressure=1e3):
    place, normal = (1.0, 2.0, 3.0), (0.0, 0.0, 1.0)
    return [static, under, shape, sample, *place, *normal, 0.01, pressure, area]


def test_people_press_with_vertices_and_things_with_points():
    rows = np.array([row(1, -1, 0, 40), row(-1, 2, 1, 41), row(0, -1, 2, 5)])
    found = soft_rows(world(), rows, np.array([0, 0, 1]))
    samples = skin_samples(hp.Body.default())
    assert found.layer.tolist() == [1, 2, 0]  # the bed, the ball, the floor
    assert found.other.tolist() == [3, 3, 2]
    assert found.vertex.tolist() == [*samples.vertex[[40, 41]], -1]
    assert found.part.tolist() == [*samples.part[[40, 41]], -1]
    assert found.position[0].tolist() == [1.0, 2.0, 3.0]
    assert found.frame.tolist() == [0, 0, 1]


def test_rigid_parts_have_no_vertices():
    found = soft_rows(world("parts"), np.array([row(1, -1, 1, 40)]), np.zeros(1, dtype=int))
    assert (found.part.tolist(), found.vertex.tolist()) == ([7], [-1])


def test_samples_that_are_seen_edgewise_are_left_out():
    rows = np.array([row(1, -1, 2, 0), row(1, -1, 2, 1, area=EDGEWISE)])
    assert len(soft_rows(world(), rows, np.zeros(2, dtype=int))) == 1


def test_numbers_fit_into_half_the_size_without_loss():
    found = soft_rows(
        world(), np.array([row(1, -1, 2, 0, pressure=1e3 / 3)]), np.zeros(1, dtype=int)
    )
    assert found.pressure[0] == np.float64(np.float32(1e3 / 3))
    assert found.depth[0] == np.float64(np.float32(0.01))


def test_nothing_soft_is_none_and_nothing_pressed_is_no_row():
    empty = np.zeros((0, COLUMNS)), np.zeros(0, dtype=int)
    assert soft_rows(world(soft=False), *empty) is None
    assert len(soft_rows(world(), *empty)) == 0


def test_what_the_core_says_of_a_frame_are_the_rows_of_a_run():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(), soft="mat")
    scene.add_object("box", hp.Box((0.2, 0.2, 0.2)), mass=5.0, position=(0, 0, 0.09))
    simulator = hp.Simulator(scene, body=[])
    simulator.reset([])
    stepper = simulator.world.stepper
    got = stepper.run(np.zeros((1, 0)), 1 / 30, 8, False, 1.0, np.zeros((0, 0)), np.zeros((1, 7)))
    assert got["soft_count"].tolist() == [len(got["soft"])]
    assert len(got["soft"]) > 50
    assert np.array_equal(rows_of(stepper), got["soft"])

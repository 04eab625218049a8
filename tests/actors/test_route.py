"""Ways around what stands on the floor."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors.floor_plan import FloorPlan, surface_points
from halfphysics.actors.path import Path, Point
from halfphysics.actors.route import NARROW, route
from halfphysics.actors.seen import Seen

NOBODY = np.zeros((0, 2))


def room(*boxes):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    for i, (size, at) in enumerate(boxes):
        scene.add_static(f"box{i}", hp.Box(size), position=at)
    return scene


def room_along(plan, path, moving=NOBODY):
    places = np.array([path.at(d) for d in np.arange(0.0, path.length, 0.02)])
    return float(plan.clearance(places, moving).min())


def test_straight_where_nothing_is_in_the_way():
    plan = FloorPlan(room(((1, 1, 1), (2.0, 3.0, 0.5))))
    assert route(plan, Point(0.0, 0.0), Point(4.0, 0.0), NOBODY).points == [(0, 0), (4, 0)]
    assert route(FloorPlan(None), Point(0.0, 0.0), Point(4.0, 0.0), NOBODY).length == 4.0


def test_around_a_wall_with_room():
    plan = FloorPlan(room(((0.2, 4.0, 2.4), (2.0, 0.0, 1.2))))
    path = route(plan, Point(0.0, 0.0), Point(4.0, 0.0), NOBODY)
    assert room_along(plan, path) > NARROW
    shortest = 2.0 * np.hypot(2.0, 2.0)
    assert shortest < path.length < 1.25 * shortest


def test_low_and_high_things_are_no_obstacles():
    carpet, lamp = ((2, 2, 0.02), (2.0, 0.0, 0.01)), ((1, 1, 0.2), (2.0, 0.0, 2.3))
    plan = FloorPlan(room(carpet, lamp))
    assert len(route(plan, Point(0.0, 0.0), Point(4.0, 0.0), NOBODY).points) == 2


def test_no_way_out_of_a_closed_room():
    walls = [((6, 0.1, 2), (0, y, 1.0)) for y in (-3, 3)]
    walls += [((0.1, 6, 2), (x, 0, 1.0)) for x in (-3, 3)]
    plan = FloorPlan(room(*walls))
    assert route(plan, Point(0.0, 0.0), Point(5.0, 0.0), NOBODY) is None


def test_a_door_of_80_cm_is_wide_enough():
    plan = FloorPlan(room(((0.1, 3.0, 2), (1.5, 1.9, 1.0)), ((0.1, 3.0, 2), (1.5, -1.9, 1.0))))
    path = route(plan, Point(0.0, 1.0), Point(3.0, 1.0), NOBODY)
    assert path is not None
    assert path.length < 4.5, "through the door"
    assert room_along(plan, path) > NARROW


def test_objects_count_where_they_are_seen():
    scene = room()
    scene.add_object("crate", hp.Box((0.5, 0.5, 0.5)), mass=5.0, position=(2.0, 0.0, 0.25))
    plan = FloorPlan(scene)
    there = Seen(objects={"crate": (np.array([2.0, 0.0, 0.25]), np.array([1.0, 0, 0, 0]))})
    gone = Seen(objects={"crate": (np.array([2.0, 5.0, 0.25]), np.array([1.0, 0, 0, 0]))})
    ways = [
        route(plan, Point(0.0, 0.0), Point(4.0, 0.0), plan.moving(seen)) for seen in (there, gone)
    ]
    assert ways[0].length > 4.05
    assert ways[1].length == 4.0


def test_an_end_that_is_far_away_is_walked_to():
    """A grid of all the way there would take the machine's memory."""
    plan = FloorPlan(room(((0.3, 6.0, 3.0), (1.5, 0.0, 1.5))))
    way = route(plan, Point(0.0, 0.0), Point(5000.0, 0.0), NOBODY)
    assert way.end == (5000.0, 0.0)
    assert 5000.0 < way.length < 5010.0
    assert room_along(plan, Path(way.points[:-1])) >= NARROW


def test_what_is_below_and_above_people_has_no_points(monkeypatch):
    """A floor of a hundred metres took gigabytes."""
    counts = []

    def counted(vertices, faces):
        counts.append(len(faces))
        return surface_points(vertices, faces)

    monkeypatch.setattr("halfphysics.actors.floor_plan.surface_points", counted)
    FloorPlan(room(((100.0, 100.0, 0.1), (0, 0, -0.05)), ((100.0, 100.0, 0.1), (0, 0, 2.5))))
    assert counts == [0, 0]


def test_points_on_surfaces_leave_no_gap():
    points = surface_points(*hp.Box((2.0, 1.0, 0.5)).triangles())
    corner = np.array([1.0, 0.5, 0.25])
    assert (np.abs(points) <= corner + 1e-12).all()
    face = points[np.isclose(points[:, 0], 1.0)][:, 1:]
    grid = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 20), np.linspace(-0.25, 0.25, 10)), -1)
    gaps = np.linalg.norm(grid.reshape(-1, 1, 2) - face[None], axis=2).min(axis=1)
    assert gaps.max() == pytest.approx(0.0, abs=0.05)

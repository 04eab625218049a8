"""Ways around what stands on the floor."""

from __future__ import annotations

import math

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors.floor_plan import SPACING, FloorPlan, surface_points
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


@pytest.mark.parametrize("size", [(2.0, 6.0, 2.0), (2.0, 6.0, 1.0)])
def test_a_far_end_is_walked_to_although_the_point_at_50_m_is_inside_something(size):
    """It was given up: no way led to that point."""
    plan = FloorPlan(room((size, (50.0, 0.0, 0.5 * size[2]))))
    way = route(plan, Point(0.0, 0.0), Point(70.0, 0.0), NOBODY)
    assert way.end == (70.0, 0.0)
    # To within a metre of the box, or beside it.
    assert 47.0 < way.foreseen < 55.0
    foreseen = Path([way.at(d) for d in np.linspace(0.0, way.foreseen, 200)])
    assert room_along(plan, foreseen) >= NARROW


def test_what_is_near_is_foreseen_to_the_end():
    path = route(FloorPlan(room()), Point(0.0, 0.0), Point(4.0, 0.0), NOBODY)
    assert path.foreseen == path.length == 4.0


def test_what_it_holds_itself_is_not_in_its_way():
    """It walked around the thing in its own hand."""
    scene = room()
    scene.add_object("crate", hp.Box((0.5, 0.5, 0.5)), mass=5.0, position=(2.0, 0.0, 0.25))
    plan = FloorPlan(scene)
    there = {"crate": (np.array([0.4, 0.0, 1.0]), np.array([1.0, 0, 0, 0]))}
    ways = [
        route(plan, Point(0, 0), Point(4, 0), plan.moving(Seen(objects=there, held=held)))
        for held in (frozenset({"crate"}), frozenset())
    ]
    assert ways[0].length == 4.0
    assert ways[1].length > 4.0


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.785])
def test_a_gap_of_75_cm_is_found_wherever_it_is(angle):
    """As the document says; the grid has cells of 10 cm."""
    across = np.array([-math.sin(angle), math.cos(angle)])
    along = np.array([math.cos(angle), math.sin(angle)])
    turn = (math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle))
    for aside in np.arange(0.0, 0.1, 0.02):
        scene, gap = hp.Scene(), np.array([2.0, aside])
        for name, side in (("left", 1.0), ("right", -1.0)):
            at = (*(gap + side * (0.5 * 0.75 + 5.0) * across), 0.1)
            scene.add_static(name, hp.Box((0.1, 10.0, 0.1)), position=at, quaternion=turn)
        ends = (Point(*(gap - 2.0 * along)), Point(*(gap + 2.0 * along + 0.5 * across)))
        way = route(FloorPlan(scene), *ends, NOBODY)
        assert way is not None
        assert way.length < 4.5, "through the gap"


def test_long_walls_have_few_points():
    """A wall of 100 m had 11 million, 270 MB for each person."""
    length, height, thick = 100.0, 2.5, 0.2
    points = surface_points(*hp.Box((length, thick, height)).triangles())
    area = 2.0 * (length * height + length * thick + height * thick)
    # One a square of `SPACING`, and as much again for edges that are no multiple of it.
    assert len(points) < 2.0 * area / SPACING**2

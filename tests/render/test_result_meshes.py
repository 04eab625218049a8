"""The meshes drawn of a result, and their places."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.render.look import LIGHT
from halfphysics.render.result_meshes import Drawing
from support.results.small_result import FRAMES, small_result


@pytest.fixture(scope="module")
def drawing() -> Drawing:
    return Drawing(small_result())


def test_everything_is_there_under_its_name(drawing):
    names = list(drawing.surfaces(0))
    assert names == [
        "static/floor",
        "static/wall",
        "static/bench",
        "object/ball",
        "person/0",
        "ghost/0",
    ]
    assert "ghost/0" not in drawing.surfaces(0, ghost=False)
    assert len(drawing) == FRAMES


def test_people_are_the_skinned_bodies(drawing):
    person = drawing.result.people[0]
    for frame in (0, 9):
        surfaces = drawing.surfaces(frame)
        for kind, motion in (("person", person.motion), ("ghost", person.reference)):
            expected = person.body.vertices(motion, frames=[frame])[0]
            np.testing.assert_array_equal(surfaces[f"{kind}/0"].vertices, expected)
    assert surfaces["ghost/0"].alpha < 1 == surfaces["person/0"].alpha
    assert not surfaces["ghost/0"].casts
    assert surfaces["person/0"].color != surfaces["ghost/0"].color


def test_things_stand_where_they_are(drawing):
    ball = drawing.surfaces(12)["object/ball"].vertices
    centre = drawing.result.objects["ball"].position[12]
    np.testing.assert_allclose(np.linalg.norm(ball - centre, axis=1), 0.11, atol=1e-12)
    wall = drawing.surfaces(0)["static/wall"].vertices
    np.testing.assert_allclose(wall.min(axis=0), [0.85, -1.75, 0.0], atol=1e-12)
    np.testing.assert_allclose(wall.max(axis=0), [0.95, -0.25, 2.2], atol=1e-12)


def test_a_floor_is_chequered_level_and_larger_than_the_story(drawing):
    floor = drawing.surfaces(0)["static/floor"]
    np.testing.assert_array_equal(floor.vertices[:, 2], 0.0)
    assert floor.color == LIGHT.ground
    people = drawing.surfaces(0)["person/0"].vertices
    assert (floor.vertices.min(axis=0)[:2] < people.min(axis=0)[:2] - 5).all()
    assert (floor.vertices.max(axis=0)[:2] > people.max(axis=0)[:2] + 5).all()


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, -1, 0), (0.6, 0, 0.8), (0, 0, -1)])
def test_planes_of_any_direction_lie_in_themselves(normal):
    from types import SimpleNamespace

    from halfphysics.geometry.shapes import Plane
    from halfphysics.scene.scene import Scene

    turn = rot.exp(np.array([0.1, -0.2, 0.3]))
    scene = Scene()
    scene.add_static("plane", Plane(normal=normal, offset=0.4), position=(1, 2, 3), quaternion=turn)
    result = SimpleNamespace(**{**vars(small_result()), "scene": scene})
    surface = Drawing(result).surfaces(0)["static/plane"]
    local = rot.rotate(rot.conjugate(turn), surface.vertices - np.array([1, 2, 3]))
    np.testing.assert_allclose(local @ np.array(normal), 0.4, atol=1e-9)
    a, b, c = surface.vertices[surface.faces[0]]
    facing = np.cross(b - a, c - a)
    assert facing @ rot.rotate(turn, np.array(normal, dtype=float)) > 0


def test_what_hides_can_be_glass(drawing):
    clear = drawing.surfaces(0, faint={"static/wall"})
    assert clear["static/wall"].alpha < 0.5
    assert not clear["static/wall"].casts
    assert clear["static/bench"].alpha == 1.0


def test_frames_that_are_not_there_are_refused(drawing):
    assert drawing.check_frame(-1) == FRAMES - 1
    for frame in (FRAMES, -FRAMES - 1):
        with pytest.raises(InputError, match=f"0 to {FRAMES - 1}"):
            drawing.check_frame(frame)
    for frame in (1.5, True, "2"):
        with pytest.raises(InputError, match="whole number"):
            drawing.check_frame(frame)

"""Cameras with a clear view of the action."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.geometry.shapes import Box
from halfphysics.render import viewpoint
from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.viewpoint import (
    FOV,
    cameras,
    choose_direction,
    glass,
    look_at,
    spread,
    subject,
)
from halfphysics.scene.scene import Scene
from support.results.small_result import small_result

SIZE = (96, 96)


def walled(*walls: tuple[tuple[float, float, float], tuple[float, float, float]]) -> Drawing:
    """The small result with boxes (size, position) instead of its statics."""
    scene = Scene()
    for k, (size, position) in enumerate(walls):
        scene.add_static(f"wall{k}", Box(size), position=position)
    return Drawing(SimpleNamespace(**{**vars(small_result()), "scene": scene}))


def framed(drawing: Drawing, direction: np.ndarray) -> Camera:
    points = subject(drawing, 0, drawing.story(0))
    return Camera.framing(points, direction, size=SIZE, fov=FOV)


def test_what_hides_is_counted():
    # A wall before the lower half of the world hides the legs from the front.
    drawing = walled(((8, 0.1, 1.6), (0, -1.2, 0.0)))
    sight = look_at(drawing.surfaces(0), framed(drawing, (0, -1, 0)), SIZE)
    assert list(sight.hiding) == ["static/wall0"]
    assert 0.2 < sight.hiding["static/wall0"] < 0.8
    assert sight.share == pytest.approx(1 - sight.hiding["static/wall0"])
    behind = look_at(drawing.surfaces(0), framed(drawing, (0, 1, 0)), SIZE)
    assert behind.share == 1.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_direction_is_not_through_a_wall(side):
    drawing = walled(((8, 0.1, 2.6), (0, side, 1.3)))
    through = look_at(drawing.surfaces(5), framed(drawing, (0, side, 0.2)), SIZE)
    assert through.share < 0.1
    direction = choose_direction(drawing, [0, 5, 15], SIZE)
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    assert 0.1 < direction[2] < 0.6  # from a little above
    shares = []
    for frame in (0, 5, 15):
        points = subject(drawing, frame, drawing.story(frame))
        camera = Camera.framing(points, direction, size=SIZE, fov=FOV)
        shares.append(look_at(drawing.surfaces(frame), camera, SIZE).share)
    assert np.mean(shares) > 0.8


WALL, ASIDE = (8, 0.1, 2.6), (0.1, 8, 2.6)


@pytest.mark.parametrize(
    "walls",
    [
        (),
        ((WALL, (0, -1.5, 1.3)),),
        (((8, 0.1, 1.0), (0, -1.2, 0.5)), (ASIDE, (2.0, 0, 1.3))),
        ((WALL, (0, -1.2, 1.3)), (WALL, (0, 1.2, 1.3)), (ASIDE, (2.5, 0, 1.3))),
    ],
)
def test_the_best_of_all_directions_is_found_with_few_pictures(walls, monkeypatch):
    drawing, frames = walled(*walls), [0, 15]
    ways, apart = viewpoint.facing(drawing, frames), viewpoint._apart(drawing, frames)
    every = []
    for elevation in viewpoint._ELEVATIONS:
        for azimuth in range(viewpoint._AZIMUTHS):
            towards, rest = viewpoint._candidate(elevation, azimuth, ways, apart)
            shares = []
            for frame in frames:
                points = subject(drawing, frame, drawing.story(frame))
                camera = Camera.framing(points, towards, size=(96, 96), fov=FOV)
                shares.append(look_at(drawing.surfaces(frame), camera, (96, 96)).share)
            open_ = min(float(np.mean(shares)), viewpoint._ENOUGH)
            every.append((viewpoint._OPEN * open_ + rest, towards))
    looks = []
    monkeypatch.setattr(viewpoint, "look_at", lambda *a: looks.append(a) or look_at(*a))
    chosen = choose_direction(drawing, frames, SIZE)
    best = max(score for score, _ in every)
    first = next(towards for score, towards in every if score > best - 1e-9)
    np.testing.assert_allclose(chosen, first / np.linalg.norm(first), atol=1e-12)
    if not walls:
        # Two frames from four directions that are alike: half left and right, at two heights.
        assert len(looks) <= 8


def test_the_person_is_seen_from_the_front():
    direction = choose_direction(walled(), [0, 15], SIZE)
    assert direction[0] > 0.2  # walks along +x


def test_glass_goes_through_one_wall_after_the_other():
    drawing = walled(((8, 0.1, 2.6), (0, -1, 1.3)), ((8, 0.1, 2.6), (0, -2, 1.3)))
    camera = framed(drawing, (0, -1, 0.1))
    assert glass(drawing.surfaces(0), camera, SIZE) == {"static/wall0", "static/wall1"}
    assert glass(drawing.surfaces(0), framed(drawing, (0, 1, 0.1)), SIZE) == set()


def test_every_camera_has_its_story_in_the_picture():
    drawing = Drawing(small_result())
    frames = [0, 7, 15]
    for frame, camera in zip(
        frames, cameras(drawing, frames, np.array([0.6, -0.7, 0.3]), SIZE), strict=True
    ):
        points = subject(drawing, frame, drawing.story(frame)) - camera.position
        right, down, forward = camera.axes()
        reach = np.tan(np.radians(FOV) / 2) * (points @ forward)
        assert (np.abs(points @ right) < reach).all()
        assert (np.abs(points @ down) < reach).all()


def test_far_objects_do_not_pull_the_camera_back():
    result = small_result()
    position = result.objects["ball"].position + np.array([30.0, 0, 0])
    ball = SimpleNamespace(position=position, quaternion=result.objects["ball"].quaternion)
    drawing = Drawing(SimpleNamespace(**{**vars(result), "objects": {"ball": ball}}))
    assert subject(drawing, 0, drawing.story(0))[:, 0].max() < 5


def test_spread():
    assert spread(10, 3) == [0, 4, 9]  # 4.5 rounds to even
    assert spread(2, 5) == [0, 1]
    assert spread(1, 4) == [0]


@pytest.mark.parametrize("size", [(16, 8192), (32, 1600), (8192, 16)])
def test_pictures_of_any_ratio_have_a_view(size):
    """Views are compared in small pictures, which the ratio does not make large."""
    drawing = walled(((8, 0.1, 1.6), (0, -1.2, 0.0)))
    assert np.linalg.norm(choose_direction(drawing, [0], size)) == pytest.approx(1.0)
    points = subject(drawing, 0, drawing.story(0))
    camera = Camera.framing(points, (0, -1, 0), size=size, fov=FOV)
    assert glass(drawing.surfaces(0), camera, size) <= {"static/wall0"}

"""Pressure maps as files: what a picture shows, films of every kind, arrays, mistakes."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from halfphysics.errors import InputError
from halfphysics.render.pressure_colors import shades
from halfphysics.render.pressure_pictures import picture, save_pressure
from halfphysics.results.pressure_maps import pressure_map
from support.results.soft_results import FRAMES, soft_result


@pytest.fixture(scope="module")
def made():
    return pressure_map(soft_result(), cell=0.02)


def near(pixels, color):
    return (np.abs(pixels.astype(int) - color).max(axis=-1) <= 12).any()


def test_the_picture_has_the_colour_of_its_peak_and_of_nothing(made):
    frame = 1 + FRAMES // 4
    pixels = picture(made, frame)
    peak = float(made.pressure[frame].max())
    assert near(pixels[60:-60, 70:-120], np.rint(255 * shades(peak / 3000.0)))
    assert near(pixels[60:-60, 70:-120], np.rint(255 * shades(0.0)))
    assert not np.array_equal(pixels, picture(made, 0))
    # Negative frames count from the end; a scale of the user's own changes the colours.
    np.testing.assert_array_equal(picture(made, -1), picture(made, FRAMES - 1))
    assert not np.array_equal(picture(made, frame, 20_000.0), pixels)


def test_the_ball_is_up_and_right_where_y_and_x_are_large(made):
    pixels = picture(made, 1 + FRAMES // 4).astype(int)
    dark = (pixels[60:-60, 70:-120].sum(axis=2) < 420).nonzero()
    height, width = pixels[60:-60, 70:-120].shape[:2]
    assert np.median(dark[0]) < 0.35 * height
    assert np.median(dark[1]) > 0.7 * width


@pytest.mark.parametrize("suffix", [".png", ".gif"])
def test_files_are_whole_and_have_the_same_bytes(made, tmp_path, suffix):
    paths = [save_pressure(made, tmp_path / f"{k}{suffix}") for k in (0, 1)]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with Image.open(io.BytesIO(paths[0].read_bytes())) as image:
        frames = getattr(image, "n_frames", 1)
    # 30 frames a second: every second of a GIF's.
    assert frames == (FRAMES // 2 if suffix == ".gif" else 1)


def test_a_film_has_every_frame(made, tmp_path):
    imageio = pytest.importorskip("imageio_ffmpeg")
    path = save_pressure(made, tmp_path / "map.mp4")
    frames, _ = imageio.count_frames_and_secs(str(path))
    assert frames == FRAMES


def test_the_arrays_are_those_of_the_map(made, tmp_path):
    save_pressure(made, tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz") as kept:
        np.testing.assert_array_equal(kept["pressure"], made.pressure)
        assert float(kept["cell"]) == 0.02
        assert str(kept["name"]) == "bed"
        np.testing.assert_array_equal(kept["corner"], made.corner)


def test_mistakes_are_named_and_nothing_is_written(made, tmp_path):
    with pytest.raises(InputError, match=r"found 'map.jpg', expected a name in .png"):
        save_pressure(made, tmp_path / "map.jpg")
    with pytest.raises(InputError, match="frame: found 99, but the map has 16 frames"):
        save_pressure(made, tmp_path / "map.png", frame=99)
    with pytest.raises(InputError, match=r"a frame is for a \.png"):
        save_pressure(made, tmp_path / "map.gif", frame=3)
    with pytest.raises(InputError, match="most: "):
        save_pressure(made, tmp_path / "map.png", most=0.0)
    assert list(tmp_path.iterdir()) == []

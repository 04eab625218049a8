"""Files of pressures: which names there are, and which frames a film has."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from halfphysics.errors import InputError
from halfphysics.render.pressure_files import DrawnPressures, pressure_path


def shades(frames=60, fps=60.0):
    """Pictures with a white column each, and the frames that were drawn."""
    drawn = []

    def moment(frame):
        drawn.append(frame)
        picture = np.zeros((16, 20, 3), dtype=np.uint8)
        picture[:, frame % 20] = 255
        return picture

    made = DrawnPressures(
        arrays=lambda: {"pressure": np.arange(3.0)},
        still=lambda: moment(7),
        moment=moment,
        size=(20, 16),
        frames=frames,
        fps=fps,
    )
    return made, drawn


@pytest.mark.parametrize(
    ("name", "frame", "said"),
    [("map.jpg", None, "expected a name in"), ("map.gif", 3, "a frame is for a .png")],
)
def test_names_that_are_refused(name, frame, said):
    with pytest.raises(InputError, match=said):
        pressure_path(name, frame)


def test_arrays_and_pictures_draw_what_they_need(tmp_path):
    made, drawn = shades()
    made.save(pressure_path(tmp_path / "map.npz", None))
    assert drawn == []
    assert list(np.load(tmp_path / "map.npz")["pressure"]) == [0.0, 1.0, 2.0]
    made.save(pressure_path(tmp_path / "map.PNG", 7))
    assert drawn == [7]
    assert np.flatnonzero(np.asarray(Image.open(tmp_path / "map.PNG"))[0, :, 0]) == [7]


def test_a_gif_has_at_most_twenty_frames_a_second(tmp_path):
    made, _ = shades()
    made.save(pressure_path(tmp_path / "map.gif", None))
    with Image.open(tmp_path / "map.gif") as film:
        assert film.n_frames == 20
        assert film.info["duration"] == 50

"""Pressure on skins as files: the back of who lies is coloured, the front is not."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from halfphysics.errors import InputError
from halfphysics.render.skin_pictures import save_skin_pressure
from halfphysics.results.skin_pressure import skin_pressure
from support.results.soft_results import soft_result


def test_the_back_is_coloured_and_the_front_is_not(tmp_path):
    pixels = np.asarray(Image.open(save_skin_pressure(soft_result(), tmp_path / "skin.png")))
    views = pixels[60:, :760].astype(int)
    warm = views[..., 0] - views[..., 2] > 60
    assert warm[:, 380:].sum() > 300
    assert warm[:, :380].sum() == 0


def test_the_arrays_are_the_pressures(tmp_path):
    result = soft_result()
    save_skin_pressure(result, tmp_path / "skin.npz")
    with np.load(tmp_path / "skin.npz") as kept:
        np.testing.assert_array_equal(kept["pressure"], skin_pressure(result))
        assert kept["area"].shape == (kept["pressure"].shape[1],)


def test_mistakes_are_named_and_nothing_is_written(tmp_path):
    result = soft_result()
    with pytest.raises(InputError, match=r"expected a name in \.png"):
        save_skin_pressure(result, tmp_path / "skin.svg")
    with pytest.raises(InputError, match="frame: found 16, but the result has 16 frames"):
        save_skin_pressure(result, tmp_path / "skin.png", frame=16)
    with pytest.raises(InputError, match="person: found 3"):
        save_skin_pressure(result, tmp_path / "skin.png", person=3)
    assert list(tmp_path.iterdir()) == []

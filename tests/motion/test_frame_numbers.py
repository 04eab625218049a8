"""Frames of a motion are whole numbers and slices of them."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from support.files.layouts import movement


@pytest.mark.parametrize("wrong", [1.5, "3", None, [0, 1], np.arange(3), True, np.True_])
def test_frames_are_whole_numbers(wrong):
    with pytest.raises(InputError, match=r"motion\[...\]: found .* t \* fps"):
        Motion(*movement(20), 30.0)[wrong]


@pytest.mark.parametrize(
    "wrong", [slice(0.5, 2.0), slice("a", None), slice(0, 5, 0), slice(False, 5)]
)
def test_slices_are_of_whole_frames(wrong):
    with pytest.raises(InputError, match=r"found slice\(.*expected whole frames and a step"):
        Motion(*movement(20), 30.0)[wrong]

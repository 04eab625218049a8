"""Python set for short answers, and set back."""

from __future__ import annotations

import gc
import sys

import pytest

from halfphysics.live.interpreter import SWITCH, quick_answers


def test_it_is_set_back():
    before = sys.getswitchinterval(), gc.get_threshold(), gc.get_freeze_count()
    with quick_answers():
        assert sys.getswitchinterval() == pytest.approx(SWITCH)
        assert gc.get_freeze_count() > before[2]
    assert (sys.getswitchinterval(), gc.get_threshold(), gc.get_freeze_count()) == before

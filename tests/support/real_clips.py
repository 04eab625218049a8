"""The recorded clips of ../shared/data, at about 30 frames per second."""

from __future__ import annotations

from functools import cache

import pytest

import halfphysics as hp
from support.paths import ROOT

FOLDER = ROOT.parent / "shared" / "data" / "motion"
NAMES = (
    "asap_walk1.npz",
    "asap_kick1.npz",
    "asap_kick3.npz",
    "asap_squat3.npz",
    "asap_side_jump1.npz",
    "asap_single_foot_jump2.npz",
    "animdraw_dab.bvh",
    "animdraw_jumping_jacks.bvh",
    "animdraw_jumping.bvh",
    "animdraw_jesse_dance.bvh",
)


@cache
def real_clip(name: str) -> hp.Motion:
    """A clip; skips the test where the data is absent."""
    path = FOLDER / name
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    motion = hp.Motion.load(path)
    if motion.fps > 60.0:
        motion = motion.resample(motion.fps / round(motion.fps / 30.0))
    return motion

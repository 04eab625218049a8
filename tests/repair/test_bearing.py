"""Feet that bear nobody: somebody sits or lies on furniture, and they hang."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.repair.bearing import borne_elsewhere
from halfphysics.repair.soles import Soles
from support.stools import OVER, room, seated


def low_seat():
    """Height of a seat whose sitter has the feet on the floor [m]."""
    motion, _ = seated(0.0, 2)
    return OVER - float(hp.Body.default().vertices(motion, 0)[:, 2].min())


def test_hanging_feet_do_not_rest():
    motion, place = seated(0.75)
    for kind in ("static", "object"):
        soles = Soles.of(motion, hp.Body.default(), room(0.75, place, kind=kind))
        assert not soles.rests.any()


def test_feet_on_the_floor_before_a_chair_rest_also_where_the_clip_floats():
    height = low_seat()
    motion, place = seated(height)
    for up in (0.0, 0.05, -0.04):
        moved = motion.with_frames(motion.translation + np.array([0.0, 0.0, up]), motion.rotations)
        soles = Soles.of(moved, hp.Body.default(), room(height, place))
        assert soles.rests.any(axis=1).all()


def test_a_seat_deep_in_a_cushion_leaves_the_feet_on_the_floor():
    height = low_seat()
    motion, place = seated(height)
    soles = Soles.of(motion, hp.Body.default(), room(height + 0.06, place))
    assert soles.rests.any(axis=1).all()


def test_level_ground_says_nothing():
    motion, _ = seated(0.0)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    high = np.full((len(motion), 4), 0.5)
    assert not borne_elsewhere(motion, hp.Body.default(), scene, {}, high).any()

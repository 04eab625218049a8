"""Recorded clips on a mattress: who walks, kicks, jumps or dances there stays on its feet."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.metrics.path_offset import path_of
from support.real_clips import real_clip

#: A mattress is so thick, and the clips are put on its surface [m].
THICK = 0.18
#: How much lower than on a mattress that is pressed to its frame, over which the clip stays as high
#: as over its ground [m]: hops fold legs for a moment.
FOLDED = {
    "asap_walk1.npz": 0.04,
    "asap_squat3.npz": 0.04,
    "asap_kick1.npz": 0.04,
    "asap_side_jump1.npz": 0.04,
    "asap_single_foot_jump2.npz": 0.10,
    "animdraw_jumping.bvh": 0.25,
    "animdraw_dab.bvh": 0.50,  # chaotic: 0.12 to 0.47 over motions that differ by 1e-12 to 1e-5 m
    "animdraw_jumping_jacks.bvh": 0.25,
    "animdraw_jesse_dance.bvh": 0.35,
}
#: Tilt at most [deg], and way off the path along the ground [m]: of recorded people and of dances.
LEANS = {".npz": (6.0, 0.05), ".bvh": (50.0, 0.3)}
#: The foot that the kick is made from sticks in the layer, by all the friction that it has, and the
#: person leans over it. (By 1 degree, while its leg was not bent as layers ask: it slid 0.36 m.)
LEANS_MORE = {"asap_kick1.npz": (15.0, 0.2)}


@pytest.mark.parametrize("name", FOLDED)
def test_recorded_people_stay_on_their_feet(name):
    body = hp.Body.default()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)  # joints that a skeleton lacks
        motion = real_clip(name).grounded(body).resample(30.0)
    middle = motion.translation.mean(axis=0)
    scene = hp.Scene()
    place = (middle[0], middle[1], -0.3)
    scene.add_static("bed", hp.Box((6.0, 6.0, 0.6)), position=place, soft="mattress")
    result = hp.simulate(motion, scene, body=body)
    off = result.motion.translation - result.reference.translation
    # A clip that floats over its ground stands on the frame all the same.
    floats = body.vertices(result.reference)[..., 2].min(axis=1)
    assert (off[:, 2] + THICK + floats).min() >= -FOLDED[name]
    most_tilt, most_off = LEANS_MORE.get(name, LEANS[name[-4:]])
    assert path_of(result.people[0]).max_tilt_deg < most_tilt
    assert np.linalg.norm(off[:, :2], axis=1).max() < most_off
    assert result.lost_time.sum() == 0.0

"""The same outcome wherever it happens: contact does not make much of little.

A T-pose glides against a wall and stays pressed for a second. Simulated again elsewhere (moved,
turned, or beside where it was by a nanometre), it ends at the same place relative to the wall.
"""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box
from halfphysics.settings import Settings
from support.people import along_x

#: Bounds of the joints' differences over the clip [m], skin and rigid parts. Seen of the skin:
#: 8e-11 near, 1.5e-10 where coordinates are rounded a hundred times more coarsely. Of the parts,
#: whose flat faces have many equally deep corners, 7e-6.
SKIN, PARTS = 1e-8, 1e-4
#: The same over the first 20 frames, of which ten have contact [m]; seen: 8e-11, parts 9e-7.
FIRST = 1e-6


@pytest.fixture(scope="module")
def body():
    return Body.default()


def joints_at_wall(body, contact, shift=(0.0, 0.0, 0.0), yaw=0.0, beside=0.0):
    """Joints (T, 55, 3) as seen from the wall [m]; the person starts `beside` along the wall."""
    motion, shift = along_x(1.5, 37, start=-0.1), np.asarray(shift)
    turn = rot.exp([0.0, 0.0, yaw])
    R = rot.to_matrix(turn)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(rotations[:, 0])))
    pelvis = body.joints(motion)[0, 0] - motion.translation[0]
    along = np.array([0.0, beside, 0.0])
    path = (motion.translation + along + pelvis) @ R.T - pelvis + shift
    scene = hp.Scene()
    at = R @ np.array([0.5, 0.0, 0.0]) + shift
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=at, quaternion=turn)
    settings = Settings(substeps=8, contact=contact)
    result = hp.simulate(motion.with_frames(path, rotations), scene, body=body, settings=settings)
    assert len(result.contacts.part) > 0
    return (body.joints(result.motion) - shift) @ R - along


@pytest.mark.parametrize(
    "elsewhere",
    [
        {"shift": (1e-9, 0.0, 0.0)},
        {"beside": 1e-9},
        {"yaw": 1.0},
        {"shift": (100.0, 50.0, 0.0)},
    ],
    ids=["nanometre", "beside", "yaw", "100 m"],
)
@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_a_body_at_a_wall_elsewhere(body, contact, elsewhere):
    here, there = joints_at_wall(body, contact), joints_at_wall(body, contact, **elsewhere)
    off = np.abs(there - here).max(axis=(1, 2))
    assert off[:20].max() <= FIRST
    assert off.max() <= (SKIN if contact == "skin" else PARTS)

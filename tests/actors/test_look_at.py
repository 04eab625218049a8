"""Looking and waiting."""

from __future__ import annotations

import math

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import LookAt, Person, Seen, Wait
from halfphysics.base import rotations as rot
from support.acted import body, range_excess, until_done


def facing(pose):
    """Direction of the face, world (3,)."""
    quats = body().joint_frames(pose)[1]
    return rot.rotate(quats[hp.JOINT_NAMES.index("head")], [0.0, 0.0, 1.0])


@pytest.mark.parametrize("at", [(2.0, 1.0, 1.5), (1.0, -1.0, 0.5), (1.5, 0.5, 2.3)])
def test_the_face_turns_to_it(at):
    person = Person(body(), goals=[LookAt(at, seconds=3.0)])
    person.reset()
    for _ in range(75):
        pose = person.next(1.0 / 30.0, Seen())
    head = body().joints(pose)[hp.JOINT_NAMES.index("head")]
    way = (np.array(at) - head) / np.linalg.norm(np.array(at) - head)
    assert np.degrees(np.arccos(facing(pose) @ way)) < 12.0


def test_necks_keep_their_ranges_and_turn_back():
    motion = until_done(Person(body(), goals=[LookAt((0.2, 3.0, 0.0)), Wait(3.0)]))
    assert range_excess(motion) < 1e-9
    assert facing(motion[len(motion) - 1])[0] > 0.99


def test_waiting_takes_its_time():
    motion = until_done(Person(body(), goals=[Wait(1.0), Wait(0.5)]), rest=0)
    assert len(motion) == pytest.approx(46, abs=2)
    with pytest.raises(hp.errors.InputError, match="Wait: seconds"):
        Wait(-1.0)
    assert math.isfinite(motion.translation.sum())

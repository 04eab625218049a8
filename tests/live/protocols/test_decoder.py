"""Every decoder of bytes, fed with its own messages that were damaged on the way."""

from __future__ import annotations

import importlib
import random

import numpy as np
import pytest

from halfphysics.live.protocols.malformed import Malformed
from support.live_frames import BODY, PERSON, any_pose, outgoing

#: Numbers that break naive readers: huge and negative sizes, NaN and infinity in both orders.
ODD = [
    bytes.fromhex(digits)
    for digits in ("7fffffff", "ffffffff", "00000000", "7fc00000", "0000c07f", "7f800000")
]
DAMAGED = 400


def damaged(message, chance):
    """A message with bytes changed, replaced, cut out or put in."""
    data = bytearray(message)
    for _ in range(chance.choice((0, 1, 2, 8, 40))):
        at = chance.randrange(len(data) + 1)
        kind = chance.randrange(4)
        if kind == 0:
            data[at : at + 1] = chance.randbytes(1)
        elif kind == 1:
            data[at : at + 4] = chance.choice(ODD)
        elif kind == 2:
            del data[at : at + chance.randrange(16)]
        else:
            data[at:at] = chance.randbytes(chance.randrange(8))
    return bytes(data)


@pytest.mark.parametrize("name", ["vmc", "mocopi", "xsens", "rokoko"])
def test_damaged_messages_are_read_or_refused(name):
    """Nothing but `Malformed` is raised, poses are finite, and afterwards good ones are read."""
    module = importlib.import_module(f"halfphysics.live.protocols.{name}")
    encoder = getattr(module, f"{name.capitalize()}Encoder")(PERSON, BODY)
    decoder = getattr(module, f"{name.capitalize()}Decoder")(PERSON, BODY)
    good = [data for k in range(2) for data in encoder.encode(outgoing(any_pose(k), k))]
    chance, refused = random.Random(name), 0
    for k in range(DAMAGED):
        if k % 97 == 0:
            decoder.calibrate()
        try:
            poses = decoder.decode(damaged(chance.choice(good), chance), 0.0)
        except Malformed:
            refused += 1
            continue
        assert all(np.isfinite(incoming.pose.rotations).all() for incoming in poses)
    assert 0 < refused < DAMAGED
    frames = [encoder.encode(outgoing(any_pose(k), 100 + k)) for k in range(3)]
    assert any(decoder.decode(data, 0.0) for frame in frames for data in frame)

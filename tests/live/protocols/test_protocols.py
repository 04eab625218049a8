"""The registry of protocols: names, addresses, and what is wrong with them."""

from __future__ import annotations

import importlib

import pytest

from halfphysics.errors import InputError
from halfphysics.live import protocols
from halfphysics.live.protocols import RECEIVERS, SENDERS, endpoint_of
from support.live_frames import BODY, PERSON, any_pose, outgoing

ALL = sorted({*RECEIVERS, *SENDERS})


@pytest.mark.parametrize("name", ALL)
def test_a_module_implements_what_is_listed(name):
    module = importlib.import_module(f"halfphysics.live.protocols.{name}")
    assert 0 <= module.PORT <= 65535
    assert hasattr(module, "receiver") == (name in RECEIVERS)
    assert hasattr(module, "sender") == (name in SENDERS)
    assert endpoint_of(name).port == module.PORT
    assert endpoint_of(name).is_local


@pytest.mark.parametrize("name", sorted(set(RECEIVERS) & set(SENDERS)))
def test_both_ways_by_name(name):
    receiver = protocols.receiver(f"{name}:0", person=PERSON, body=BODY)
    poses = []
    receiver.start(poses.append)
    sender = protocols.sender(str(receiver.endpoint), person=PERSON, body=BODY)
    sender.send(outgoing(any_pose(1)))
    sender.stop()
    receiver.stop()


def test_calibration_is_asked_for_in_the_text():
    assert protocols.receiver("vmc:0,calibrate=2.5", person=PERSON, body=BODY)._calibrate == 2.5
    assert protocols.receiver("vmc:0", person=PERSON, body=BODY)._calibrate is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("vcm:1", "did you mean vmc"),
        ("sonic:1", "'sonic' is not received"),
        ("vmc:1,calibrate=soon", "calibrate=SECONDS"),
        ("vmc:1,calibrate=-1", "calibrate"),
        ("vmc:1,scale=2", "calibrate=SECONDS"),
        ("vmc:99999", "port from 0"),
    ],
)
def test_mistakes_are_said(text, message):
    with pytest.raises(InputError, match=message):
        protocols.receiver(text, person=PERSON, body=BODY)


def test_what_does_not_go_out_is_said():
    with pytest.raises(InputError, match=r"'pico' is not sent\. Expected one of vmc"):
        protocols.sender("pico:1", person=PERSON, body=BODY)

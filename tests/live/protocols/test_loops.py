"""Through a live session: poses in by a protocol, corrected, out by it, and read again."""

from __future__ import annotations

import socket
import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.live import protocols
from halfphysics.live.protocols.rokoko import REST
from halfphysics.live.protocols.xsens import JOINTS as XSENS
from halfphysics.motion.skeleton import JOINT_INDEX
from support.live_frames import BODY, PERSON, furthest, outgoing, t_pose

#: The issue's bound [degrees].
WITHIN = 0.1
#: Joints that each protocol has a bone for.
JOINTS = {
    "vmc": range(55),
    "xsens": sorted(set(XSENS)),
    "rokoko": sorted(JOINT_INDEX[joint] for joint, _ in REST.values()),
    "mocopi": range(22),
}


def raised(joints):
    """Arms half raised, the head turned, fingers bent; what the protocol has no bone for rests."""
    rotations = t_pose().rotations.copy()
    for name, turn in {
        "left_shoulder": [0.0, -0.3, 0.5],
        "right_elbow": [0.0, 0.8, 0.0],
        "neck": [0.1, 0.3, 0.0],
        "left_index1": [0.0, 0.0, -0.6],
        "right_thumb2": [0.2, 0.1, 0.0],
        "jaw": [0.1, 0.0, 0.0],
    }.items():
        if JOINT_INDEX[name] in joints:
            rotations[JOINT_INDEX[name]] = turn
    return hp.Pose(t_pose().translation, rotations)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


@pytest.mark.parametrize("name", JOINTS)
def test_a_session_passes_poses_on(name):
    """On a floor with weight and strength, as the server's defaults are."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    pose = raised(JOINTS[name])
    got = []
    last = protocols.receiver(f"{name}:0", person=PERSON, body=BODY)
    last.start(got.append)
    forward = [str(last.endpoint)]
    into = f"{name}:{free_port()}"
    with hp.serve(scene, port=0, fps=60.0, listen=[into], forward=forward) as live:
        (person,) = live.session.people
        sender = protocols.sender(into, person=PERSON, body=BODY)
        end = time.monotonic() + 60.0
        frame = 0
        there = False
        while not there:
            assert time.monotonic() < end, furthest(got[-1].pose, pose) if got else "nothing"
            sender.send(outgoing(pose, frame))
            frame += 1
            time.sleep(1 / 60)
            there = bool(got) and furthest(got[-1].pose, pose) <= WITHIN
            there = there and live.session.newest.tracking[person] == "live"
        sender.stop()
    last.stop()
    assert np.abs(got[-1].pose.translation - pose.translation).max() < 0.01

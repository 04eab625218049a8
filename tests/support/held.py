"""A person who points ahead and holds a stick: shared by the tests of held objects."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.people import t_pose

HAND = JOINT_INDEX["right_wrist"]
SHOULDER = JOINT_INDEX["right_shoulder"]
PARTS = as_it_is(contact="parts")
G = 9.81
STICK = Box((0.6, 0.03, 0.03))


def pointing(frames=60, swing=None, path=None, fps=30.0):
    """Upright, facing +x, the right arm stretched ahead; `swing` (T,) turns it sideways [rad]."""
    motion = t_pose(np.zeros((frames, 3)) if path is None else path, fps)
    rotations = motion.rotations.copy()
    ahead = np.full(len(rotations), np.pi / 2) + (0.0 if swing is None else swing)
    rotations[:, SHOULDER, 1] = ahead
    return Motion(motion.translation, rotations, fps)


def in_front(body, pose, out=0.55, **options):
    """Options of an object `out` [m] in front of the right wrist, along +x."""
    at = body.joints(pose)[HAND] + [out, 0.0, 0.0]
    return {"position": at, "mass": 1.0} | options


def holding(body, motion, shape=STICK, settings=PARTS, scene=None, part="right_wrist", **options):
    """A simulator at the motion's first pose that holds "stick"."""
    scene = Scene() if scene is None else scene
    scene.add_object("stick", shape, **in_front(body, motion[0], **options))
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    simulator.reset(motion[0])
    simulator.attach("stick", part)
    return simulator


def place_in_part(body, frame, part=HAND, name="stick"):
    """Pose of the held object in the part's frame: position (3,) and matrix (3, 3)."""
    x, q = body.joint_frames(frame.pose)
    back = rot.conjugate(q[part])
    at, turn = frame.objects[name]
    return rot.rotate(back, at - x[part]), rot.to_matrix(rot.multiply(back, turn))


def corners(size, pose):
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return pose[0] + rot.rotate(pose[1], 0.5 * signs * np.asarray(size))


def same(a, b):
    """Are two frames equal to the last bit?"""
    assert (a.pose.translation == b.pose.translation).all()
    assert (a.pose.rotations == b.pose.rotations).all()
    assert (a.torque == b.torque).all()
    for name in a.objects:
        for x, y in zip(a.objects[name], b.objects[name], strict=True):
            assert (x == y).all()
    assert (a.contacts.impulse == b.contacts.impulse).all()

"""Rokoko Studio: custom streaming, JSON version 3 over UDP, port 14043.

``{"version": 3, "fps", "scene": {"timestamp", "actors": [{"name", "meta", "dimensions", "body":
{"hip": {"position": {x, y, z}, "rotation": {x, y, z, w}}, ...}}]}}``. Positions [m] and rotations
are in the world, in Unity's axes (Rokoko's plug-in takes them as they are); bones have axes of
their own in the T-pose (`REST`, from the same plug-in). Choose JSON without compression. The first
actor is taken.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.live.incoming import IncomingPose, Outgoing
from halfphysics.live.protocols import unity
from halfphysics.live.protocols.calibration import HEIGHTS, calibrated
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.rig import Rig, standing_height
from halfphysics.live.protocols.udp import UdpReceiver, UdpSender
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: Port that Rokoko's plug-ins listen on.
PORT = 14043

_H, _T = math.sqrt(0.5), (0.092296, 0.560986, 0.701057, 0.430459)
_Q = (math.sin(math.pi / 8) * _H, math.cos(math.pi / 8) * _H)
_LEFT_ARM, _RIGHT_ARM = (-0.5, -0.5, 0.5, -0.5), (0.5, -0.5, 0.5, 0.5)
_TRUNK, _ONE = (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)
_LEFT_LEG, _RIGHT_LEG = (0.0, _H, 0.0, _H), (0.0, -_H, 0.0, _H)
_LEFT_FOOT, _RIGHT_FOOT = (0.0, _H, -_H, 0.0), (0.0, -_H, _H, 0.0)
_LEFT_THUMBS = ((-_T[1], -_T[2], _T[3], -_T[0]), *2 * ((-_Q[1], -_Q[1], _Q[0], -_Q[0]),))
_RIGHT_THUMBS = ((_T[1], -_T[2], _T[3], _T[0]), *2 * ((_Q[1], -_Q[1], _Q[0], _Q[0]),))
_FINGERS = {"Index": "index", "Middle": "middle", "Ring": "ring", "Little": "pinky"}
_PHALANGES = ("Proximal", "Medial", "Distal")

#: Bone -> SMPL-X joint, and its rotation in the T-pose, x, y, z, w in Unity's axes.
REST: dict[str, tuple[str, tuple[float, ...]]] = {
    "hip": ("pelvis", _ONE),
    "spine": ("spine1", _TRUNK),
    "chest": ("spine3", _TRUNK),
    "neck": ("neck", _TRUNK),
    "head": ("head", _TRUNK),
    "leftShoulder": ("left_collar", (0.0, 0.0, _H, -_H)),
    "leftUpperArm": ("left_shoulder", _LEFT_ARM),
    "leftLowerArm": ("left_elbow", _LEFT_ARM),
    "leftHand": ("left_wrist", _LEFT_ARM),
    "rightShoulder": ("right_collar", (0.0, 0.0, _H, _H)),
    "rightUpperArm": ("right_shoulder", _RIGHT_ARM),
    "rightLowerArm": ("right_elbow", _RIGHT_ARM),
    "rightHand": ("right_wrist", _RIGHT_ARM),
    "leftUpLeg": ("left_hip", _LEFT_LEG),
    "leftLeg": ("left_knee", _LEFT_LEG),
    "leftFoot": ("left_ankle", _LEFT_FOOT),
    "leftToe": ("left_foot", _LEFT_FOOT),
    "rightUpLeg": ("right_hip", _RIGHT_LEG),
    "rightLeg": ("right_knee", _RIGHT_LEG),
    "rightFoot": ("right_ankle", _RIGHT_FOOT),
    "rightToe": ("right_foot", _RIGHT_FOOT),
    **{
        f"{side}{finger}{phalanx}": (f"{side}_{joint}{k + 1}", thumbs[k] if thumbs else arm)
        for side, arm, thumb in (
            ("left", _LEFT_ARM, _LEFT_THUMBS),
            ("right", _RIGHT_ARM, _RIGHT_THUMBS),
        )
        for finger, joint, thumbs in (
            ("Thumb", "thumb", thumb),
            *((name, joint, None) for name, joint in _FINGERS.items()),
        )
        for k, phalanx in enumerate(_PHALANGES)
    },
}
#: The bones, in that order.
BONES = tuple(REST)
_LEFT_HIP, _RIGHT_HIP = BONES.index("leftUpLeg"), BONES.index("rightUpLeg")
_FAR = 1e4


def receiver(
    endpoint: Endpoint, person: str, body: Body, *, calibrate: float | None = None
) -> UdpReceiver:
    """What receives from Rokoko Studio."""
    return UdpReceiver(endpoint, RokokoDecoder(person, body, str(endpoint)), calibrate=calibrate)


def sender(endpoint: Endpoint, person: str, body: Body) -> UdpSender:
    """What sends as Rokoko Studio does."""
    return UdpSender(endpoint, RokokoEncoder(person, body))


def plain_rig() -> Rig:
    """The bones as they are in Rokoko's T-pose."""
    joints = [JOINT_INDEX[joint] for joint, _ in REST.values()]
    rest = rot.normalize(unity.from_xyzw([turn for _, turn in REST.values()]))
    return Rig.of(joints, turns=rot.conjugate(rest))


class RokokoDecoder:
    """Messages to poses of one person."""

    def __init__(self, person: str, body: Body, source: str = "rokoko") -> None:
        self._person, self._body, self._source = person, body, source
        self.rig = plain_rig()
        self._wanted = self._calibrated = False

    def calibrate(self) -> None:
        """Take the next complete pose as a T-pose."""
        self._wanted = True

    def decode(self, data: bytes, now: float) -> list[IncomingPose]:
        """See `Decoder.decode`."""
        scene, actor = _scene(data)
        body = actor.get("body")
        if not isinstance(body, dict):
            return []
        rows = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (len(BONES), 1))
        given = np.zeros(len(BONES), dtype=bool)
        for i, bone in enumerate(BONES):
            found = body.get(bone)
            if found is not None:
                place, turn = (
                    _numbers(found, "position", "xyz"),
                    _numbers(found, "rotation", "xyzw"),
                )
                rows[i] = [*place, *turn]
                given[i] = True
        places, world = unity.position(rows[:, :3]), rot.normalize(unity.from_xyzw(rows[:, 3:]))
        if not given[0]:
            return []
        self._fit(actor, world, places, given)
        pose, tracked = self.rig.pose(world, given, places[0], self._body)
        time = scene.get("timestamp")
        stamp = float(time) if isinstance(time, (int, float)) and abs(time) < 1e15 else None
        return [IncomingPose(self._person, pose, stamp, tracked, self._source)]

    def _fit(self, actor: Any, world: Array, places: Array, given: NDArray[np.bool_]) -> None:
        """Calibrate if it was asked for; else the person's height says the scale."""
        height = places[0, 1]
        if not self._wanted:
            sizes = actor.get("dimensions")
            height = sizes.get("hipHeight") if isinstance(sizes, dict) else None
            if isinstance(height, (int, float)) and not self._calibrated:
                height = height / 100 if height > 10 else height  # the example has centimetres
                if HEIGHTS[0] < height < HEIGHTS[1]:
                    scale = standing_height(self._body) / height
                    self.rig = Rig(self.rig.joints, self.rig.turns, self.rig.axes, scale)
            return
        self._wanted, self._calibrated = False, True
        left = places[_LEFT_HIP] - places[_RIGHT_HIP]
        known = given[_LEFT_HIP] and given[_RIGHT_HIP] and np.linalg.norm(left) > 1e-3
        self.rig = calibrated(
            self.rig, world, self._body, height=float(height), left=left if known else None
        )


class RokokoEncoder:
    """Frames to messages of one actor with body and gloves."""

    def __init__(self, person: str, body: Body) -> None:
        self._person, self._body = person, body
        self._rig = plain_rig()

    def encode(self, outgoing: Outgoing) -> list[bytes]:
        """See `Encoder.encode`. A person who has no pose yet is no actor."""
        pose = outgoing.poses.get(self._person)
        actors = [] if pose is None else [self._actor(pose)]
        scene = {"timestamp": outgoing.time, "actors": actors, "characters": [], "props": []}
        message = {"version": 3, "fps": round(1.0 / outgoing.dt), "scene": scene}
        return [json.dumps(message, separators=(",", ":")).encode()]

    def _actor(self, pose: Any) -> dict[str, Any]:
        positions, quaternions = self._body.joint_frames(pose)
        places = unity.position(self._rig.places(positions[self._rig.joints])).round(6).tolist()
        turns = unity.to_xyzw(self._rig.bones(quaternions)).round(7).tolist()
        body = {
            bone: {
                "position": dict(zip("xyz", place, strict=True)),
                "rotation": dict(zip("xyzw", turn, strict=True)),
            }
            for bone, place, turn in zip(BONES, places, turns, strict=True)
        }
        gloves = dict.fromkeys(("hasGloves", "hasLeftGlove", "hasRightGlove", "hasBody"), True)
        return {
            "name": self._person,
            "color": [255, 255, 255],
            "meta": {**gloves, "hasFace": False},
            "dimensions": {
                "totalHeight": self._body.stature,
                "hipHeight": standing_height(self._body),
            },
            "body": body,
        }


def _scene(data: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    """The scene of a message and its first actor (empty: there is none)."""
    try:
        message = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise Malformed(
            f"rokoko: no JSON ({str(error)[:80]}). Switch the compression off"
        ) from None
    if not isinstance(message, dict) or not str(message.get("version")).startswith("3"):
        raise Malformed("rokoko: no message of version 3")
    scene = message.get("scene")
    actors = scene.get("actors") if isinstance(scene, dict) else None
    if not isinstance(scene, dict) or not isinstance(actors, list):
        raise Malformed("rokoko: a scene without actors")
    actor = actors[0] if actors else {}
    if not isinstance(actor, dict):
        raise Malformed("rokoko: an actor that is no object")
    return scene, actor


def _numbers(found: Any, name: str, keys: str) -> list[float]:
    """The numbers of a bone's position or rotation."""
    values = found.get(name) if isinstance(found, dict) else None
    numbers = [values.get(key) for key in keys] if isinstance(values, dict) else []
    good = [n for n in numbers if isinstance(n, (int, float)) and abs(n) < _FAR]
    if len(good) != len(keys):
        raise Malformed(f"rokoko: a {name} without finite {', '.join(keys)}")
    if keys == "xyzw" and sum(n * n for n in good) < 1e-6:
        raise Malformed("rokoko: a rotation of zeros")
    return good

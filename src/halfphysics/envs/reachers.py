"""People who stand and reach out with the right hand, N at once.

The person's frame: origin on the floor under the pelvis, x ahead, y left, z up. One row per person;
no row depends on another.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.easing import ease
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.scenarios.acting import arms
from halfphysics.scenarios.acting.acting import Act

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.envs.worlds import Worlds

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Largest acceleration of a hand that is told to move [m/s^2].
HASTE = 8.0
#: Direction of the elbow in the person's frame: behind, below and outside.
_POLE = np.array([-0.55, -0.45, -0.70])
#: Over how much height, from where the hand hangs, it turns its palm up [m].
_TURNS_OVER = 0.30
_WRIST = JOINT_INDEX["right_wrist"]
_FINGERS = [j for j in range(len(JOINT_NAMES)) if JOINT_NAMES[j].startswith("right_") and j >= 40]


class Reachers:
    """Standing people whose right hand is told where to go.

    Attributes:
        wrist: Where the wrist is told to be, in the person's frame (N, 3) [m].
        speed: Its velocity (N, 3) [m/s].
        curl: How far the fingers are closed (N,), 0 to 1.

    Args:
        body: Of all of them.
        worlds: Whose targets they make.
    """

    def __init__(self, body: Body, worlds: Worlds) -> None:
        count = worlds.count
        still = Act(body).motion(0.1, 30.0)
        self._pose = still[0]
        self._stands = np.array(self._pose.translation + body.rest_joints[0])
        self._arm = arms.arm_of(body, "right")
        frames, turns = body.joint_frames(still)
        self._collar = np.repeat(rot.to_matrix(turns[:1, self._arm.collar]), count, axis=0)
        self._shoulder = frames[0, self._arm.joints[0]] - [*self._stands[:2], 0.0]
        self.hangs = frames[0, _WRIST] - [*self._stands[:2], 0.0]
        self._hanging = turns[0, _WRIST]
        self._offered = rot.from_matrix(
            arms.palm_frame("right", np.array([1.0, 0.25, 0.0]), np.array([0.0, 0.0, 1.0]))
        )[0]
        if self._hanging @ self._offered < 0.0:
            self._offered = -self._offered
        joints = np.asarray(body.rest_joints)
        #: The middle of the palm's skin in the wrist's frame (3,) [m].
        self.palm = 0.8 * (joints[JOINT_INDEX["right_middle1"]] - joints[_WRIST])
        self.palm[1] -= 0.025
        self._places = worlds.joint_places()
        self._base = np.tile(worlds.coordinates([self._pose]), (count, 1))
        self._root = self._base[0, self._places[0] : self._places[0] + 4].copy()
        self.place, self.heading = np.zeros((count, 2)), np.zeros(count)
        self.wrist = np.tile(self.hangs, (count, 1))
        self.speed, self.curl = np.zeros((count, 3)), np.zeros(count)

    def start(self, i: int, place: Array, heading: float) -> Pose:
        """Person `i` stands at a place (2,) [m], facing `heading` [rad], arms hanging."""
        self.place[i], self.heading[i] = place, heading
        self.wrist[i], self.speed[i], self.curl[i] = self.hangs, 0.0, 0.0
        turn = np.array([np.cos(0.5 * heading), 0.0, 0.0, np.sin(0.5 * heading)])
        first = self._places[0] - 3
        self._base[i, first : first + 2] = place
        root = rot.multiply(turn, self._root)
        self._base[i, first + 3 : first + 7] = root
        rotations = np.array(self._pose.rotations)
        rotations[0] = rot.log(root)
        moved = np.array([*place, self._stands[2]]) - self._stands
        return Pose(self._pose.translation + moved, rotations, self._pose.axes)

    def tell(self, velocity: Array, curl: Array, dt: float, active: Flags) -> None:
        """Move the hands of active people for `dt` [s].

        Args:
            velocity: Wanted of the wrist, in the person's frame (N, 3) [m/s].
            curl: Wanted of the fingers (N,).
            dt: Length of the frame [s].
            active: Who moves (N,).
        """
        change = velocity - self.speed
        size = np.sqrt(np.sum(change * change, axis=1))
        share = np.minimum(1.0, HASTE * dt / np.maximum(size, 1e-9))
        speed = self.speed + share[:, None] * change
        wrist = self._within(self.wrist + dt * speed)
        self.speed = np.where(active[:, None], (wrist - self.wrist) / dt, self.speed)
        self.wrist = np.where(active[:, None], wrist, self.wrist)
        step = np.clip(curl - self.curl, -4.0 * dt, 4.0 * dt)
        self.curl = np.where(active, self.curl + step, self.curl)

    def targets(self) -> Array:
        """Rows of targets (N, K)."""
        rise = ease((self.wrist[:, 2] - self.hangs[2]) / _TURNS_OVER)
        turn = rot.normalize((1.0 - rise)[:, None] * self._hanging + rise[:, None] * self._offered)
        solved = arms.solve(
            self._arm,
            self._collar,
            np.broadcast_to(self._shoulder, self.wrist.shape),
            self.wrist,
            rot.to_matrix(turn),
            _POLE,
            one_motion=False,
        )
        for joint, rotvec in solved.items():
            self._put(joint, rot.exp(rotvec))
        angle = np.radians(15.0 + 35.0 * self.curl)
        bent = np.zeros((len(angle), 4))
        bent[:, 0], bent[:, 3] = np.cos(0.5 * angle), np.sin(0.5 * angle)
        for joint in _FINGERS[:12]:
            self._put(joint, bent)
        return self._base

    def to_world(self, vectors: Array) -> Array:
        """Vectors (N, 3) of the people's frames, in the world."""
        return _turned(vectors, self.heading)

    def from_world(self, vectors: Array) -> Array:
        """Vectors (N, 3) of the world, in the people's frames."""
        return _turned(vectors, -self.heading)

    def point_to_world(self, points: Array) -> Array:
        """Points (N, 3) of the people's frames, in the world [m]."""
        out = self.to_world(points)
        out[:, :2] += self.place
        return out

    def palms(self, wrists: Array) -> Array:
        """The middle of the palms (N, 3) [m] from poses of the right wrists (N, 7)."""
        turned: Array = rot.rotate(wrists[:, 3:], np.broadcast_to(self.palm, (len(wrists), 3)))
        return wrists[:, :3] + turned

    def _put(self, joint: int, quaternions: Array) -> None:
        at = self._places[joint]
        self._base[:, at : at + 4] = quaternions

    def _within(self, wrist: Array) -> Array:
        """Wrists (N, 3) within the arm's reach and clear of the body."""
        away = wrist - self._shoulder
        far = np.sqrt(np.sum(away * away, axis=1))
        share = np.minimum(1.0, 0.98 * self._arm.length / np.maximum(far, 1e-9))
        wrist = self._shoulder + share[:, None] * away
        # Raised hands stay in front of the trunk; hanging ones beside it.
        rise = ease((wrist[:, 2] - self.hangs[2]) / _TURNS_OVER)
        wrist[:, 0] = np.maximum(wrist[:, 0], self.hangs[0] + 0.18 * rise)
        wrist[:, 1] = np.minimum(wrist[:, 1], self.hangs[1] * (1.0 - rise) + 0.15 * rise)
        wrist[:, 2] = np.maximum(wrist[:, 2], self.hangs[2])
        return wrist


def _turned(vectors: Array, angle: Array) -> Array:
    """Vectors (N, 3) turned about z by angles (N,) [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.stack([c * x - s * y, s * x + c * y, vectors[:, 2]], axis=1)

"""Where browsers look from: presets, the way back, and a camera that goes along with people.

Every browser has a camera of its own, and what is turned by hand stays so: following only carries
the camera along, its angle and its distance stay.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from halfphysics.render.rasterizer import Camera
from halfphysics.viewer.framing import framed
from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]

#: Where presets look from.
PRESETS = ("Front", "Side", "Top", "Hands")

# A camera that follows is this late [s], and waits this long for a hand that turns it [s].
_LATE, _HANDS_OFF = 0.25, 0.4
# Reports of a browser within this of what was sent [m] are what was sent.
_SAME = 1e-3
_RECENT = 60
# Width over height that differs by less (its logarithm) is the same shape.
_SHAPE = 0.05
# Around joints [m]: half a head and a foot, and the flesh of a hand.
_BODY, _HAND = 0.16, 0.05
# Presets come no nearer [m].
_LEAST = 0.6

_HANDS = (
    [JOINT_INDEX["left_wrist"], *LEFT_HAND_JOINTS],
    [JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS],
)


class Follower:
    """Carries one camera along with something that moves.

    Args:
        position, look_at: Of the camera when it starts (3,) [m].
    """

    def __init__(self, position: Array, look_at: Array) -> None:
        self._look = np.array(look_at, dtype=np.float64)
        self._orbit = np.asarray(position, dtype=np.float64) - self._look
        self._aside = np.zeros(3)
        self._sent: deque[Array] = deque([self._look.copy()], maxlen=_RECENT)
        self._touched = -math.inf

    def move(
        self, position: Array, look_at: Array, subject: Array, now: float, dt: float
    ) -> tuple[Array, Array] | None:
        """Where the camera should be now.

        Args:
            position, look_at: As the browser says it is (3,) [m], maybe a little late.
            subject: What is followed (3,) [m].
            now: The time [s].
            dt: Since the last call [s].

        Returns:
            Position and look-at point; None: leave it, a hand is on it or it is there already.
        """
        orbit = position - look_at
        if np.linalg.norm(orbit - self._orbit) > _SAME * max(1.0, float(np.linalg.norm(orbit))):
            self._orbit, self._touched = orbit, now
        if min(float(np.linalg.norm(look_at - s)) for s in self._sent) > _SAME:
            # Moved by hand: it stays beside the subject by as much.
            self._aside = self._aside + look_at - self._look
            self._look, self._touched = look_at.copy(), now
            self._sent.append(self._look)
        if now - self._touched < _HANDS_OFF:
            return None
        way = subject + self._aside - self._look
        if np.linalg.norm(way) < _SAME:
            return None
        self._look = self._look + way * -math.expm1(-dt / _LATE)
        self._sent.append(self._look)
        return self._look + self._orbit, self._look

    def put(self, position: Array, look_at: Array, subject: Array) -> None:
        """Take a place that a preset chose; the camera stays so beside the subject."""
        self._look = np.array(look_at, dtype=np.float64)
        self._orbit = position - self._look
        self._aside = self._look - subject
        self._sent.append(self._look)
        self._touched = -math.inf


class Cameras:
    """The cameras of all browsers.

    Args:
        server: Of viser.
        stages: What they look at.
        home: The camera that sees everything, for a window's width and height [pixels].

    Attributes:
        stages: As given; may be changed.
        following: Whether they go along with people; set it as you like.
    """

    def __init__(
        self, server: Any, stages: Sequence[Stage], home: Callable[[tuple[int, int]], Camera]
    ) -> None:
        self._server = server
        self.stages = stages
        self._home = home
        # Of every browser: its window when it was last brought home, and where that was.
        self._homes: dict[int, tuple[tuple[int, int], Camera]] = {}
        self._followers: dict[int, Follower] = {}
        self._last = time.monotonic()
        self.following = False

    def home(self, client: Any) -> None:
        """Back to where everything is seen."""
        window = _window(client)
        camera = self._home(window)
        self._homes[client.client_id] = window, camera
        self._put(client, camera)

    def watch(self) -> None:
        """Browsers that have come go home; call it now and then.

        So do cameras that were never turned in windows that have another shape now, and those at
        viser's own first place, which is made for no window in particular: viser may take it
        after it was told where home is, and its own "Reset View" goes there too.
        """
        clients = self._server.get_clients()
        self._homes = {k: home for k, home in self._homes.items() if k in clients}
        for index, client in clients.items():
            if index not in self._homes:
                self.home(client)
                continue
            window, camera = self._homes[index]
            first = self._server.initial_camera
            if _at(client, camera.position, camera.target):
                lost = _reshaped(window, _window(client))
            else:
                lost = _at(client, first.position, first.look_at)
            if lost:
                self.home(client)

    def preset(self, client: Any, name: str) -> None:
        """Look from one of `PRESETS`, at people as they are now."""
        self._put(client, self.look(name, _window(client)))

    def look(self, name: str, window: tuple[int, int]) -> Camera:
        """The camera of a preset for a window of this size [pixels]."""
        people = self._people()
        joints = np.concatenate(people)
        left = people[0][JOINT_INDEX["left_hip"]] - people[0][JOINT_INDEX["right_hip"]]
        left = left * np.array([1.0, 1.0, 0.0])
        left /= max(float(np.linalg.norm(left)), 1e-9)
        up = np.array([0.0, 0.0, 1.0])
        front = np.cross(left, up)
        direction = {
            "Front": front + 0.15 * up,
            "Side": left + 0.15 * up,
            "Top": up + 0.02 * front,
            "Hands": front + 0.35 * left + 0.5 * up,
        }[name]
        room = _BODY
        if name == "Hands":
            joints, room = self._hands(), _HAND
        corners = room * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        points = (joints[:, None] + corners).reshape(-1, 3)
        return framed(points, direction, window, distance=_LEAST)

    def subject(self) -> Array:
        """What is followed: the middle of the people's pelvises (3,) [m]."""
        result: Array = np.mean([person[0] for person in self._people()], axis=0)
        return result

    def follow(self) -> None:
        """Carry the cameras along; call after what they look at has moved."""
        now = time.monotonic()
        dt, self._last = now - self._last, now
        clients = self._server.get_clients() if self.following else {}
        self._followers = {k: f for k, f in self._followers.items() if k in clients}
        if not clients:
            return
        subject = self.subject()
        for index, client in clients.items():
            camera = client.camera
            position, look_at = np.array(camera.position), np.array(camera.look_at)
            if index not in self._followers:
                self._followers[index] = Follower(position, look_at)
            moved = self._followers[index].move(position, look_at, subject, now, dt)
            if moved is not None:
                _aim(client, *moved)

    def _put(self, client: Any, camera: Camera) -> None:
        _aim(client, camera.position, camera.target)
        if client.client_id in self._followers:
            follower = self._followers[client.client_id]
            follower.put(camera.position, camera.target, self.subject())

    def _shown(self) -> list[Stage]:
        """Stages that are not hidden; where all are, as if they were not."""
        return [stage for stage in self.stages if stage.visible] or list(self.stages)

    def _people(self) -> list[Array]:
        """Joints of all people as shown now (55, 3) [m]."""
        return [p + stage.offset for stage in self._shown() for p in stage.joints()]

    def _hands(self) -> Array:
        """Joints of the hands that touch something now; where none does, of all (n, 3) [m]."""
        touching, every = [], []
        for stage in self._shown():
            contacts = stage.drawing.result.contacts
            now = np.asarray(contacts.frame) == stage.frame
            for k, joints in enumerate(stage.joints()):
                parts = np.asarray(contacts.part)[now & (np.asarray(contacts.person) == k)]
                for hand in _HANDS:
                    every.append(joints[hand] + stage.offset)
                    if np.isin(hand, parts).any():
                        touching.append(every[-1])
        return np.concatenate(touching or every)


def _window(client: Any) -> tuple[int, int]:
    """Width and height of a browser's window [pixels]."""
    return max(client.camera.image_width, 1), max(client.camera.image_height, 1)


def _reshaped(before: tuple[int, int], now: tuple[int, int]) -> bool:
    """Whether a window has another shape; a page that is slow draws fewer pixels in the same."""
    return abs(math.log(now[0] / now[1] * before[1] / before[0])) > _SHAPE


def _at(client: Any, position: Array, look_at: Array) -> bool:
    """Whether a browser says that it looks from there."""
    camera = client.camera
    return bool(
        np.allclose(camera.position, position, rtol=0.0, atol=_SAME)
        and np.allclose(camera.look_at, look_at, rtol=0.0, atol=_SAME)
    )


def _aim(client: Any, position: Array, look_at: Array) -> None:
    with client.atomic():
        client.camera.position = position
        client.camera.look_at = look_at

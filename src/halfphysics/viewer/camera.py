"""The cameras of browsers: presets, the first view, and a camera that follows people.

Every browser has a camera of its own. Following only translates the camera: the angle and the
distance that the user chose stay.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from halfphysics.render.rasterizer import Camera
from halfphysics.viewer.framing import framed
from halfphysics.viewer.stage import Stage, middle

Array = NDArray[np.float64]

#: Names of the presets.
PRESETS = ("Front", "Side", "Top", "Hands")

# Time constant of following [s], and the pause after the user moves the camera [s].
_LATE, _HANDS_OFF = 0.25, 0.4
# A browser reports the camera that it was given within this time [s].
_ARRIVES = 2.0
# A camera reported within this distance of the one sent [m] was not moved by the user.
_SAME = 1e-3
_RECENT = 60
# Windows whose width over height differs by less (in its logarithm) have the same shape.
_SHAPE = 0.05
# Margins around joints [m]: for a body (half a head, a foot) and for a hand.
_BODY, _HAND = 0.16, 0.05
# Mean distance of the outermost skin from the nearest joint, in height [m].
_SKIN = 0.08
# Least distance of the camera in presets [m].
_LEAST = 0.6

_HANDS = (
    [JOINT_INDEX["left_wrist"], *LEFT_HAND_JOINTS],
    [JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS],
)


class Follower:
    """Moves one camera along with a moving subject.

    Args:
        position, look_at: Initial position and look-at point of the camera (3,) [m].
    """

    def __init__(self, position: Array, look_at: Array) -> None:
        self._look = np.array(look_at, dtype=np.float64)
        self._orbit = np.asarray(position, dtype=np.float64) - self._look
        self._aside = np.zeros(3)
        self._sent: deque[Array] = deque([self._look.copy()], maxlen=_RECENT)
        self._touched = -math.inf

    @property
    def touched(self) -> bool:
        """Whether the user has moved the camera since it was put somewhere."""
        return self._touched > -math.inf

    def move(
        self, position: Array, look_at: Array, subject: Array, now: float, dt: float
    ) -> tuple[Array, Array] | None:
        """The pose that the camera should have now.

        Args:
            position, look_at: Those of the camera that the browser last reported (3,) [m].
            subject: The point to follow (3,) [m].
            now: The time [s].
            dt: Time since the last call [s].

        Returns:
            Position and look-at point; None: leave the camera, the user is moving it or it is
            there already.
        """
        orbit = position - look_at
        if np.linalg.norm(orbit - self._orbit) > _SAME * max(1.0, float(np.linalg.norm(orbit))):
            self._orbit, self._touched = orbit, now
        if min(float(np.linalg.norm(look_at - s)) for s in self._sent) > _SAME:
            # The user moved the camera: keep this offset from the subject.
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
        """Take the pose of a preset and keep its offset from the subject."""
        self._look = np.array(look_at, dtype=np.float64)
        self._orbit = position - self._look
        self._aside = self._look - subject
        self._sent.append(self._look)
        self._touched = -math.inf


@dataclass(frozen=True)
class _Home:
    """When a browser's camera was last set to the first view: its window, the camera, the subject.

    Until the browser reports that camera it may still report an older one, which is no hand of a
    user.
    """

    window: tuple[int, int]
    camera: Camera
    subject: Array
    time: float


class Cameras:
    """The cameras of all browsers.

    Args:
        server: The viser server.
        stages: The stages in view.
        home: The first camera, for a window's width and height [pixels].
        everything: The camera that sees everything, likewise; None: as `home`.

    Attributes:
        stages: The stages in view; may be changed.
        following: Whether the cameras follow people; may be set at any time.
    """

    def __init__(
        self,
        server: Any,
        stages: Sequence[Stage],
        home: Callable[[tuple[int, int]], Camera],
        everything: Callable[[tuple[int, int]], Camera] | None = None,
    ) -> None:
        self._server = server
        self.stages = stages
        self._home, self._everything = home, everything or home
        self._homes: dict[int, _Home] = {}
        self._followers: dict[int, Follower] = {}
        # Browsers with another view than the first; of these, those that see everything: they do
        # not follow.
        self._elsewhere: set[int] = set()
        self._resting: set[int] = set()
        self._last = time.monotonic()
        self.following = False

    def home(self, client: Any) -> None:
        """Set a browser's camera to the first view."""
        window = _window(client)
        camera = self._home(window)
        home = _Home(window, camera, self.subject(), time.monotonic())
        self._homes[client.client_id] = home
        self._followers.pop(client.client_id, None)
        self._put(client, camera)
        self._elsewhere.discard(client.client_id)

    def everything(self, client: Any) -> None:
        """Set a browser's camera to the view of everything; it then follows nobody."""
        self._put(client, self._everything(_window(client)))
        self._resting.add(client.client_id)

    def watch(self) -> None:
        """Set the cameras of new browsers home; call it regularly.

        Two other kinds of camera are set home, too: one that the user never moved, when its
        window has another shape now; and one at viser's initial camera, which fits no particular
        window: viser may apply it after the home view, and its "Reset View" goes there.
        """
        clients = self._clients()
        self._homes = {k: home for k, home in self._homes.items() if k in clients}
        for index, client in clients.items():
            if index not in self._homes:
                self.home(client)
                continue
            home = self._homes[index]
            window, camera = home.window, home.camera
            first = self._server.initial_camera
            follower = self._followers.get(index)
            untouched = follower is not None and not follower.touched
            untouched &= index not in self._elsewhere
            if untouched or _at(client, camera.position, camera.target):
                lost = _reshaped(window, _window(client))
            else:
                lost = _at(client, first.position, first.look_at)
            if lost:
                self.home(client)

    def preset(self, client: Any, name: str) -> None:
        """Apply one of `PRESETS`, for the present poses of the people."""
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
        return framed(_around(joints, room), direction, window, distance=_LEAST)

    def subject(self) -> Array:
        """The point that cameras follow: the mean of the people's pelvises (3,) [m]."""
        return middle(self._shown())

    def follow(self) -> None:
        """Move the cameras with the people; call after the stages have changed."""
        now = time.monotonic()
        dt, self._last = now - self._last, now
        clients = self._clients() if self.following else {}
        self._followers = {k: f for k, f in self._followers.items() if k in clients}
        if not clients:
            return
        subject = self.subject()
        for index, client in clients.items():
            camera = client.camera
            position, look_at = np.array(camera.position), np.array(camera.look_at)
            if index in self._resting:
                continue
            if index not in self._followers:
                home = self._homes.get(index)
                there = home is not None and _at(client, home.camera.position, home.camera.target)
                if home is not None and not there and now - home.time < _ARRIVES:
                    continue
                self._followers[index] = Follower(position, look_at)
                if home is not None and there:
                    self._followers[index].put(position, look_at, home.subject)
            moved = self._followers[index].move(position, look_at, subject, now, dt)
            if moved is not None:
                _aim(client, *moved)

    def _clients(self) -> dict[int, Any]:
        """The browsers; one that reports what is no camera is passed over."""
        return {k: c for k, c in self._server.get_clients().items() if _sound(c.camera)}

    def _put(self, client: Any, camera: Camera) -> None:
        self._elsewhere.add(client.client_id)
        self._resting.discard(client.client_id)
        _aim(client, camera.position, camera.target)
        if client.client_id in self._followers:
            follower = self._followers[client.client_id]
            follower.put(camera.position, camera.target, self.subject())

    def _shown(self) -> list[Stage]:
        """The visible stages; all stages if none is visible."""
        return [stage for stage in self.stages if stage.visible] or list(self.stages)

    def people(self) -> Array:
        """Points around the people as shown now, in the world (N, 3) [m]."""
        return _around(np.concatenate(self._people()), _SKIN)

    def _people(self) -> list[Array]:
        """Joints (55, 3) of each person as shown now, in the world [m]."""
        return [p + stage.offset for stage in self._shown() for p in stage.joints()]

    def _hands(self) -> Array:
        """Joints of the hands in contact now; of all hands if none is (n, 3) [m]."""
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


def _around(joints: Array, room: float) -> Array:
    """Corners of a cube around each joint."""
    corners = room * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return (joints[:, None] + corners).reshape(-1, 3)


def _sound(camera: Any) -> bool:
    try:
        points = np.array([camera.position, camera.look_at], dtype=np.float64)
    except (TypeError, ValueError):
        return False
    return points.shape == (2, 3) and bool(np.isfinite(points).all())


def _window(client: Any) -> tuple[int, int]:
    """Width and height of a browser's window [pixels]."""
    return max(client.camera.image_width, 1), max(client.camera.image_height, 1)


def _reshaped(before: tuple[int, int], now: tuple[int, int]) -> bool:
    """Whether a window's shape changed; a slow page draws fewer pixels in the same shape."""
    return abs(math.log(now[0] / now[1] * before[1] / before[0])) > _SHAPE


def _at(client: Any, position: Array, look_at: Array) -> bool:
    """Whether a browser reports this position and look-at point."""
    camera = client.camera
    return bool(
        np.allclose(camera.position, position, rtol=0.0, atol=_SAME)
        and np.allclose(camera.look_at, look_at, rtol=0.0, atol=_SAME)
    )


def _aim(client: Any, position: Array, look_at: Array) -> None:
    with client.atomic():
        client.camera.position = position
        client.camera.look_at = look_at

"""A small client of a live session: poses in, corrected frames out (docs/live.md)."""

from __future__ import annotations

import contextlib
import itertools
import math
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, cast

import numpy as np
from msgspec import UNSET
from numpy.typing import NDArray
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus, InvalidURI
from websockets.sync import client as websocket
from websockets.typing import Subprotocol

from halfphysics.errors import FileError, InputError
from halfphysics.live import schema
from halfphysics.live.incoming import Stamp, Tracking
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import N_JOINTS

Array = NDArray[np.float64]

#: Time within which an edit is answered, a connection is made, and closed [s].
_ANSWERS, _OPENS, _CLOSES = 10.0, 10.0, 1.0
#: Largest message of a server: its first one has the meshes of the scene [bytes].
_LARGEST = 256 * 2**20
#: Errors that are kept until `receive` raises them, the newest.
_KEPT = 100
#: Axes of all poses of a session.
_UPRIGHT = np.eye(3)


@dataclass(frozen=True, eq=False)
class LiveFrame:
    """A frame as a client gets it. Parts that were not subscribed to are empty.

    Attributes:
        frame: Its number.
        time: Simulated time [s].
        clock: Server's clock when it was done [s].
        poses: Name of a person -> corrected pose.
        targets: Name of a person -> pose that the physics was asked for.
        tracking: Name of a person -> "waiting", "live", "held" or "relaxed".
        stamps: Name of a person -> times of its newest pose.
        objects: Name -> (position (3,) [m], quaternion (4,)).
        joints: Name of an articulated object's joint -> its value [rad or m].
        contacts: The contacts of the frame, with forces [N].
        pressures: What is under pressure, pair by pair; sent to who asks for it by name.
        clearance: Minimum distance of the people from static geometry [m]; inf: far.
    """

    frame: int
    time: float
    clock: float
    poses: Mapping[str, Pose]
    targets: Mapping[str, Pose]
    tracking: Mapping[str, Tracking]
    stamps: Mapping[str, Stamp]
    objects: Mapping[str, tuple[Array, Array]]
    joints: Mapping[str, Any]
    contacts: Sequence[schema.Contact]
    clearance: float
    pressures: Sequence[schema.Pressed] = ()


def connect(url: str, *, token: str | None = None) -> LiveClient:
    """Connect to a live session (`hp.serve`, `halfphysics serve`).

    Args:
        url: Its address, such as "ws://127.0.0.1:8765".
        token: Its token, where it has one and the address does not hold it.

    Raises:
        FileError: Nothing answers there, or it refuses.
        InputError: No address, or a server of another version.
    """
    return LiveClient(url, token=token)


class LiveClient:
    """A connection to a live session; see `connect`. Used by one thread; closed by `with`.

    Attributes:
        hello: The first message: people, statics, objects, fps. Its statics and objects are those
            that are there now.
    """

    hello: schema.Hello

    def __init__(self, url: str, *, token: str | None = None) -> None:
        if not isinstance(url, str):
            raise InputError(f"url: found {url!r}, expected such as ws://127.0.0.1:8765")
        shown = url.partition("?")[0]  # without its token
        headers = {"Authorization": f"Bearer {token}"} if token is not None else None
        try:
            self._connection = websocket.connect(
                url,
                subprotocols=[Subprotocol(schema.MSGPACK_PROTOCOL)],
                additional_headers=headers,
                compression=None,
                max_size=_LARGEST,
                open_timeout=_OPENS,
                close_timeout=_CLOSES,
                proxy=None,
            )
        except InvalidURI as error:
            raise InputError(f"url: {error}; expected such as ws://127.0.0.1:8765") from None
        except ValueError as error:  # a port or an address that is none, a name of no host
            raise InputError(
                f"url: found {shown}, where nothing can be ({error}); expected such as "
                "ws://127.0.0.1:8765"
            ) from None
        except InvalidStatus as error:
            said = (error.response.body or b"").decode("utf-8", "replace").strip()
            raise FileError(f"{shown}: refused ({said or error})") from None
        except (OSError, InvalidHandshake) as error:
            raise FileError(
                f"{shown}: nothing answers there ({error}). Start halfphysics serve"
            ) from None
        self._keys = itertools.count(1)
        self._refused: deque[schema.ErrorMessage] = deque(maxlen=_KEPT)
        self.hello = self._greeted(shown)

    def _greeted(self, url: str) -> schema.Hello:
        """The first message; without one the connection is closed."""
        expected = f"expected a live session of version {schema.VERSION}"
        try:
            first = self._message(_OPENS)
            if isinstance(first, schema.Hello):
                return first
            raise InputError(f"{url}: {expected}")
        except TimeoutError:
            self.close()
            raise FileError(f"{url}: says nothing for {_OPENS:g} s; {expected}") from None
        except BaseException:
            self.close()
            raise

    @property
    def people(self) -> tuple[str, ...]:
        """The people's names."""
        return tuple(person.name for person in self.hello.people)

    @property
    def fps(self) -> float:
        """Frames per second of the server."""
        return self.hello.fps

    def send(
        self,
        pose: Pose | Mapping[str, Pose],
        *,
        time: float | None = None,
        tracked: Mapping[str, Any] | None = None,
    ) -> None:
        """Send the pose of the first person, or poses by name, which are stepped together.

        Args:
            pose: In the z-up world, with `axes` of the identity.
            time: When it was measured, by your clock [s]; it comes back in `LiveFrame.stamps`.
            tracked: Name of a person -> joints that are known (55,); None: all are.

        Raises:
            FileError: The connection was closed.
            InputError: A pose with other axes, or for nobody.
        """
        poses = {self._first(): pose} if isinstance(pose, Pose) else pose
        known = tracked or {}
        people = {}
        for name, one in poses.items():
            if (one.axes != _UPRIGHT).any():
                raise InputError(
                    f"pose of {name!r}: found axes {one.axes.tolist()}, expected the identity: "
                    "load the motion with Motion.rebased, or send poses in the z-up world"
                )
            flags = known.get(name)
            # The encoder takes lists for tuples: making them would cost as much as encoding them.
            people[name] = schema.PersonPose(
                one.translation.tolist(),
                one.rotations.tolist(),
                None if flags is None else [bool(flag) for flag in flags],
            )
        self._put(schema.PoseMessage(people, time))

    def receive(self, timeout: float | None = None) -> LiveFrame:
        """The next frame.

        Args:
            timeout: How long to wait for it [s]; None: until it comes.

        Raises:
            TimeoutError: None came within that time.
            FileError: The connection was closed.
            InputError: The server refused something that was sent.
        """
        ends = None if timeout is None else time.monotonic() + timeout
        while True:
            if self._refused:
                raise InputError(self._refused.popleft().message)
            left = None if ends is None else max(ends - time.monotonic(), 0.0)
            message = self._message(left)
            if isinstance(message, schema.FrameMessage):
                return _frame(message)
            if isinstance(message, schema.ErrorMessage):
                self._refused.append(message)

    def __iter__(self) -> Iterator[LiveFrame]:
        """Frames until the connection is closed."""
        while True:
            try:
                yield self.receive()
            except FileError:
                return

    def edit(self, action: schema.Action) -> None:
        """Change the scene: an action of `halfphysics.live.schema`, such as `Mass("ball", 2.0)`.

        Raises:
            InputError: The server refused it.
            FileError: The connection was closed, or there was no answer within 10 s.
        """
        key = next(self._keys)
        self._put(schema.Edit(action, key))
        self._answered(key)

    def subscribe(
        self,
        parts: Sequence[schema.Part] | None = None,
        *,
        people: Sequence[str] | None = None,
        rate: float | None = None,
    ) -> None:
        """Choose what frames hold: see `schema.Subscribe`. Errors are those of `edit`."""
        key = next(self._keys)
        chosen = None if parts is None else list(parts)
        self._put(schema.Subscribe(chosen, None if people is None else list(people), rate, key))
        self._answered(key)

    def ping(self) -> tuple[float, float]:
        """Ask for the server's clock; errors are those of `edit`.

        Returns:
            The time of the round trip [s], and the server's clock less `time.perf_counter` [s],
            which is uncertain by half of the round trip.
        """
        key, start = next(self._keys), time.perf_counter()
        self._put(schema.Ping(key))
        pong = self._answered(key)
        trip = time.perf_counter() - start
        clock = pong.clock if isinstance(pong, schema.Pong) else 0.0
        return trip, clock - (start + 0.5 * trip)

    def close(self) -> None:
        """Close the connection; what was not received is passed over."""
        # The answer of the server comes after all frames, so they are read meanwhile.
        closing = threading.Thread(target=self._connection.close, daemon=True)
        closing.start()
        with contextlib.suppress(ConnectionClosed, TimeoutError):
            while True:
                self._connection.recv(_CLOSES)
        closing.join()

    def __enter__(self) -> LiveClient:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    # -- inside --------------------------------------------------------------------------

    def _first(self) -> str:
        """Name of the first person."""
        if not self.people:
            raise InputError("send: found a pose, and nobody in the session; expected a person")
        return self.people[0]

    def _put(self, message: Any) -> None:
        try:
            self._connection.send(schema.encode(message, True))
        except ConnectionClosed as error:
            raise _closed(error) from None

    def _message(self, timeout: float | None) -> schema.FromServer:
        try:
            message = schema.from_server(self._connection.recv(timeout))
        except ConnectionClosed as error:
            raise _closed(error) from None
        if isinstance(message, schema.SceneMessage):
            self.hello.statics, self.hello.objects = message.statics, message.objects
        return message

    def _answered(self, key: int) -> schema.Done | schema.Pong:
        """Wait for the answer; frames from before it are passed over, errors of other messages are
        kept for `receive`.
        """
        ends = time.monotonic() + _ANSWERS
        while True:
            try:
                message = self._message(max(ends - time.monotonic(), 0.0))
            except TimeoutError:
                raise FileError(
                    f"no answer within {_ANSWERS:g} s: the server is too busy or gone"
                ) from None
            if isinstance(message, schema.ErrorMessage):
                if message.id == key:
                    raise InputError(message.message)
                self._refused.append(message)
            if isinstance(message, schema.Done | schema.Pong) and message.id == key:
                return message


def _closed(error: ConnectionClosed) -> FileError:
    said = error.rcvd.reason if error.rcvd is not None else ""
    return FileError(f"the live session closed the connection{f' ({said})' if said else ''}")


def _frame(message: schema.FrameMessage) -> LiveFrame:
    poses: dict[str, Pose] = {}
    targets: dict[str, Pose] = {}
    stamps: dict[str, Stamp] = {}
    for name, person in message.people.items():
        if person.stamp is not None:
            its = person.stamp
            stamps[name] = Stamp(its.sent, its.received, its.stepped)
        if person.translation is not UNSET and person.rotations is not UNSET:
            poses[name] = _pose(person.translation, person.rotations)
        if person.target_translation is not UNSET and person.target_rotations is not UNSET:
            targets[name] = _pose(person.target_translation, person.target_rotations)
    objects = {} if message.objects is UNSET else message.objects
    return LiveFrame(
        frame=message.frame,
        time=message.time,
        clock=message.clock,
        poses=poses,
        targets=targets,
        tracking={n: cast("Tracking", person.tracking) for n, person in message.people.items()},
        stamps=stamps,
        objects={
            name: (np.array(place.position), np.array(place.quaternion))
            for name, place in objects.items()
        },
        joints={} if message.joints is UNSET else message.joints,
        contacts=() if message.contacts is UNSET else message.contacts,
        clearance=math.inf if message.clearance is None else message.clearance,
        pressures=() if message.pressures is UNSET else message.pressures,
    )


def _pose(translation: list[float], rotations: list[list[float]]) -> Pose:
    """A pose whose numbers the schema has checked; their count is checked here."""
    place, turns = np.array(translation), np.array(rotations)
    if place.shape != (3,) or turns.shape != (N_JOINTS, 3):
        raise InputError(
            f"frame: found a pose of {place.shape} and {turns.shape} numbers, expected (3,) and "
            f"({N_JOINTS}, 3): a server of another version"
        )
    return Pose.trusted(place, turns, _UPRIGHT)

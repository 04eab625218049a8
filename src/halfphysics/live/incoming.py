"""What goes in and comes out of a live session, whatever the protocol.

A receiver turns the messages of one protocol into `IncomingPose` and calls `Deliver`; a sender
turns `Outgoing` into messages. Everything here is in the world of the scene: z-up, right-handed,
metres, seconds; rotations axis-angle [rad]; quaternions w, x, y, z.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.pose import Pose
from halfphysics.simulation.core_rows import ContactRows

if TYPE_CHECKING:
    from halfphysics.simulation.frame import Frame

Array = NDArray[np.float64]

#: What is known of a person: nobody has sent a pose yet; poses arrive; the last one is held, since
#: none arrives; the arms and the head go back to the stance, since none arrived for long.
Tracking = Literal["waiting", "live", "held", "relaxed"]


@dataclass(frozen=True, eq=False)
class IncomingPose:
    """The pose of one person, as a sender gives it.

    Attributes:
        person: Name of the person.
        pose: In the world; its `axes` turn what is given in other axes, as everywhere.
        time: The sender's clock when the pose was measured [s], any origin; None: it has none.
        tracked: Joints that the sender gives (55,); the others are held, then relax. None: all.
        source: Who sends it, such as "vmc:39539": a person follows one source at a time.
    """

    person: str
    pose: Pose
    time: float | None = None
    tracked: NDArray[np.bool_] | None = None
    source: str = ""


#: Hands a pose over: from any thread, never blocks, never raises. The newest pose of a person wins;
#: older ones and those for unknown people are dropped and counted.
Deliver = Callable[[IncomingPose], None]


@dataclass(frozen=True)
class Stamp:
    """The way of a pose through the server.

    Attributes:
        sent: `IncomingPose.time`, as it was given.
        received: Server's clock when it was delivered [s].
        stepped: Server's clock when the step towards it was done [s].
    """

    sent: float | None
    received: float
    stepped: float


@dataclass(frozen=True, eq=False)
class Outgoing:
    """One frame of a live session.

    Attributes:
        frame: Number of the frame, from 0.
        time: Simulated time [s].
        clock: Server's clock when the frame was done [s].
        poses: Name of a person -> corrected pose.
        targets: Name of a person -> the pose that the physics was asked for.
        tracking: Name of a person -> what is known of it.
        stamps: Name of a person -> stamp of the newest pose; those without a pose have none.
        objects: Name -> (position (3,) [m], quaternion (4,)); links of articulated objects too.
        joints: Name of an articulated object's joint -> its value [rad or m].
        contacts: The contacts of the frame; indices refer to `names`.
        names: Statics, objects, people: what `contacts` refer to.
        dt: Length of the frame [s]: force = impulse / dt.
        clearance: Minimum distance of the people from static geometry [m]; inf: far.
        simulated: The simulator's frame, with torques and diagnostics; None: from elsewhere.
    """

    frame: int
    time: float
    clock: float
    poses: Mapping[str, Pose]
    objects: Mapping[str, tuple[Array, Array]]
    contacts: ContactRows
    names: tuple[str, ...]
    dt: float
    clearance: float
    targets: Mapping[str, Pose] = field(default_factory=dict)
    tracking: Mapping[str, Tracking] = field(default_factory=dict)
    stamps: Mapping[str, Stamp] = field(default_factory=dict)
    joints: Mapping[str, Any] = field(default_factory=dict)
    simulated: Frame | None = None


class Receiver(Protocol):
    """Receives poses by a protocol, in a thread of its own."""

    def start(self, deliver: Deliver) -> None:
        """Open what it listens on; from now on poses are delivered.

        Raises:
            HalfPhysicsError: It cannot listen there.
        """

    def stop(self) -> None:
        """Close it; nothing is delivered after it returns."""


class Sender(Protocol):
    """Sends frames by a protocol. `send` is called once a frame and must not block."""

    def send(self, outgoing: Outgoing) -> None: ...

    def stop(self) -> None:
        """Close it."""

"""PICO headsets: body joints from XRoboToolkit's SDK, (24, 7): x, y, z, and x, y, z, w of each.

The 24 joints are SMPL's, in the world, y up [m]; in a T-pose that looks along -z they have no
rotation, as in OpenXR. That is how NVIDIA's SONIC reads them: it turns each by half a turn about
its y axis, and then about the world's x axis upright. The SDK (`xrobotoolkit_sdk`) is not on PyPI;
it is imported when the receiver is started. The port says nothing: the SDK has its own connection.
"""

from __future__ import annotations

import importlib
import threading
import time
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import MissingDependencyError
from halfphysics.live.incoming import Deliver, IncomingPose
from halfphysics.live.protocols.calibration import calibrated
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.rig import Rig
from halfphysics.live.protocols.udp import Counts

Array = NDArray[np.float64]

#: It has none; see above.
PORT = 0
#: Joints that are read: SMPL's last two are hands, which SMPL-X's wrists hold.
N_READ = 22
#: Time between two looks at the SDK [s]: it has at most 90 poses a second.
PERIOD = 0.002
_LEFT_HIP, _RIGHT_HIP, _FAR = 1, 2, 1e4


def receiver(
    endpoint: Endpoint, person: str, body: Body, *, calibrate: float | None = None
) -> PicoReceiver:
    """What asks the SDK for poses."""
    return PicoReceiver(person, body, calibrate=calibrate)


def plain_rig() -> Rig:
    """Joints without rotation in a T-pose that looks along -z."""
    half_turn = np.tile([0.0, 0.0, 1.0, 0.0], (N_READ, 1))
    return Rig.of(range(N_READ), turns=half_turn)


class PicoDecoder:
    """Arrays of body joints to poses of one person."""

    def __init__(self, person: str, body: Body, source: str = "pico") -> None:
        self._person, self._body, self._source = person, body, source
        self.rig = plain_rig()
        self._wanted = False

    def calibrate(self) -> None:
        """Take the next pose as a T-pose."""
        self._wanted = True

    def decode(self, joints: ArrayLike, time: float) -> IncomingPose:
        """The pose of body joints (24, 7) that were measured at `time` [s].

        Raises:
            Malformed: Another shape, numbers that are not finite, quaternions of zeros.
        """
        try:
            rows = np.array(joints, dtype=np.float64)
        except (TypeError, ValueError):
            raise Malformed("pico: no array of numbers") from None
        if rows.shape != (24, 7):
            raise Malformed(f"pico: found shape {rows.shape}, expected (24, 7)")
        rows = rows[:N_READ]
        if not np.isfinite(rows).all() or np.abs(rows).max() > _FAR:
            raise Malformed("pico: numbers that are not finite or far out of range")
        if (np.square(rows[:, 3:]).sum(axis=1) < 1e-6).any():
            raise Malformed("pico: a quaternion of zeros")
        places, world = rows[:, :3], rot.normalize(rows[:, [6, 3, 4, 5]])
        if self._wanted:
            self._wanted = False
            left = places[_LEFT_HIP] - places[_RIGHT_HIP]
            self.rig = calibrated(
                self.rig,
                world,
                self._body,
                height=float(places[0, 1]),
                left=left if np.linalg.norm(left) > 1e-3 else None,
            )
        given = np.ones(N_READ, dtype=bool)
        pose, tracked = self.rig.pose(world, given, places[0], self._body)
        return IncomingPose(self._person, pose, time, tracked, self._source)


def _sdk() -> Any:
    try:
        return importlib.import_module("xrobotoolkit_sdk")
    except ImportError as error:
        raise MissingDependencyError(
            "poses of PICO headsets need xrobotoolkit_sdk, which is not on PyPI: build it from "
            "github.com/XR-Robotics/XRoboToolkit-PC-Service-Pybind"
        ) from error


class PicoReceiver:
    """A `Receiver` that asks the SDK in a thread; a pose with the same time stamp is taken once.

    Args:
        person: Name of the person.
        body: The person's body.
        calibrate: Seconds after the first pose at which the person stands in a T-pose.
        sdk: The module; None: `xrobotoolkit_sdk`.
    """

    def __init__(
        self, person: str, body: Body, *, calibrate: float | None = None, sdk: Any = None
    ) -> None:
        self.decoder = PicoDecoder(person, body)
        self.counts = Counts()
        self._sdk = sdk
        self._calibrate = calibrate
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self, deliver: Deliver) -> None:
        """Connect to the SDK's service and ask it in a thread; see `Receiver.start`."""
        sdk = self._sdk
        if sdk is None:
            sdk = _sdk()
        sdk.init()
        self._over.clear()
        self._thread = threading.Thread(target=self._ask, args=(sdk, deliver), daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End it; nothing is delivered after it returns."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def calibrate(self) -> None:
        """Take the next pose as a T-pose."""
        self.decoder.calibrate()

    def _ask(self, sdk: Any, deliver: Deliver) -> None:
        last: int | None = None
        first: float | None = None
        while not self._over.wait(PERIOD):
            stamp = int(sdk.get_time_stamp_ns()) if sdk.is_body_data_available() else last
            if stamp is None or stamp == last:
                continue
            last = stamp
            self.counts.datagrams += 1
            try:
                pose = self.decoder.decode(sdk.get_body_joints_pose(), stamp * 1e-9)
            except Malformed as error:
                self.counts.malformed += 1
                self.counts.last_error = str(error)[:200]
                continue
            self.counts.poses += 1
            deliver(pose)
            now = time.monotonic()
            first = now if first is None else first
            if self._calibrate is not None and now - first >= self._calibrate:
                self._calibrate = None
                self.decoder.calibrate()
        sdk.close()

"""UDP: one thread that listens and decodes, and a sender that never blocks.

Whoever reaches the port can send. So what arrives is bounded in size and in rate, what is no
message of the protocol is counted, and while one machine sends, others are ignored.
"""

from __future__ import annotations

import socket
import threading
import time
from dataclasses import dataclass, replace
from typing import Any

from halfphysics.errors import InputError
from halfphysics.live.incoming import Deliver, Outgoing
from halfphysics.live.protocols.decoder import Decoder, Encoder
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.live.protocols.malformed import Malformed

#: Most datagrams a second that are decoded, over all senders: VMC may send each bone as one.
MAX_RATE = 20_000
#: After this silence another machine may take over [s].
SILENCE = 2.0
# Largest payload of a UDP datagram [bytes]; how long `stop` may take [s].
_LARGEST, _PATIENCE = 65_507, 0.2


@dataclass
class Counts:
    """What a receiver got since it was started.

    Attributes:
        datagrams: Decoded datagrams.
        poses: Poses delivered.
        malformed: Datagrams that are not of the protocol.
        other_senders: Datagrams of other machines, while one sends.
        over_rate: Datagrams beyond `MAX_RATE`, which nobody has looked into.
        last_error: What was wrong with the last malformed one.
    """

    datagrams: int = 0
    poses: int = 0
    malformed: int = 0
    other_senders: int = 0
    over_rate: int = 0
    last_error: str = ""


class UdpReceiver:
    """A `Receiver` of datagrams.

    Args:
        endpoint: Where to listen.
        decoder: Of the protocol.
        calibrate: Seconds after the first pose at which the person stands in a T-pose; None: the
            sender's rest pose is as its protocol says.
    """

    def __init__(
        self, endpoint: Endpoint, decoder: Decoder, *, calibrate: float | None = None
    ) -> None:
        self._endpoint = endpoint
        self.decoder = decoder
        self.counts = Counts()
        self._calibrate = calibrate
        self._calibrate_at: float | None = None
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None
        self._over = threading.Event()
        self._gate = _Gate()

    @property
    def endpoint(self) -> Endpoint:
        """Where it listens; once it is started, with the port that was taken."""
        if self._socket is None:
            return self._endpoint
        port = self._socket.getsockname()[1]
        return Endpoint(self._endpoint.protocol, self._endpoint.host, port)

    @property
    def trouble(self) -> str:
        """Why less comes in than is sent, in one line; "": there is nothing to say."""
        counts, found = self.counts, []
        if counts.malformed:
            # Senders' bytes are in the message: none of them is to steer a terminal.
            why = "".join(c if c.isprintable() else "?" for c in counts.last_error)
            name = self._endpoint.protocol
            found.append(f"datagrams not understood as {name}: {counts.malformed} ({why})")
        if counts.other_senders:
            found.append(f"datagrams of a second machine, left out: {counts.other_senders}")
        if counts.over_rate:
            found.append(f"datagrams beyond {MAX_RATE} a second, left out: {counts.over_rate}")
        if not counts.poses:
            heard = counts.datagrams or counts.malformed
            found.append("no pose in what was heard" if heard else "nothing was heard")
        return ", ".join(found)

    def start(self, deliver: Deliver) -> None:
        """Open the port and listen in a thread; see `Receiver.start`."""
        where = self._endpoint
        family = socket.AF_INET6 if ":" in where.host else socket.AF_INET
        opened = socket.socket(family, socket.SOCK_DGRAM)
        try:
            opened.bind((where.host, where.port))
        except (OSError, UnicodeError) as error:  # UnicodeError: a name that no host can have
            opened.close()
            said = getattr(error, "strerror", None) or error
            raise InputError(
                f"{where}: cannot listen there ({said}). Is another program "
                f"listening on port {where.port}? End it, or choose another port"
            ) from None
        opened.settimeout(_PATIENCE)
        self._socket = opened
        self._over.clear()
        self._thread = threading.Thread(
            target=self._listen, args=(opened, deliver), name=str(where), daemon=True
        )
        self._thread.start()

    def stop(self) -> None:
        """Close the port; nothing is delivered after it returns."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
        if self._socket is not None:
            self._socket.close()
        self._socket = self._thread = None

    def calibrate(self) -> None:
        """Take the next complete pose as a T-pose."""
        self.decoder.calibrate()

    def _listen(self, opened: socket.socket, deliver: Deliver) -> None:
        while not self._over.is_set():
            try:
                data, sender = opened.recvfrom(_LARGEST)
            except TimeoutError:
                continue
            except OSError:  # such as a port of ours that is not reached: of a datagram sent
                if self._over.is_set():
                    return
                continue
            self.take(data, sender[0], time.monotonic(), deliver)

    def take(self, data: bytes, sender: str, now: float, deliver: Deliver) -> None:
        """One datagram: checked, decoded, and its poses delivered. Never raises."""
        counts = self.counts
        # What is refused without a look takes no room from whoever sends.
        if not self._gate.is_open_to(sender, now):
            counts.other_senders += 1
            return
        if not self._gate.has_room(now):
            counts.over_rate += 1
            return
        try:
            poses = self.decoder.decode(data, now)
        except Malformed as error:
            counts.malformed += 1
            counts.last_error = str(error)[:200]
            return
        except Exception as error:  # of ours: it must not end the session of whoever moves
            counts.malformed += 1
            counts.last_error = f"{type(error).__name__}: {error}"[:200]
            return
        self._gate.took(sender, now)
        counts.datagrams += 1
        for pose in poses:
            counts.poses += 1
            deliver(pose)
        if poses and self._calibrate is not None:
            if self._calibrate_at is None:
                self._calibrate_at = now + self._calibrate
            elif now >= self._calibrate_at:
                self._calibrate = None
                self.decoder.calibrate()


class _Gate:
    """Who may send, and how much."""

    def __init__(self) -> None:
        self._second, self._in_it = 0.0, 0
        self._sender, self._heard = "", 0.0

    def has_room(self, now: float) -> bool:
        """Whether one more datagram is within the rate of this second."""
        if now - self._second >= 1.0:
            self._second, self._in_it = now, 0
        self._in_it += 1
        return self._in_it <= MAX_RATE

    def is_open_to(self, sender: str, now: float) -> bool:
        """Whether no other machine has sent lately."""
        return not self._sender or sender == self._sender or now - self._heard > SILENCE

    def took(self, sender: str, now: float) -> None:
        """A datagram of a machine was of the protocol."""
        self._sender, self._heard = sender, now


class UdpSender:
    """A `Sender` of datagrams; what the system has no room for is dropped and counted."""

    def __init__(self, endpoint: Endpoint, encoder: Encoder) -> None:
        if endpoint.port == 0:  # nobody can be sent to
            raise InputError(
                f"{endpoint}: found port 0, expected the port where it is heard, such as "
                f"{replace(endpoint, port=39540)}"
            )
        try:
            found = socket.getaddrinfo(endpoint.host, endpoint.port, type=socket.SOCK_DGRAM)
        except (OSError, UnicodeError) as error:  # UnicodeError: a name that no host can have
            said = getattr(error, "strerror", None) or error
            raise InputError(
                f"{endpoint}: the host is not found ({said}). Give its name or its IP address"
            ) from None
        family, kind, _, _, address = found[0]
        self._address: Any = address
        self.endpoint = endpoint
        self.encoder = encoder
        self.sent = self.dropped = 0
        self._socket = socket.socket(family, kind)
        self._socket.setblocking(False)

    def send(self, outgoing: Outgoing) -> None:
        """Send a frame's messages."""
        for data in self.encoder.encode(outgoing):
            try:
                self._socket.sendto(data, self._address)
                self.sent += 1
            except OSError:  # nobody listens there, or the buffer is full
                self.dropped += 1

    def stop(self) -> None:
        """Close it."""
        self._socket.close()

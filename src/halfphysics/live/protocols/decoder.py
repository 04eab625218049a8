"""What turns the messages of one protocol into poses, and frames into its messages.

They know nothing of sockets: `udp` and others bring the bytes.
"""

from __future__ import annotations

from typing import Protocol

from halfphysics.live.incoming import IncomingPose, Outgoing


class Decoder(Protocol):
    """Bytes to poses."""

    def decode(self, data: bytes, now: float) -> list[IncomingPose]:
        """The poses that are complete with this message; often none or one.

        Args:
            data: The message.
            now: The receiver's clock [s].

        Raises:
            Malformed: The message does not follow the protocol. Nothing of it is taken.
        """

    def calibrate(self) -> None:
        """Take the next complete pose as a T-pose (see `calibration`)."""


class Encoder(Protocol):
    """Frames to bytes."""

    def encode(self, outgoing: Outgoing) -> list[bytes]:
        """The messages of a frame, in the order in which to send them."""

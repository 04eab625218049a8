"""Contacts of the last frame of a running simulation, for `ContactNodes`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.viewer.contacts import KINDS, FrameContacts, Ints, kinds_of

if TYPE_CHECKING:
    from halfphysics.viewer.session import Session


class LiveContacts:
    """The contacts of a session's last frame, for any requested frame.

    Attributes:
        kind: All kinds: those that will occur are not known yet.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self.kind: Ints = np.arange(len(KINDS))

    def at(self, frame: int) -> FrameContacts:
        """The contacts of the session's last frame."""
        session, touches = self._session, self._session.frame.contacts
        simulator = session.simulator
        count = len(simulator.names), len(session.frame.objects), len(simulator.bodies)
        return FrameContacts(
            rows=np.arange(len(touches.part)),
            kind=kinds_of(touches, *count),
            position=touches.position,
            force=touches.impulse * session.fps,
        )

"""Contacts of a simulation that runs: those of its last frame, for `ContactNodes`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.viewer.contacts import KINDS, FrameContacts, Ints, kinds_of

if TYPE_CHECKING:
    from halfphysics.viewer.session import Session


class LiveContacts:
    """What touches in the frame that a session made last, whatever frame is asked for.

    Attributes:
        kind: Every kind: which will occur is not known yet.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self.kind: Ints = np.arange(len(KINDS))

    def at(self, frame: int) -> FrameContacts:
        """Those of the session's frame."""
        session, touches = self._session, self._session.frame.contacts
        simulator = session.simulator
        count = len(simulator.names), len(session.frame.objects), len(simulator.bodies)
        return FrameContacts(
            rows=np.arange(len(touches.part)),
            kind=kinds_of(touches, *count),
            position=touches.position,
            force=touches.impulse * session.fps,
        )

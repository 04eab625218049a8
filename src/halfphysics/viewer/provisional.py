"""A provisional result for the viewer to draw, before the simulation starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.results.contacts import Contacts
from halfphysics.results.result import ObjectTrack, PersonResult, Result

if TYPE_CHECKING:
    from halfphysics.viewer.session import Session


def provisional(session: Session) -> Result:
    """A result with people on their references and objects at their present poses."""
    count, simulator = session.frames, session.simulator
    motions = session.sequence.motions
    names = simulator.names[len(simulator.names) - len(motions) :]
    return Result(
        people=tuple(
            PersonResult(name=name, motion=motion, reference=motion, body=body)
            for name, motion, body in zip(names, motions, simulator.bodies, strict=True)
        ),
        objects={
            name: ObjectTrack(
                position=np.tile(position, (count, 1)), quaternion=np.tile(quaternion, (count, 1))
            )
            for name, (position, quaternion) in session.frame.objects.items()
        },
        scene=simulator.world.scene,
        names=simulator.names,
        contacts=Contacts.none(),
        clearance=np.full(count, np.inf),
        lost_time=np.zeros(count),
        settings=simulator.settings,
    )

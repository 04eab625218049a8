"""A provisional result for the viewer to draw, before the simulation starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.results.contacts import Contacts
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.settings import Settings

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.simulator import Simulator

Array = NDArray[np.float64]


def provisional(
    simulator: Simulator, motions: Sequence[Motion], objects: Mapping[str, tuple[Array, Array]]
) -> Result:
    """A result of a simulator with people on their references and objects where they are now.

    Args:
        simulator: The simulator.
        motions: The reference of each person.
        objects: Name -> position (3,) [m] and quaternion (4,), as of `Frame.objects`.
    """
    return drawn(
        motions,
        simulator.bodies,
        simulator.world.scene,
        objects,
        names=simulator.names,
        settings=simulator.settings,
    )


def drawn(
    motions: Sequence[Motion],
    bodies: Sequence[Body],
    scene: Scene,
    objects: Mapping[str, tuple[Array, Array]],
    *,
    names: Sequence[str],
    settings: Settings | None = None,
) -> Result:
    """A result that is only drawn: people on their motions, objects at rest.

    Args:
        motions, bodies: Of each person.
        scene: What is around them.
        objects: Name -> position (3,) [m] and quaternion (4,).
        names: Statics, objects, people, as in `Result.names`.
        settings: Of the simulation; None: the defaults.
    """
    count = len(motions[0]) if motions else 1
    return Result(
        people=tuple(
            PersonResult(name=name, motion=motion, reference=motion, body=body)
            for name, motion, body in zip(
                list(names)[len(names) - len(motions) :], motions, bodies, strict=True
            )
        ),
        objects={
            name: ObjectTrack(
                position=np.tile(position, (count, 1)), quaternion=np.tile(quaternion, (count, 1))
            )
            for name, (position, quaternion) in objects.items()
        },
        scene=scene,
        names=tuple(names),
        contacts=Contacts.none(),
        clearance=np.full(count, np.inf),
        lost_time=np.zeros(count),
        settings=Settings() if settings is None else settings,
    )

"""What an actor is: it sees what became of its last pose, and says the next one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from halfphysics.actors.seen import Seen
    from halfphysics.motion.pose import Pose


@runtime_checkable
class Actor(Protocol):
    """Gives the reference of one person, frame by frame.

    An actor knows no simulator: who runs one hands it what it sees. Equal seeds, times and sights
    give equal poses, to the bit.
    """

    def reset(self, seed: int = 0) -> Pose:
        """Begin again; returns the first pose, with which the simulation is to start.

        Args:
            seed: Of all that the actor draws by chance, at least 0.
        """
        ...

    def next(self, dt: float, seen: Seen) -> Pose:
        """The reference `dt` [s] later.

        Args:
            dt: Length of the frame that begins, above 0.
            seen: The world at its begin.
        """
        ...

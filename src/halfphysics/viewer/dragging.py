"""Objects that are pulled about by the pointer: a critically damped pull, by velocity."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import vector
from halfphysics.errors import InputError
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.simulation.simulator import Simulator

Array = NDArray[np.float64]

#: Natural frequency of the pull [1/s]: a still pointer is reached to 2 % within 0.3 s.
FREQUENCY = 20.0
#: Fastest that anything is pulled [m/s]: quicker than a hand throws a ball across a room.
FASTEST = 12.0


def draggable(simulator: Simulator, name: str) -> bool:
    """Whether the pointer can pull it: a free object that is not held."""
    item = simulator.world.scene.objects.get(name)
    return item is not None and not isinstance(item, KinematicObject) and name not in simulator.held


@dataclass
class Drag:
    """An object in the grip of a pointer.

    Its origin keeps the offset that it had from the pointer. What it turns with dies away. Let
    go, it has the velocity that it has.

    Attributes:
        name: Of the object.
        pointer: Where the pointer is in the world (3,) [m].
        offset: From the pointer to the object's origin when it was taken (3,) [m].
    """

    name: str
    pointer: Array
    offset: Array = field(default_factory=lambda: np.zeros(3))

    @staticmethod
    def begin(simulator: Simulator, name: str, at: object, pointer: object) -> Drag:
        """Take an object.

        Args:
            simulator: Its simulation.
            name: Of a free object.
            at: The point of it that is taken, in the world (3,) [m].
            pointer: Where the pointer is already (3,) [m].

        Raises:
            InputError: Something that cannot be pulled, or no vector.
        """
        if not draggable(simulator, name):
            raise InputError(f"drag: found {name!r}, expected an object that moves freely")
        grip = vector(at, "drag: the point that is taken", unit="m")
        place = next(p for p in simulator.world.objects if p.name == name)
        origin, _ = place.pose(simulator.world.stepper.qpos())
        return Drag(name, np.array(vector(pointer, "drag: pointer", unit="m")), origin - grip)

    def follow(self, pointer: object) -> None:
        """The pointer has moved.

        Raises:
            InputError: No vector.
        """
        self.pointer = np.array(vector(pointer, "drag: pointer", unit="m"))

    def pull(self, simulator: Simulator, dt: float) -> None:
        """Give the object its velocity for the frame of length `dt` [s] that comes.

        What it meets on the way stops it: the velocity is only what it sets out with.
        """
        place = next(p for p in simulator.world.objects if p.name == self.name)
        origin, _ = place.pose(simulator.world.stepper.qpos())
        speed, spin = simulator.velocity(self.name)
        # Gravity adds to the velocity during a frame; half of that is what the way is off by.
        half = 0.5 * dt * simulator.world.scene.gravity
        off = origin - (self.pointer + self.offset)
        decay = math.exp(-FREQUENCY * dt)
        # Where a critically damped spring would have it after the frame.
        later = (off + (speed - half + FREQUENCY * off) * dt) * decay
        wanted = (later - off) / dt - half
        fast = float(np.linalg.norm(wanted))
        if fast > FASTEST:
            wanted *= FASTEST / fast
        simulator.set_velocity(self.name, wanted, spin * decay)

"""Objects dragged by the pointer: a critically damped pull that sets their velocity."""

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

#: Natural frequency of the pull [1/s]: an object reaches a still pointer to 2 % within 0.3 s.
FREQUENCY = 20.0
#: Largest speed of a pulled object [m/s]: faster than a hand throws a ball across a room.
FASTEST = 12.0


def draggable(simulator: Simulator, name: str) -> bool:
    """Whether the pointer can pull this object: it is free and not held."""
    item = simulator.world.made_of.objects.get(name)
    return item is not None and not isinstance(item, KinematicObject) and name not in simulator.held


@dataclass
class Drag:
    """An object dragged by a pointer.

    The object's origin keeps its offset from the pointer. Its angular velocity decays. A released
    object keeps its velocity.

    Attributes:
        name: Name of the object.
        pointer: World position of the pointer (3,) [m].
        offset: From the pointer to the object's origin at the start of the drag (3,) [m].
    """

    name: str
    pointer: Array
    offset: Array = field(default_factory=lambda: np.zeros(3))

    @staticmethod
    def begin(simulator: Simulator, name: str, at: object, pointer: object) -> Drag:
        """Start to drag an object.

        Args:
            simulator: The simulator of the object.
            name: Name of a free object.
            at: The grabbed point of the object, in the world (3,) [m].
            pointer: Present position of the pointer (3,) [m].

        Raises:
            InputError: An object that cannot be pulled, or an invalid vector.
        """
        if not draggable(simulator, name):
            raise InputError(f"drag: found {name!r}, expected an object that moves freely")
        grip = vector(at, "drag: the point that is taken", unit="m")
        place = next(p for p in simulator.world.objects if p.name == name)
        origin, _ = place.pose(simulator.world.stepper.qpos())
        return Drag(name, np.array(vector(pointer, "drag: pointer", unit="m")), origin - grip)

    def follow(self, pointer: object) -> None:
        """Set the position of the pointer.

        Raises:
            InputError: An invalid vector.
        """
        self.pointer = np.array(vector(pointer, "drag: pointer", unit="m"))

    def pull(self, simulator: Simulator, dt: float) -> None:
        """Set the object's velocity for the next frame, `dt` [s] long.

        This is the initial velocity of the frame: contacts still stop the object.
        """
        place = next(p for p in simulator.world.objects if p.name == self.name)
        origin, _ = place.pose(simulator.world.stepper.qpos())
        speed, spin = simulator.velocity(self.name)
        # Gravity adds to the velocity during a frame; half of that is the mean error in velocity.
        half = 0.5 * dt * simulator.world.made_of.gravity
        off = origin - (self.pointer + self.offset)
        decay = math.exp(-FREQUENCY * dt)
        # Offset that a critically damped spring would leave after the frame.
        later = (off + (speed - half + FREQUENCY * off) * dt) * decay
        wanted = (later - off) / dt - half
        fast = float(np.linalg.norm(wanted))
        if fast > FASTEST:
            wanted *= FASTEST / fast
        simulator.set_velocity(self.name, wanted, spin * decay)

"""What clients may bring into a scene and do to its objects: sizes, masses, places, speeds.

A live session keeps its rate for everybody. Objects that are far away, huge or as heavy as a house
cost accuracy, objects inside each other cost time, so they are refused before anything changes.
The scene that the session is started with is not bounded: whoever starts it chooses it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from halfphysics.base.validation import number
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Sphere
from halfphysics.simulation.world import World

#: Most objects in a scene that clients add to, and most of them that are clients'. What they cost
#: depends on how they lie: 40 boxes take 14 ms a step as a wall, 20 ms as a pile, 140 ms as one
#: tower; 100 take 290 ms as a wall, 550 ms as a tower.
MOST_OBJECTS, MOST_ADDED = 200, 40
#: Extents of an object [m]: smaller than 1 mm is less than the clearance between bodies; 20 m is a
#: house.
LEAST_SIZE, MOST_SIZE = 0.001, 20.0
#: Mass of an object [kg]: a coin and a lorry; ratios beyond that cost the contact solver accuracy.
LEAST_MASS, MOST_MASS = 0.001, 10_000.0
#: Coordinates of objects and of the pointer that drags them [m]: people are there.
MOST_DISTANCE = 100.0
#: Speed of an object [m/s] and its spin [rad/s]: no ball is faster, no drill turns faster.
MOST_SPEED, MOST_SPIN = 100.0, 1000.0
#: Impulse [N s]: the heaviest object at the highest speed.
MOST_IMPULSE = MOST_MASS * MOST_SPEED
#: Coefficient of friction: rubber on rubber has 1 to 2.
MOST_FRICTION = 10.0
#: An object may start this deep inside another item [m]: a box put on a floor is not refused for a
#: rounded number.
OVERLAP = 0.002

#: What `hello` tells clients.
LIMITS = {
    "objects": float(MOST_OBJECTS),
    "objects_added": float(MOST_ADDED),
    "object_least_size": LEAST_SIZE,
    "object_size": MOST_SIZE,
    "object_least_mass": LEAST_MASS,
    "object_mass": MOST_MASS,
    "object_position": MOST_DISTANCE,
    "object_speed": MOST_SPEED,
    "object_spin": MOST_SPIN,
    "friction": MOST_FRICTION,
}


def check_size(shape: Any) -> None:
    """Refuse a sphere, box, capsule or cylinder with an extent out of bounds.

    Raises:
        InputError: It is too small or too large.
    """
    for extent in _extents(shape):
        number(extent, "add: extent of the shape", least=LEAST_SIZE, most=MOST_SIZE, unit="m")


def check_mass(mass: float, what: str) -> None:
    """Refuse a mass [kg] out of bounds; InputError names `what`."""
    number(mass, what, least=LEAST_MASS, most=MOST_MASS, unit="kg")


def check_friction(friction: float, what: str) -> None:
    """Refuse a coefficient of friction out of bounds; InputError names `what`."""
    number(friction, what, least=0.0, most=MOST_FRICTION)


def check_place(place: Sequence[float], what: str) -> None:
    """Refuse a position (3,) [m] that is far away; InputError names `what`."""
    for x in place:
        number(x, what, least=-MOST_DISTANCE, most=MOST_DISTANCE, unit="m")


def check_speed(velocity: ArrayLike, what: str) -> None:
    """Refuse a velocity (3,) [m/s] that is too fast; InputError names `what`."""
    _check_length(velocity, MOST_SPEED, what, "m/s")


def check_spin(spin: ArrayLike, what: str) -> None:
    """Refuse an angular velocity (3,) [rad/s] that is too fast; InputError names `what`."""
    _check_length(spin, MOST_SPIN, what, "rad/s")


def check_impulse(impulse: ArrayLike) -> None:
    """Refuse an impulse (3,) [N s] that moves nothing at a speed in bounds, with InputError."""
    _check_length(impulse, MOST_IMPULSE, "impulse", "N s")


def check_clear(world: World, name: str) -> None:
    """Refuse an object that overlaps an item or a person of its world by more than `OVERLAP`.

    Objects inside each other are pushed apart in many small steps: 60 boxes in one place take a
    second a step.

    Raises:
        InputError: It overlaps something.
    """
    index = world.names.index(name)
    own = np.flatnonzero(world.shape_name == index)
    others = np.flatnonzero(world.shape_name != index)
    pairs = np.stack([np.repeat(own, len(others)), np.tile(others, len(own))], axis=1)
    gaps = world.stepper.pair_gaps(world.stepper.qpos(), pairs.astype(np.float64))
    met = {
        world.names[world.shape_name[pair[1]]]
        for pair, gap in zip(pairs, gaps, strict=True)
        if gap < -OVERLAP
    }
    for shape, static, _, depth in world.stepper.inside():
        # A depth of 0: no way out was found.
        deep = depth == 0.0 or depth > OVERLAP
        if deep and static >= 0 and world.shape_name[int(shape)] == index:
            met.add(world.names[world.static_name[int(static)]])
    if met:
        raise InputError(
            f"add: found {name!r} inside {', '.join(sorted(met))}, expected a place where it "
            "overlaps nothing. Add it somewhere else"
        )


def _check_length(vector: ArrayLike, most: float, what: str, unit: str) -> None:
    with np.errstate(over="ignore", invalid="ignore"):
        number(float(np.linalg.norm(vector)), what, least=0.0, most=most, unit=unit)


def _extents(shape: Any) -> tuple[float, ...]:
    """Of a sphere, box, capsule or cylinder, along its own axes [m]."""
    if isinstance(shape, Box):
        return tuple(float(x) for x in shape.size)
    across = 2.0 * float(shape.radius)
    if isinstance(shape, Sphere):
        return (across,)
    ends = across if isinstance(shape, Capsule) else 0.0
    return (across, float(shape.length) + ends)

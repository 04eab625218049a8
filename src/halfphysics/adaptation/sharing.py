"""Several people who carry one thing: each hand bears its part of the load.

Alone, two palms must press against each other to bear by friction. With hands of others on the
thing that is neither needed nor, at the end of a table, possible. What the hands press with
together solves

    minimise |G c - w|^2 + eps |c|^2,   c >= 0

w is the load (weight and recorded acceleration) with its torque about the centre of mass, 0. A
column of G is what one edge of a hand's cone of friction does: a force along the edge, at the
hand's place (Kerr and Roth 1986, with edges for the cone). Cones are narrower than friction allows
by a margin, so hands that only bear from below press upwards, and hands at sides press against
each other by as much as their share of the load needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation import loads
from halfphysics.adaptation.grips import Place, places
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import RecordedHold, recorded_holds

if TYPE_CHECKING:
    from halfphysics.adaptation.thing import Thing
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: Edges of a cone, and the weight of c against the load.
_EDGES, _EVEN = 12, 1e-4
#: Torques count as forces at this lever [m].
_LEVER = 0.3
#: Hands that leave more than this part of the load to nobody cannot bear it.
_LEFT = 0.1
#: A hand bears from below where its push is this near to the load's direction, as a cosine.
_BELOW = 0.7
#: Of a hold, others hold at least this part of the time, to bear with it.
_TOGETHER = 0.5


def others_places(
    others: Sequence[tuple[Motion, Body]], thing: Thing, hold: RecordedHold, friction: float
) -> tuple[Place, ...]:
    """Where the hands of other people are on a thing while it is held.

    Args:
        others: Their motions and bodies.
        thing: What is held.
        hold: The hold of the person who is adapted.
        friction: Of hands on the thing.
    """
    found: list[Place] = []
    for motion, body in others:
        hands = [hand for side in SIDES if (hand := Hand.of(body, side)) is not None]
        for theirs in recorded_holds(motion, body, hands, thing):
            common = min(hold.last, theirs.last) - max(hold.first, theirs.first) + 1
            if common > _TOGETHER * (hold.last - hold.first + 1):
                found += places(motion, body, theirs, friction)
    return tuple(found)


def shared(
    own: Sequence[Place], theirs: Sequence[Place], thing: Thing, load: Array, friction: float
) -> tuple[tuple[Place, ...], tuple[float, ...]] | None:
    """A person's own places with the directions in which they press, and the forces [N].

    Args:
        own: Of the person who is adapted.
        theirs: Of the others.
        thing: What they hold.
        load: What all hands bear together (3,) [N], in the thing's frame.
        friction: Of hands on the thing.

    None: these hands cannot bear the load.
    """
    from scipy.optimize import nnls

    every = [*own, *theirs]
    edges = np.concatenate(
        [_cone(-place.normal, friction / loads.MARGIN) for place in every], axis=1
    )
    points = np.repeat([place.point - thing.item.com for place in every], _EDGES, axis=0)
    torques = np.cross(points, edges.T).T / _LEVER
    size = float(np.linalg.norm(load))
    matrix = np.concatenate([edges, torques, _EVEN**0.5 * np.eye(edges.shape[1])])
    wanted = np.concatenate([load / max(size, 1e-9), np.zeros(3 + edges.shape[1])])
    shares, _ = nnls(matrix, wanted)
    if np.linalg.norm((matrix @ shares - wanted)[:6]) > _LEFT:
        return None
    forces = size * (edges * shares).reshape(3, len(every), _EDGES).sum(axis=2).T[: len(own)]
    sizes = np.linalg.norm(forces, axis=1)
    ways = forces / np.maximum(sizes, 1e-9)[:, None]
    return (
        tuple(replace(place, presses=way) for place, way in zip(own, ways, strict=True)),
        tuple(float(min(each, loads.MOST)) for each in sizes),
    )


def bears(place: Place, load: Array) -> bool:
    """Whether a hand bears a load (3,) from below, rather than by friction."""
    return bool(-place.normal @ load > _BELOW * np.linalg.norm(load))


def _cone(axis: Array, friction: float) -> Array:
    """Unit forces (3, `_EDGES`) along the edges of a cone of friction about an axis (3,)."""
    aside = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    aside /= np.linalg.norm(aside)
    other = np.cross(axis, aside)
    angle = 2.0 * np.pi * np.arange(_EDGES) / _EDGES
    around = np.outer(aside, np.cos(angle)) + np.outer(other, np.sin(angle))
    out = axis[:, None] + friction * around
    result: Array = out / np.linalg.norm(out, axis=0)
    return result

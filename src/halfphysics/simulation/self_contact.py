"""Which hulls of one person may touch each other."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS, PARENTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.simulation.world import Person, World

#: Parts whose joints are this few bones apart are neighbours: the skin between them bends.
NEIGHBOURS = 2
#: What is nearer than this at rest counts as overlapping there [m].
LEAST_REST_GAP = 2e-3
FINGERS = ("thumb", "index", "middle", "ring", "pinky")


def self_pairs(world: World, person: Person, name: int) -> NDArray[np.int64]:
    """Pairs (n, 2) of the core's shapes of one person that are kept from each other.

    Left out are parts within two joints of each other, those of one hand, and what overlaps in
    the rest pose. Hulls are convex, so that at the armpit upper arm and flank always do: parts of
    which any hulls of the skin overlap there are neighbours as a whole, with both kinds of contact.

    Args:
        world: With its people in the core.
        person: Whose.
        name: The person's index in the world's names.
    """
    mine = np.flatnonzero(world.mover_name == name)
    joint = world.mover_part[mine]
    i, j = np.triu_indices(len(mine), 1)
    may = _strangers(person.body)[joint[i], joint[j]]
    pairs = np.stack([mine[i[may]], mine[j[may]]], axis=1)
    return pairs[_rest_gaps(world, person, pairs) >= LEAST_REST_GAP]


_known: WeakKeyDictionary[Body, NDArray[np.bool_]] = WeakKeyDictionary()


def _strangers(body: Body) -> NDArray[np.bool_]:
    """Of any two joints (55, 55) of a body: may their parts touch?"""
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.world import World

    found = _known.get(body)
    if found is None:
        found = _far_apart().copy()
        world = World([body], Scene(), Settings(contact="skin"))
        joint = world.mover_part
        i, j = np.triu_indices(len(joint), 1)
        may = found[joint[i], joint[j]]
        i, j = i[may], j[may]
        gaps = _rest_gaps(world, world.people[0], np.stack([i, j], axis=1))
        near = gaps < LEAST_REST_GAP
        found[joint[i[near]], joint[j[near]]] = False
        found[joint[j[near]], joint[i[near]]] = False
        _known[body] = found
    return found


@cache
def _far_apart() -> NDArray[np.bool_]:
    """The same by the skeleton alone."""
    bones = np.full((N_JOINTS, N_JOINTS), N_JOINTS)
    np.fill_diagonal(bones, 0)
    for j in range(1, N_JOINTS):  # parents come first
        bones[j, :j] = bones[:j, j] = bones[PARENTS[j], :j] + 1
    apart = bones > NEIGHBOURS
    for side in ("left", "right"):
        starts = tuple(f"{side}_{what}" for what in ("wrist", *FINGERS))
        hand = [j for j, name in enumerate(JOINT_NAMES) if name.startswith(starts)]
        apart[np.ix_(hand, hand)] = False
    return apart


def _rest_gaps(world: World, person: Person, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
    """Distances (n,) of pairs of shapes (n, 2) in the rest pose, negative where they overlap."""
    rest = person.coordinates(np.zeros((1, 3)), np.zeros((1, N_JOINTS, 3)), np.eye(3))
    qpos = np.array(world.model.qpos0)
    qpos[person.qpos : person.qpos + person.count] = rest[0]
    gaps: NDArray[np.float64] = world.stepper.pair_gaps(qpos, pairs.astype(np.float64))
    return gaps

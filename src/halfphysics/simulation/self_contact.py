"""Self-contact: the pairs of shapes of one person that may touch each other."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS, PARENTS
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.compiled_model import model_arrays
from halfphysics.simulation.coordinates import Person
from halfphysics.simulation.joined_model import join_model
from halfphysics.simulation.person_shapes import add_person_shapes

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Ints = NDArray[np.int64]

#: Parts whose joints are this few bones apart are neighbours: the skin between them bends.
NEIGHBOURS = 2
#: Two shapes with a smaller gap than this at rest count as overlapping there [m].
LEAST_REST_GAP = 2e-3
FINGERS = ("thumb", "index", "middle", "ring", "pinky")
#: Who squats or bends folds: belly and thighs lie against each other and flesh gives. Rigid hulls
#: there would unfold the person: a recorded squat was thrown off its feet by half a metre.
FOLDS = ("spine1", "spine2", "spine3")


def set_self_pairs(core: Any, model: Any, people: Sequence[Person], shapes: Sequence[Ints]) -> None:
    """Give the core the pairs of all people.

    Args:
        core: With the shapes of the people in it.
        model: Its `mujoco.MjModel`.
        people: All people.
        shapes: Of each person the joint of every shape of the core (n,), -1 of others' shapes.
    """
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for person, joint in zip(people, shapes, strict=True):
        pairs.append(_self_pairs(core, model, person, joint))
    core.set_self_pairs(np.concatenate(pairs).astype(np.float64))


def _self_pairs(core: Any, model: Any, person: Person, joint: Ints) -> Ints:
    """Pairs (n, 2) of the core's shapes of one person that are kept from each other.

    Left out are parts within two joints of each other, those of one hand, trunk and thighs, and
    shapes that overlap in the rest pose. Hulls are convex, so that at the armpit upper arm and
    flank always do: parts of which any hulls of the skin overlap there are neighbours as a whole,
    with both kinds of contact.
    """
    may = _may_touch(person.body)
    own = np.flatnonzero(joint >= 0)
    i, j = (own[k] for k in np.triu_indices(len(own), 1))
    may_touch = may[joint[i], joint[j]]
    pairs = np.stack([i[may_touch], j[may_touch]], axis=1)
    return pairs[_rest_gaps(core, model, person, pairs) >= LEAST_REST_GAP]


_known: WeakKeyDictionary[Body, NDArray[np.bool_]] = WeakKeyDictionary()


def _may_touch(body: Body) -> NDArray[np.bool_]:
    """Of any two joints (55, 55) of a body: whether their parts may touch."""
    found = _known.get(body)
    if found is None:
        found = _far_apart().copy()
        core, model, person, joint = _alone(body)
        i, j = np.triu_indices(len(joint), 1)
        may = found[joint[i], joint[j]]
        i, j = i[may], j[may]
        near = _rest_gaps(core, model, person, np.stack([i, j], axis=1)) < LEAST_REST_GAP
        found[joint[i[near]], joint[j[near]]] = False
        found[joint[j[near]], joint[i[near]]] = False
        _known[body] = found
    return found


def _alone(body: Body) -> tuple[Any, Any, Person, Ints]:
    """A core with the skin of one person alone, its model, the person, and each shape's joint."""
    from halfphysics import _native

    model = join_model([body], ["person"], Scene(), {}, np.zeros(N_JOINTS))
    person = Person.of(model, "person/", "person", body)
    core = _native.Stepper()
    core.set_model(**model_arrays(model))
    joint = add_person_shapes(
        core, model, body, Settings(contact="skin"), prefix="person/", index=0, row=lambda _: 0
    )
    core.set_pairings(*np.zeros((3, 1, 1)))
    core.finish([person.root])
    return core, model, person, np.array(joint, dtype=np.int64)


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
        trunk, thigh = [JOINT_NAMES.index(name) for name in FOLDS], JOINT_NAMES.index(f"{side}_hip")
        apart[trunk, thigh] = apart[thigh, trunk] = False
    return apart


def _rest_gaps(core: Any, model: Any, person: Person, pairs: Ints) -> NDArray[np.float64]:
    """Distances (n,) of pairs of shapes (n, 2) in the rest pose, negative where they overlap."""
    rest = person.coordinates(np.zeros((1, 3)), np.zeros((1, N_JOINTS, 3)), np.eye(3))
    qpos = np.array(model.qpos0)
    qpos[person.qpos : person.qpos + person.count] = rest[0]
    gaps: NDArray[np.float64] = core.pair_gaps(qpos, pairs.astype(np.float64))
    return gaps

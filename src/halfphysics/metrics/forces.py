"""Plausibility of contact forces: no pull, friction inside its cone, objects' momentum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.base.copying import FrozenMapping
from halfphysics.base.short_repr import short_repr
from halfphysics.metrics.argument_checks import Array, check_result
from halfphysics.metrics.scene_solids import known_contacts, links_of
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.material_pairs import PERSON
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.results.contacts import Contacts
    from halfphysics.results.result import Result
    from halfphysics.scene.items import Object
    from halfphysics.scene.scene import Scene

#: Tolerances of comparisons of impulses: as a fraction of their size, and absolute [N s].
TOLERANCE, LEAST = 1e-6, 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceReport:
    """Plausibility of a result's contact impulses.

    Attributes:
        contacts: Number of labelled contacts that carry an impulse.
        push_percent: Share of them whose impulse pushes along the contact's normal [%]; 100 where
            there are none.
        cone_percent: Share of them whose impulse is in the friction cone [%]; likewise.
        pull: Largest impulse against the normal [N s].
        slip: Largest tangential impulse beyond the limit of friction [N s].
        balance: Object -> residual of its momentum balance of every frame (T,) [N s], 0 in frame 0
            and while it is asleep. Empty unless the result has every substep
            (``Settings(record="substeps")``).
        unbalanced: Largest of those residuals [N s]; nan if there are none.
    """

    contacts: int
    push_percent: float
    cone_percent: float
    pull: float
    slip: float
    balance: Mapping[str, Array]
    unbalanced: float

    __repr__ = short_repr


def contact_forces(result: Result) -> ForceReport:
    """Check the contact impulses of a result.

    A contact's impulse p, of all points of a pair in a frame, is split along the contact's normal
    n into p_n = p . n and the rest p_t. It pushes if p_n >= 0, and is in its cone if
    |p_t| <= mu p_n, mu being the pair's friction (`Scene.friction_of`); both to a millionth of
    |p|. Pairs with an item that a result's file could not keep, whose friction is not known, are
    left out. If a pair touches in several planes, a sum of impulses that are each in their own cone
    can be outside the cone of the mean normal.

    Each object's momentum m v changes in a frame by the impulses on it and by gravity:
    r_t = m (v_t - v_{t-1}) - sum of impulses - m g dt should be 0; |r_t| is reported. v is the
    velocity of the centre of mass in the frame's last substep, from its last two positions: exact
    if no step was shortened (`Result.lost_time`) or divided.

    Raises:
        InputError: No result.
        FileError: In a result from a file: the scene has gone.
    """
    check_result(result)
    contacts, scene = result.contacts, result.scene
    contacts = contacts[(contacts.strength > 0.0) & known_contacts(result)]
    along = np.einsum("ni,ni->n", contacts.impulse, contacts.normal)
    across = np.linalg.norm(contacts.impulse - along[:, None] * contacts.normal, axis=1)
    beyond = across - _friction(result, contacts) * np.maximum(along, 0.0)
    room = TOLERANCE * contacts.strength + LEAST
    balance = _balance(result, scene)

    def percent(good: Array) -> float:
        return float(100.0 * good.mean()) if len(good) else 100.0

    def largest(values: Array) -> float:
        return float(np.maximum(values, 0.0).max()) if len(values) else 0.0

    return ForceReport(
        contacts=len(contacts),
        push_percent=percent(along >= -room),
        cone_percent=percent((beyond <= room) & (along >= -room)),
        pull=largest(-along),
        slip=largest(beyond),
        balance=FrozenMapping(balance),
        unbalanced=max((float(r.max()) for r in balance.values()), default=float("nan")),
    )


def _friction(result: Result, contacts: Contacts) -> Array:
    """Coefficient of friction (n,) of every contact's pair."""
    scene, first_person = result.scene, len(result.names) - len(result.people)
    owner = {name: whole for name, (whole, _) in links_of(scene).items()}

    def name(index: int, part: int) -> str:
        if part >= 0:
            return f"{PERSON}/{JOINT_NAMES[part]}"
        known = result.names[index]
        return PERSON if index >= first_person else owner.get(known, known)

    columns = (contacts.subject, contacts.part, contacts.other, contacts.other_part)
    keys, place = np.unique(np.stack(columns), axis=1, return_inverse=True)
    values = [scene.friction_of(name(s, p), name(o, q)) for s, p, o, q in keys.T.tolist()]
    return np.array(values, dtype=np.float64)[place.reshape(-1)]


def _balance(result: Result, scene: Scene) -> dict[str, Array]:
    """Size of the residual of the momentum balance (T,) of every free object."""
    if result.substeps is None:
        return {}
    dt = 1.0 / result.fps
    count = result.settings.substeps_for(dt)
    balance = {}
    for name, track in result.substeps.objects.items():
        item = scene.objects.get(name)
        if item is None or isinstance(item, KinematicObject):  # a link or a kinematic object
            continue
        turn = rot.normalize(track.quaternion)
        centre = track.position + rot.rotate(turn, np.broadcast_to(item.com, track.position.shape))
        speed = np.diff(centre, axis=0)[count - 1 :: count] * (count / dt)
        arm = rot.rotate(turn[0], np.asarray(item.com, dtype=np.float64))
        start = item.velocity + np.cross(item.angular_velocity, arm)
        gained = item.mass * np.diff(np.concatenate([start[None], speed]), axis=0)
        missing = gained - _received(result, name)[1:] - item.mass * dt * scene.gravity
        missing[: _asleep(item, centre[::count])] = 0.0
        balance[name] = np.concatenate([[0.0], np.linalg.norm(missing, axis=1)])
        balance[name].setflags(write=False)
    return balance


def _received(result: Result, name: str) -> Array:
    """Sum of the contact impulses on an object in every frame (T, 3) [N s]."""
    contacts, index = result.contacts, result.names.index(name)
    total = np.zeros((len(result), 3))
    for column, sign in ((contacts.subject, 1.0), (contacts.other, -1.0)):
        rows = column == index
        np.add.at(total, contacts.frame[rows], sign * contacts.impulse[rows])
    return total


def _asleep(item: Object, centre: Array) -> int:
    """Number of frames in which an object that starts asleep is held in place; centre (T, 3)."""
    if item.start != "asleep":
        return 0
    moved = (centre != centre[0]).any(axis=1)
    return int(moved.argmax()) if moved.any() else len(centre) - 1

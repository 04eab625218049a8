"""Contacts of people in the rest poses of their bodies, for the colours of the skin by force.

A contact is carried from the pose of its frame to the rest pose as if fixed to its part. There,
hands are away from the trunk and the legs from each other: the distance of a vertex from the
contact is nearly that along the skin, and a knee's contact does not colour the other knee. The
browser computes the colours (player/skin.js).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.results.skin_pressure import checked_vertices

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.results.result import Result

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Weaker contacts leave the skin as it is [N].
LEAST = 1.0
#: Pressures of soft things are summed over cubes of this side [m].
CUBE = 0.04


def at_rest(body: Body, part: Ints, position: Array, joints: Array, quaternions: Array) -> Array:
    """Points (n, 3) [m] fixed to parts of a posed body, where they are in its rest pose.

    Args:
        body: The body.
        part: Indices of the parts (n,).
        position: The points in the world (n, 3) [m].
        joints, quaternions: World frames of these parts in the pose (n, 3) [m] and (n, 4) wxyz.
    """
    local = rot.rotate(rot.conjugate(quaternions), position - joints)
    result: Array = np.asarray(body.rest_joints)[part] + local
    return result


def skin_document(result: Result, frames: Sequence[int]) -> dict[str, Any]:
    """The contacts on people's skin as the browser reads them.

    Args:
        result: The result.
        frames: The frames that are shown, in order.

    Returns:
        `first`: rows of the shown frame k are `first[k]` to `first[k + 1]`; `person`; `place`,
        three millimetres each in the rest pose; `force`, tenths of a newton; `fps` of the shown
        frames.
    """
    contacts = result.contacts
    force = np.linalg.norm(np.asarray(contacts.impulse), axis=1) * result.fps
    person, frame = np.asarray(contacts.person), np.asarray(contacts.frame)
    shown = np.full(len(result.motion), -1)
    shown[list(frames)] = np.arange(len(frames))
    wanted = (person >= 0) & (force >= LEAST) & (shown[frame] >= 0)
    pressed = soft_points(result)
    if pressed is not None:  # these know better where it presses than the sum of a part
        wanted &= ~np.isin(_pair(frame, person, np.asarray(contacts.other)), pressed.pairs)
    rows = np.flatnonzero(wanted)
    place = np.zeros((len(rows), 3))
    for index, someone in enumerate(result.people):
        mine = person[rows] == index
        if not mine.any():
            continue
        at, part = frame[rows][mine], np.asarray(contacts.part)[rows][mine]
        joints, turns = someone.body.joint_frames(someone.motion)
        position = np.asarray(contacts.position, dtype=np.float64)[rows][mine]
        place[mine] = at_rest(someone.body, part, position, joints[at, part], turns[at, part])
    frame, person, force = frame[rows], person[rows], force[rows]
    if pressed is not None:
        some = (shown[pressed.frame] >= 0) & (pressed.force >= LEAST)
        frame = np.concatenate([frame, pressed.frame[some]])
        person = np.concatenate([person, pressed.person[some]])
        place = np.concatenate([place, pressed.place[some]])
        force = np.concatenate([force, pressed.force[some]])
        order = np.argsort(frame, kind="stable")
        frame, person, place, force = frame[order], person[order], place[order], force[order]
    step = frames[1] - frames[0] if len(frames) > 1 else 1
    return {
        "first": np.searchsorted(shown[frame], np.arange(len(frames) + 1)).tolist(),
        "person": person.tolist(),
        "place": np.round(1e3 * place).astype(int).reshape(-1).tolist(),
        "force": np.round(10.0 * force).astype(int).tolist(),
        "fps": result.fps / step,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class SoftPoints:
    """Pressures on people's skins, summed over cubes of the rest pose.

    Attributes:
        frame, person: Of each sum (n,).
        place: The mean by force, in the rest pose (n, 3) [m].
        force: Sum of the forces (n,) [N].
        pairs: Frame, person and other of what is in it, as `_pair` has them.
    """

    frame: Ints
    person: Ints
    place: Array
    force: Array
    pairs: Ints


def soft_points(result: Result) -> SoftPoints | None:
    """What presses on people's skins from soft things; None: nothing.

    Raises:
        InputError: A body has fewer vertices than what presses it.
    """
    contacts = getattr(result, "soft_contacts", None)
    if contacts is None:
        return None
    first = len(result.names) - len(result.people)
    mine = contacts[(contacts.other >= first) & (contacts.vertex >= 0)]
    if not len(mine):
        return None
    person, force = mine.other - first, mine.pressure * mine.area
    place = np.zeros((len(mine), 3))
    for index, someone in enumerate(result.people):
        rows = person == index
        vertex = checked_vertices(result, index, mine.vertex[rows])
        place[rows] = np.asarray(someone.body.rest_vertices)[vertex]
    key = np.column_stack([mine.frame, person, np.floor(place / CUBE).astype(np.int64)])
    cubes, own = np.unique(key, axis=0, return_inverse=True)
    own = own.reshape(-1)
    total = np.bincount(own, force, len(cubes)).astype(np.float64)
    sums = [np.bincount(own, force * column, len(cubes)) for column in place.T]
    return SoftPoints(
        frame=cubes[:, 0],
        person=cubes[:, 1],
        place=np.stack(sums, axis=1) / np.maximum(total, 1e-12)[:, None],
        force=total,
        pairs=np.unique(_pair(mine.frame, person, mine.layer)),
    )


def _pair(frame: Ints, person: Ints, other: Ints) -> Ints:
    """One number for a frame, a person and what touches it, each (n,)."""
    return (frame * 4096 + person) * 65536 + other


def live_points(
    body: Body, part: Ints, position: Array, force: Array, joints: Array, quaternions: Array
) -> list[list[float]]:
    """Contacts of one person in one frame, [x, y, z, force] each, in the rest pose [m], [N].

    Args:
        body: Their body.
        part, position, force: Of each contact: the part (n,), world position (n, 3) [m], size of
            its force (n,) [N].
        joints, quaternions: World frames of all joints (55, 3) [m] and (55, 4) wxyz.
    """
    strong = force >= LEAST
    part = part[strong]
    place = at_rest(body, part, position[strong], joints[part], quaternions[part])
    return np.round(np.column_stack([place, force[strong]]), 3).tolist()  # type: ignore[no-any-return]

"""Slips: parts of a person that bear load of an object and move along its surface."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.labels.event_kinds import Limits, Slip
from halfphysics.labels.loads import Loads, bears, frames_in, intervals, lasts, summed
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.result import PersonResult

Array = NDArray[np.float64]
Frames = NDArray[np.int64]


def slips_of(loads: Loads, limits: Limits) -> Iterator[Slip]:
    """Every slip of an object, person by person."""
    result, contacts = loads.result, loads.result.contacts
    for index, person in enumerate(result.people):
        own = contacts.person[loads.rows] == index
        # Frame 0 ends no step.
        own &= contacts.frame[loads.rows] > 0
        rows, share = loads.rows[own], loads.share[own]
        frame = contacts.frame[rows]
        total = summed(frame, share, len(result))
        most = np.zeros(len(result))
        np.maximum.at(most, frame, share)
        carry = bears(share, total[frame], most[frame], limits.load)
        carry &= total[frame] >= limits.load
        rows, share, frame = rows[carry], share[carry], frame[carry]
        # A kick is shorter than any slip.
        if not len(rows) or not lasts(int(frame[0]), int(frame[-1]), limits.slide_time, result.fps):
            continue
        step = _steps(loads, person, rows)
        slides = step * result.fps >= limits.slide_speed
        lift = loads.lifted(index)
        yield from _grouped(
            loads, limits, person.name, rows[slides], share[slides], step[slides], lift
        )


def _steps(loads: Loads, person: PersonResult, rows: Frames) -> Array:
    """Distances (k,) [m] by which the parts of contacts move along the object's surface in a frame.

    The displacement of the part's material point at the contact in the object's frame, without its
    normal component: zero for a part that rolls without slipping.
    """
    contacts, track = loads.result.contacts, loads.result.objects[loads.item.name]
    first = int(contacts.frame[rows].min()) - 1
    after = int(contacts.frame[rows].max()) + 1
    places, turns = person.body.joint_frames(person.motion[first:after])
    now, part = contacts.frame[rows] - first, contacts.part[rows]
    positions = track.position[first:after]
    quaternions = rot.normalize(track.quaternion[first:after])

    def seen(frame: Frames, point: Array) -> Array:
        return rot.rotate(rot.conjugate(quaternions[frame]), point - positions[frame])

    here = contacts.position[rows]
    own = rot.rotate(rot.conjugate(turns[now, part]), here - places[now, part])
    before = places[now - 1, part] + rot.rotate(turns[now - 1, part], own)
    moved = rot.rotate(quaternions[now], seen(now, here) - seen(now - 1, before))
    normal = contacts.normal[rows]
    along = moved - np.einsum("ni,ni->n", moved, normal)[:, None] * normal
    result: Array = np.linalg.norm(along, axis=1)
    return result


def _grouped(
    loads: Loads,
    limits: Limits,
    person: str,
    rows: Frames,
    share: Array,
    step: Array,
    lift: Array,
) -> Iterator[Slip]:
    """Slips of a person from the rows (k,) that slide.

    Args:
        loads, limits: The loads on the object and the thresholds.
        person: Name.
        rows, share, step: Rows of the contacts, shares of the weight and distances slid [m].
        lift: Share of the weight that the person bears in every frame (T,).
    """
    result = loads.result
    frame = result.contacts.frame[rows]
    force = summed(frame, share, len(result))
    # Without gravity every share is infinite: then all contacts count equally.
    weight = np.where(np.isfinite(share), share / force[frame], 1.0)
    sums = summed(frame, weight, len(result))
    way = summed(frame, weight * step, len(result))
    way = np.divide(way, sums, out=np.zeros(len(result)), where=sums > 0.0)
    for first, last in intervals(way > 0.0, frames_in(limits.gap, result.fps)):
        distance = float(way[first : last + 1].sum())
        long = lasts(first, last, limits.slide_time, result.fps)
        bears = float(lift[first : last + 1].mean()) >= limits.slide_load
        if not (long and bears) or distance < limits.slide:
            continue
        within = (frame >= first) & (frame <= last)
        yield Slip(
            object=loads.item.name,
            person=person,
            parts=tuple(
                JOINT_NAMES[p] for p in np.unique(result.contacts.part[rows[within]]).tolist()
            ),
            first=first,
            last=last,
            start=(first - 1) / result.fps,
            end=last / result.fps,
            distance=distance,
            speed=float(way[first : last + 1].max() * result.fps),
        )

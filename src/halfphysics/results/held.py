"""What became of the holds of an adapted motion: forces, friction, the thing against its record.

A hand holds where its contacts bear. With p the impulse on a hand in a frame and n the normal into
it (`Contacts`), it presses with sum(p n) and bears sum(|p - (p n) n|) by friction, both over the
length of the frame; friction of mu could bear mu times the first. Frames are those in which the
person's clock is within the hold, so that who waited is judged when they hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.short_repr import short_repr
from halfphysics.errors import InputError
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS, PARENTS
from halfphysics.scene.material_pairs import PERSON

if TYPE_CHECKING:
    from halfphysics.results.result import Result

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: A thing is let go where nothing that should hold it touches it for so long [s].
LET_GO = 0.2
#: Friction that is borne by less than this counts as this [N]: no margin is infinite.
_LEAST = 1e-9


@dataclass(frozen=True, kw_only=True)
class HeldReport:
    """One hand of one hold (`Result.holds`); what concerns the thing is equal for all its hands.

    What is said of hands holds for every part that a hold has: feet, a seat.

    Attributes:
        object: Name of the thing.
        person: Name of the person.
        part: The joint that stands for it: a wrist for hand and fingers, an ankle for a foot, the
            pelvis for a seat.
        start, end: When it was to hold [s].
        asked: The force that it was to press with [N]; 0: fingers hold, or it bears from below.
        reached: The sum of its normal forces, the median over the hold [N].
        margin: Largest friction that its contacts could bear over what they bore, the median of the
            frames in which it touched; above 1: nothing slips, 0: it did not touch, nan: the
            scene of a result file has lost the thing's mesh.
        touched: Share of the frames in which it touched the thing.
        rise, recorded_rise: How high the thing was lifted during the hold, and in its record [m].
        away: Largest distance of the thing from its record during the hold [m].
        turned_deg: Largest angle from its record during the hold [deg].
        end_away: Distance from its record in the last frame of the clip [m].
        lost: From when on none of the hold's hands touched the thing until the end of the hold [s]
            (the start where none ever did); None: held to the end, to 0.2 s.
        late: How long after the end of the hold one of its hands still touched the thing, until
            none did for 0.2 s [s].
    """

    object: str
    person: str
    part: str
    start: float
    end: float
    asked: float
    reached: float
    margin: float
    touched: float
    rise: float
    recorded_rise: float
    away: float
    turned_deg: float
    end_away: float
    lost: float | None
    late: float

    __repr__ = short_repr


def held(result: Result) -> tuple[HeldReport, ...]:
    """The work behind `Result.holds`: one entry a hand, by person, hold and hand."""
    return tuple(
        report
        for index, person in enumerate(result.people)
        for hold in person.reference.holds
        if hold.object in result.objects
        for report in _reports(result, index, hold)
    )


def _reports(result: Result, index: int, hold: AdaptedHold) -> list[HeldReport]:
    """All hands of one hold."""
    person = result.people[index]
    position = np.clip(np.asarray(person.clock) * result.fps, 0.0, len(result) - 1.0)
    during = hold.during(position)
    if len(during):
        start, end = float(during[0] / result.fps), float(during[-1] / result.fps)
    else:  # who waits for ever never comes to hold it
        start, end = hold.first / result.fps, hold.last / result.fps
    whole = [_forces(result, index, hold.object, part) for part in hold.parts]
    forces = [each[:, during] for each in whole]
    touched = [pressed > 0.0 for pressed, _ in forces]
    thing = _thing(result, hold, position, during)
    lost = _lost(np.logical_or.reduce(touched), during, result.fps, start)
    late = _late(np.logical_or.reduce([pressed > 0.0 for pressed, _ in whole]), during, result.fps)
    return [
        HeldReport(
            object=hold.object,
            person=person.name,
            part=part,
            start=start,
            end=end,
            asked=hold.force,
            reached=float(np.median(pressed)) if len(during) else 0.0,
            margin=_friction(result, part, hold.object)
            * float(np.median(pressed[on] / np.maximum(rubbed[on], _LEAST)))
            if on.any()
            else 0.0,
            touched=float(on.mean()) if len(during) else 0.0,
            lost=lost,
            late=late,
            **thing,
        )
        for part, (pressed, rubbed), on in zip(hold.parts, forces, touched, strict=True)
    ]


def _forces(result: Result, index: int, thing: str, part: str) -> Array:
    """Normal force of a thing on a part and friction between them in every frame (2, T) [N]."""
    c = result.contacts
    own = (c.person == index) & (c.other == result.names.index(thing))
    own &= np.isin(c.part, joints_of(part))
    impulse, normal = c.impulse[own], c.normal[own]
    along = np.einsum("ij,ij->i", impulse, normal)
    across = np.linalg.norm(impulse - along[:, None] * normal, axis=1)
    frames = len(result)
    sums = [np.bincount(c.frame[own], each, minlength=frames) for each in (along, across)]
    return np.array(sums, dtype=np.float64) * result.fps


def _friction(result: Result, part: str, thing: str) -> float:
    """Friction between a part and a thing; nan where the scene has lost the thing."""
    try:
        return result.scene.friction_of(f"{PERSON}/{part}", thing)
    except InputError:
        return float("nan")


def joints_of(part: str) -> NDArray[np.int64]:
    """The joints that a part of a hold stands for: it and all beyond; of the pelvis, the seat."""
    root = JOINT_INDEX[part]
    if root == 0:
        return np.array([0, JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]])
    beyond = np.zeros(N_JOINTS, dtype=bool)
    beyond[root] = True
    for joint in range(root + 1, N_JOINTS):  # parents precede children
        beyond[joint] = beyond[PARENTS[joint]]
    return np.flatnonzero(beyond)


def _thing(
    result: Result, hold: AdaptedHold, position: Array, during: NDArray[np.intp]
) -> dict[str, float]:
    """The fields of a report about the thing against its record."""
    track = result.objects[hold.object]
    place, turn = hold.poses(position)
    apart = np.linalg.norm(track.position - place, axis=1)
    turned = np.linalg.norm(
        rot.log(rot.multiply(rot.conjugate(turn), rot.normalize(track.quaternion))), axis=1
    )

    def rise(height: Array) -> float:
        return float(height[during].max() - height[during[0]]) if len(during) else 0.0

    return {
        "rise": rise(track.position[:, 2]),
        "recorded_rise": rise(place[:, 2]),
        "away": float(apart[during].max(initial=0.0)),
        "turned_deg": float(np.rad2deg(turned[during].max(initial=0.0))),
        "end_away": float(apart[-1]),
    }


def _lost(touched: Mask, during: NDArray[np.intp], fps: float, start: float) -> float | None:
    """When a thing left all hands for the rest of a hold [s]; None: it did not."""
    if not touched.any():
        return start
    last = int(np.flatnonzero(touched)[-1])
    if (len(touched) - 1 - last) / fps <= LET_GO:
        return None
    return float(during[last + 1] / fps)


def _late(touched: Mask, during: NDArray[np.intp], fps: float) -> float:
    """How long a thing is still touched after a hold [s], by touches in all frames (T,)."""
    if not len(during):
        return 0.0
    after = np.flatnonzero(touched[during[-1] + 1 :]) + 1
    # The touches that go on from the hold, without a pause of LET_GO.
    joined = np.diff(after, prepend=0) <= LET_GO * fps
    count = len(after) if joined.all() else int(np.argmin(joined))
    return float(after[count - 1] / fps) if count else 0.0

"""What is known to act on a person: contact impulses of things that move, and of other people.

Impulses of static geometry, of kinematic objects and of fixed links are not among them: they are
what their surfaces exert to stop a part, and the support of those surfaces is all that they
exert. Counted here as well, they would count twice. Soft layers are: their pressures hold a person
up as its weight has it (docs/physics.md, "Weight").
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.support.differentiation import low_pass, segments

if TYPE_CHECKING:
    from halfphysics.results.contacts import Contacts
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: A filter leaves traces of a force, of either sign, long before and after it. They have no centre
#: of pressure: under this share of the largest, nor farther from a touch than half a period of the
#: cut-off.
FAINT = 0.01


def soft_things(scene: Scene) -> set[str]:
    """Names of statics and objects that have a soft layer."""
    things = {**scene.statics, **scene.objects}
    return {name for name, thing in things.items() if getattr(thing, "soft", None) is not None}


def givers_of(scene: Scene, names: tuple[str, ...], me: int) -> list[int]:
    """Indices into `names` of what acts on the person `me`, one of them, by known impulses."""
    fixed = {*scene.statics}
    fixed |= {name for name, item in scene.objects.items() if isinstance(item, KinematicObject)}
    for item in scene.articulated.values():
        links = zip(item.link_names, item.links, strict=True)
        fixed |= {name for name, link in links if link.fixed}
    fixed -= soft_things(scene)
    return [i for i, name in enumerate(names) if name not in fixed and i != me]


def touched_frames(
    contacts: Contacts, person: int, givers: list[int], frames: int
) -> NDArray[np.bool_]:
    """Frames (T,) beside an interval in which a known impulse acts; arguments: `known_wrenches`."""
    touched = np.zeros(frames, dtype=bool)
    rows = _own(contacts, person, givers).frame
    touched[rows] = True
    touched[np.maximum(rows - 1, 0)] = True
    return touched


def known_wrenches(
    contacts: Contacts,
    person: int,
    givers: list[int],
    frames: int,
    fps: float,
    cutoff: float | None,
    flights: Sequence[tuple[int, int]] = (),
) -> tuple[Array, Array]:
    """Forces that are known to act on a person, low-passed as its accelerations are.

    Impulses are sums over (t - 1, t]: the force at frame t is the mean of both intervals beside
    it, at the ends that of the one. In a flight nothing acts; what is between flights is filtered
    by itself.

    Args:
        contacts: Of the result.
        person: Index of the person.
        givers: Indices into `Result.names` whose impulses are known.
        frames: T.
        fps: Frames per second.
        cutoff: Of the filter [Hz]; None: no filter.
        flights: First frame and end of each: runs of frames that are not `touched_frames`.

    Returns:
        On parts: force [N] and moment about the world's origin [N m] (T, 55, 6). By giver (T, g,
        7): force, its size weighted position (times N) and its size, of which the centre of
        pressure comes; both 0 where there are only traces of the filter (`FAINT`).
    """
    parts, sides = np.zeros((frames, N_JOINTS, 6)), np.zeros((frames, len(givers), 7))
    own = _own(contacts, person, givers)
    if not len(own) or frames < 2:
        return parts, sides
    wrench = np.concatenate([own.impulse, np.cross(own.position, own.impulse)], axis=1)
    np.add.at(parts, (own.frame, own.part), wrench)
    size = own.strength[:, None]
    rows = np.concatenate([own.impulse, size * own.position, size], axis=1)
    place = np.searchsorted(np.asarray(givers), own.other)
    np.add.at(sides, (own.frame, place), rows)
    near = np.zeros((frames, len(givers)), dtype=bool)
    reach = 1 if cutoff is None else int(np.ceil(0.5 * fps / cutoff))
    for frame, giver in zip(own.frame.tolist(), place.tolist(), strict=True):
        near[max(frame - 1 - reach, 0) : frame + 1 + reach, giver] = True
    parts, sides = (_at_frames(x, fps, cutoff, flights) for x in (parts, sides))
    strength = sides[..., 6]
    sides[~near | (strength <= FAINT * strength.max(axis=0)), 3:] = 0.0
    return parts, sides


def _own(contacts: Contacts, person: int, givers: list[int]) -> Contacts:
    """The rows of a person's contacts with `givers`."""
    return contacts[(contacts.person == person) & np.isin(contacts.other, givers)]


def _at_frames(
    impulses: Array, fps: float, cutoff: float | None, flights: Sequence[tuple[int, int]]
) -> Array:
    """Forces at T frames of impulses over (t - 1, t], t = 1 to T - 1 (row 0 is not used)."""
    count, raw = len(impulses), impulses[1:] * fps
    out: Array = np.zeros_like(impulses)
    for first, end, inner in segments(count, flights):
        if inner:
            continue
        low, high = max(first - 1, 0), min(end, count - 1)  # intervals beside its frames
        force = low_pass(raw[low:high], fps, cutoff)
        force = np.concatenate([force[:1], force, force[-1:]])
        force = force[first - low : first - low + end - first + 1]
        out[first:end] = 0.5 * (force[1:] + force[:-1])
    return out

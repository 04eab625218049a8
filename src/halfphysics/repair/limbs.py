"""Limbs in the body: whether self-contact moves them out of it, or would catch them there.

Two simulations tell: with self-contact and without. They are compared where a person touches their
own body, and shortly after, over the second in which they differ most: how long a clip is, and what
people and objects do elsewhere, says nothing of limbs.
"""

from __future__ import annotations

import dataclasses
import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import HalfPhysicsWarning
from halfphysics.metrics.self_penetration import self_penetration
from halfphysics.repair.insides import DEEP

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import PersonResult, Result
    from halfphysics.scene.scene import Scene

Mask = NDArray[np.bool_]

#: Self-contact that moves the joints by no more than this on average over a second moves nothing,
#: and by more than that has caught a limb on the wrong side of another [mm]. Ten recorded clips:
#: 2 to 14, and 160 in the one in which arms are caught.
TOUCHES, CAUGHT = 2.0, 30.0
#: A limb is back on its way within this after a contact [s].
_AFTER = 0.3


def simulated(
    asked: list[Motion], scene: Scene, bodies: list[Body], done: list[str], left: list[str]
) -> Result:
    """The simulation with self-contact, or without where limbs are caught in it; `left` says so.

    Frames belong to those of a video or a text: nobody waits, and the clock goes on.
    """
    from halfphysics.settings import Settings
    from halfphysics.simulation.simulate import simulate

    plain = Settings(blocked="continue")
    apart = simulate(
        asked, scene, body=bodies, settings=dataclasses.replace(plain, self_contact=True)
    )
    touching = [_touching(apart, index) for index in range(len(apart.people))]
    inside = [_inside(p, mask) for p, mask in zip(apart.people, touching, strict=True)]
    if not any(inside):
        return apart
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)  # said by the first already
        through = simulate(asked, scene, body=bodies, settings=plain)
    moved = max(
        _apart(a, b, _with_after(mask, apart.fps))
        for a, b, mask, its in zip(apart.people, through.people, touching, inside, strict=True)
        if its
    )
    if moved <= TOUCHES:
        return through
    if moved > CAUGHT:
        left.append("limbs pass through the body and would be caught there: left as they are")
        return through
    done.append("limbs were inside the body: moved out of it")
    return apart


def _touching(result: Result, index: int) -> Mask:
    """Frames (T,) in which a person touches their own body."""
    contacts, own = result.contacts, result.names.index(result.people[index].name)
    mask = np.zeros(len(result), dtype=bool)
    mask[contacts.frame[(contacts.person == index) & (contacts.other == own)]] = True
    return mask


def _inside(person: PersonResult, touching: Mask) -> bool:
    """Whether limbs are inside the body as asked for, in frames in which it touches itself."""
    if not touching.any():
        return False
    asked = person.reference
    frames = np.flatnonzero(touching)
    frames = frames if len(frames) > 1 else np.repeat(frames, 2)  # no motion has a single one
    some = asked.with_frames(asked.translation[frames], asked.rotations[frames])
    # All of them: a limb that is caught touches for long, and may have been inside for a moment.
    return self_penetration(some, person.body, most=None).max_mm > DEEP


def _with_after(touching: Mask, fps: float) -> Mask:
    """Frames (T,) in which a body touches itself, and those shortly after."""
    mask = touching.copy()
    for frame in np.flatnonzero(touching).tolist():
        mask[frame : frame + 1 + round(_AFTER * fps)] = True
    return mask


def _apart(one: PersonResult, other: PersonResult, frames: Mask) -> float:
    """How far the joints of two simulations are apart in some frames (T,), of the pelvis [mm]: the
    mean over the second in which it is most; in other frames they count as 0."""
    joints = [p.body.joints(p.motion)[frames] for p in (one, other)]
    a, b = (its - its[:, :1] for its in joints)
    apart = np.zeros(len(frames))
    apart[frames] = 1000.0 * np.linalg.norm(a - b, axis=-1).mean(axis=1)
    width = min(len(apart), max(1, round(one.motion.fps)))
    return float(np.convolve(apart, np.full(width, 1.0 / width), mode="valid").max())

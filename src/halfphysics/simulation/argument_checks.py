"""The people of a simulation, checked: motions with their bodies, and the index of one."""

from __future__ import annotations

from collections.abc import Sequence

from halfphysics.base.validation import is_whole, several
from halfphysics.body.body import Body
from halfphysics.body.match import check_match
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.results.argument_checks import checked_bodies, checked_motion


def check_person_index(what: str, person: int | None, people: int) -> None:
    """Refuse what is neither None nor the index of one of `people`."""
    if person is None or (is_whole(person, least=0, plain=False) and person < people):
        return
    raise InputError(f"{what}: found person {person!r}, expected 0 to {people - 1}")


def checked_people(
    motion: Motion | Sequence[Motion],
    body: Body | Sequence[Body] | None,
    *,
    allow_mismatch: bool,
) -> tuple[list[Motion], list[Body]]:
    """Motions of one length and frame rate, and a body for each.

    Args:
        motion: The motion of one person, or of several.
        body: One for all people, or one per person; None: `Body.default()` for all.
        allow_mismatch: Accept a body of another gender or model than the motion says.

    Raises:
        InputError: An impossible value, or people with different fps or numbers of frames.
        MismatchError: The body's gender or model is not the motion's.
    """
    motions = several(motion)
    for one in motions:
        checked_motion(one, listed=True)
    if not motions:
        raise InputError("motion: found an empty list, expected at least one Motion")
    first = motions[0]
    for i, other in enumerate(motions):
        if len(other) != len(first) or other.fps != first.fps:
            raise InputError(
                f"motion: person {i} has {len(other)} frames at {other.fps:g} fps, person 0 has "
                f"{len(first)} at {first.fps:g}; expected the same. "
                "Use motion.resample(fps) and slices motion[a:b]"
            )
    bodies = checked_bodies(body)
    if not isinstance(body, list | tuple):
        bodies *= len(motions)
    if len(bodies) != len(motions):
        raise InputError(f"body: found {len(bodies)} bodies for {len(motions)} motions")
    for one, its in zip(motions, bodies, strict=True):
        check_match(one, its, allow_mismatch=allow_mismatch)
    return motions, bodies

"""The people of a simulation: motions and bodies as they were given, checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar, cast

from halfphysics.body.body import Body, check_match
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion

T = TypeVar("T")


def several(value: T | Sequence[T]) -> list[T]:
    """One value, or a list or tuple of them, as a list."""
    return list(value) if isinstance(value, list | tuple) else [cast(T, value)]


def checked_bodies(body: Body | Sequence[Body] | None) -> list[Body]:
    """Bodies, one per person; None: the default body.

    Raises:
        InputError: One of them is no body.
    """
    bodies = several(Body.default() if body is None else body)
    for one in bodies:
        if not isinstance(one, Body):
            raise InputError(f"body: found {one!r}, expected a halfphysics.Body")
    return bodies


def checked_people(
    motion: Motion | Sequence[Motion],
    body: Body | Sequence[Body] | None,
    *,
    allow_mismatch: bool,
) -> tuple[list[Motion], list[Body]]:
    """Motions of one length and frame rate, and a body for each.

    Args:
        motion: The motion of one person, or of several.
        body: One for everybody, or one per person; None: `Body.default()` for all.
        allow_mismatch: Accept a body of another gender or model than the motion says.

    Raises:
        InputError: An impossible value, or people with different fps or numbers of frames.
        MismatchError: The body's gender or model is not the motion's.
    """
    motions = several(motion)
    for one in motions:
        if not isinstance(one, Motion):
            raise InputError(f"motion: found {one!r}, expected a halfphysics.Motion")
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
    bodies = several(Body.default() if body is None else body)
    if not isinstance(body, list | tuple):
        bodies *= len(motions)
    if len(bodies) != len(motions):
        raise InputError(f"body: found {len(bodies)} bodies for {len(motions)} motions")
    for one, its in zip(motions, bodies, strict=True):
        check_match(one, its, allow_mismatch=allow_mismatch)
    return motions, bodies

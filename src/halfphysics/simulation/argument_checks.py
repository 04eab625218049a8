"""Arguments of a simulation, checked: motions, bodies, scene and settings."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeVar, cast

from halfphysics.base.validation import is_whole, shown
from halfphysics.body.body import Body
from halfphysics.body.match import check_match
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.sequence import Sequence as Story

T = TypeVar("T")


def way_to(value: object, load: str) -> str:
    """The end of a message about `value`: how to `load` it where it is a path, else nothing."""
    return f". Load it: {load}({shown(value)})" if isinstance(value, str | os.PathLike) else ""


def several(value: T | Sequence[T]) -> list[T]:
    """One value, or a list or tuple of them, as a list."""
    return list(value) if isinstance(value, list | tuple) else [cast(T, value)]


def checked_body(body: Body | None) -> Body:
    """A body; None: the default one. Raises `InputError` for anything else."""
    return Body.default() if body is None else _body(body)


def checked_bodies(body: Body | Sequence[Body] | None) -> list[Body]:
    """Bodies, one per person; None: the default body.

    Raises:
        InputError: One of them is no body.
    """
    return [_body(one) for one in several(Body.default() if body is None else body)]


def _body(value: Body) -> Body:
    if not isinstance(value, Body):
        raise InputError(
            f"body: found {shown(value)}, expected a halfphysics.Body"
            + way_to(value, "halfphysics.Body.load")
        )
    return value


def check_person_index(what: str, person: int | None, people: int) -> None:
    """Refuse what is neither None nor the index of one of `people`."""
    if person is None or (is_whole(person, least=0, plain=False) and person < people):
        return
    raise InputError(f"{what}: found person {person!r}, expected 0 to {people - 1}")


def checked_scene(scene: Scene | None) -> Scene:
    """A scene; None: an empty one. Raises `InputError` for anything else."""
    if scene is not None and not isinstance(scene, Scene):
        raise InputError(
            f"scene: found {shown(scene)}, expected a halfphysics.Scene"
            + way_to(scene, "halfphysics.Scene.load")
        )
    return scene or Scene()


def checked_settings(settings: Settings | None) -> Settings:
    """Settings; None: the default ones. Raises `InputError` for anything else."""
    if settings is not None and not isinstance(settings, Settings):
        found = f"settings: found {shown(settings)}, expected halfphysics.Settings"
        raise InputError(f"{found} of these" if isinstance(settings, Mapping) else found)
    return settings or Settings()


def checked_motion(motion: Motion) -> Motion:
    """A motion. Raises `InputError` for anything else, with the way to one."""
    if isinstance(motion, Motion):
        return motion
    way = way_to(motion, "halfphysics.Motion.load")
    if isinstance(motion, Story):
        way = " (s.motion, with s.scene, body=s.body and settings=s.settings)"
    elif isinstance(getattr(motion, "motion", None), Motion):
        way = ", such as its .motion"
    elif isinstance(motion, Iterator):
        way = " or a list of them"
    raise InputError(f"motion: found {shown(motion)}, expected a halfphysics.Motion{way}")


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
        checked_motion(one)
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

"""What a caller wants simulated, adapted or estimated, checked: motion, body, scene, settings."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeVar

from halfphysics.base.validation import several, shown
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings

T = TypeVar("T")


def checked_motion(motion: Motion, *, listed: bool = False) -> Motion:
    """A motion. Raises `InputError` for anything else, with the way to one.

    Args:
        motion: What the caller gave.
        listed: The caller could have given a list of motions too.
    """
    if isinstance(motion, Motion):
        return motion
    way = _way_to(motion, "halfphysics.Motion.load")
    if isinstance(getattr(motion, "motions", None), tuple):  # a halfphysics.Sequence
        way = " (s.motion, with s.scene, body=s.body and settings=s.settings)"
    elif isinstance(getattr(motion, "motion", None), Motion):
        way = ", such as its .motion"
    elif listed and isinstance(motion, Iterator):
        way = " or a list of them"
    raise InputError(f"motion: found {shown(motion)}, expected a halfphysics.Motion{way}")


def checked_body(body: Body | None) -> Body:
    """A body; None: the default one. Raises `InputError` for anything else."""
    return Body.default() if body is None else _given("body", body, Body)


def checked_bodies(body: Body | Sequence[Body] | None) -> list[Body]:
    """Bodies, one per person; None: the default body.

    Raises:
        InputError: One of them is no body.
    """
    return [_given("body", one, Body) for one in several(Body.default() if body is None else body)]


def checked_scene(scene: Scene | None) -> Scene:
    """A scene; None: an empty one. Raises `InputError` for anything else."""
    return Scene() if scene is None else given_scene(scene)


def given_scene(scene: Scene) -> Scene:
    """A scene, where there has to be one. Raises `InputError` for anything else."""
    return _given("scene", scene, Scene)


def checked_settings(settings: Settings | None) -> Settings:
    """Settings; None: the default ones. Raises `InputError` for anything else."""
    if settings is not None and not isinstance(settings, Settings):
        found = f"settings: found {shown(settings)}, expected halfphysics.Settings"
        raise InputError(f"{found} of these" if isinstance(settings, Mapping) else found)
    return settings or Settings()


def _given(name: str, value: T, kind: type[T]) -> T:
    """A value of a class of this package, refused with the way to load one where it is a path."""
    if not isinstance(value, kind):
        raise InputError(
            f"{name}: found {shown(value)}, expected a halfphysics.{kind.__name__}"
            + _way_to(value, f"halfphysics.{kind.__name__}.load")
        )
    return value


def _way_to(value: object, load: str) -> str:
    """The end of a message about `value`: how to `load` it where it is a path, else nothing."""
    return f". Load it: {load}({shown(value)})" if isinstance(value, str | os.PathLike) else ""

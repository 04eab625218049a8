"""A motion alone as a result, so that all that shows results shows motions: nobody touches it.

The simulated motion of such a result is its reference, there are no contacts, and objects are where
they were recorded, or at rest where nothing was recorded.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from collections.abc import Callable

    from halfphysics.body.body import Body
    from halfphysics.formats.loading import MotionOptions
    from halfphysics.results.result import ObjectTrack, Result
    from halfphysics.scene.scene import Scene
    from halfphysics.simulation.sequence import Sequence

_ATTRIBUTES = ("people", "objects", "scene", "fps")


def as_result(what: object, name: str = "result") -> Result:
    """A result to show: the given one, or one of a motion or a `Sequence` that nothing touches.

    Args:
        what: A `Result`, `Motion` or `Sequence`. A person without a body gets the default one; a
            scene without a plane gets a floor at z = 0.
        name: Of `what`, for the message.

    Raises:
        InputError: Something else.
    """
    from halfphysics.simulation.sequence import Sequence

    if all(hasattr(what, attribute) for attribute in _ATTRIBUTES):
        result: Any = what
        return result  # type: ignore[no-any-return]
    if isinstance(what, Motion):
        from halfphysics.scene.scene import Scene

        return _untouched(Sequence(what, Scene()))
    if isinstance(what, Sequence):
        return _untouched(what)
    raise InputError(
        f"{name}: found {shown(what)}, expected a Result, such as hp.Result.load(path), or a "
        "Motion, such as hp.Motion.load(path)"
    )


def open_result(
    path: str | os.PathLike[str],
    options: MotionOptions | None = None,
    body: Callable[[Body | None, Motion], Body] | None = None,
) -> Result:
    """A result file, or any motion file that the readers take, as a result to show.

    Args:
        path: The file.
        options: What a motion file cannot say itself; a result file needs none of it.
        body: Makes the body of each person of a motion file, as in `MotionOptions.sequence`.

    Raises:
        FileError: The file cannot be read, or is neither.
        InputError: An option that does not fit the file.
    """
    from halfphysics.formats.loading import MotionOptions
    from halfphysics.formats.results.result_file import is_result, load_result

    if is_result(path):
        return load_result(path)
    options = MotionOptions(adapt=False) if options is None else options
    return _untouched(options.sequence(Path(path), body=body))


def is_untouched(result: Result) -> bool:
    """Whether a result is a motion alone: nobody of it has a reference to compare with."""
    return all(person.motion is person.recorded for person in result.people)


def _untouched(sequence: Sequence) -> Result:
    """A sequence as a result: people on their references, objects where they were recorded."""
    from halfphysics.body.body import Body
    from halfphysics.results.contacts import Contacts
    from halfphysics.results.result import PersonResult, Result

    motions = sequence.motions
    frames = len(motions[0])
    scene = _with_floor(sequence.scene)
    people = tuple(
        PersonResult(
            name="person" if len(motions) == 1 else f"person_{k}",
            motion=motion,
            reference=motion,
            body=Body.default() if body is None else body,
        )
        for k, (motion, body) in enumerate(zip(motions, sequence.bodies, strict=True))
    )
    objects = {name: _track(name, scene, sequence, frames) for name in scene.objects}
    objects |= {name: t for name, t in sequence.recorded.items() if name not in objects}
    return Result(
        people=people,
        objects=objects,
        scene=scene,
        names=(*scene.statics, *objects, *(person.name for person in people)),
        contacts=Contacts.none(),
        clearance=np.full(frames, np.inf),
        lost_time=np.zeros(frames),
        settings=sequence.settings,
    )


def _track(name: str, scene: Scene, sequence: Sequence, frames: int) -> ObjectTrack:
    """The recorded poses of an object, those of its trajectory, or its pose in the scene."""
    from halfphysics.results.result import ObjectTrack
    from halfphysics.scene.trajectories import KinematicObject

    if name in sequence.recorded:
        return sequence.recorded[name]
    item = scene.objects[name]
    if isinstance(item, KinematicObject):
        position, quaternion = item.at(np.arange(frames) / sequence.motions[0].fps)
        return ObjectTrack(position=position, quaternion=quaternion)
    return ObjectTrack(
        position=np.tile(np.asarray(item.position, dtype=np.float64), (frames, 1)),
        quaternion=np.tile(np.asarray(item.quaternion, dtype=np.float64), (frames, 1)),
    )


def _with_floor(scene: Scene) -> Scene:
    """A scene with a plane: its own, or a copy with a floor at z = 0."""
    from halfphysics.formats.loading import GROUND, furnished

    taken = GROUND in (*scene.statics, *scene.objects)
    return furnished(scene, None, (), (), ground=not taken)

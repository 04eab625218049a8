"""Results among clips and truths: the frames of them that are judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.formats.loading import MotionOptions
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack, Result


@dataclass(frozen=True, eq=False)
class Played:
    """A result, with what moved in the frames that are judged.

    Attributes:
        result: All of it.
        motions: Of each of its people the realised motion in T frames.
        objects: Tracks of objects and links in these frames.
    """

    result: Result
    motions: tuple[Motion, ...]
    objects: Mapping[str, ObjectTrack]


def played(path: Path, how: MotionOptions) -> Played:
    """A result from a file in the frames of the options, as a clip or as a truth.

    A result stands on the floor of its scene. A height of the floor is told of motion files: that
    of a result may be another one, as where it was simulated from such a file.

    Raises:
        InputError: Fewer than two of its frames, or a floor.
        FileError: A file that cannot be read.
    """
    from halfphysics.formats.frame_range import few_frames
    from halfphysics.results.result import ObjectTrack, Result

    if how.floor is not None:
        raise InputError(
            f"floor: found {how.floor}, but {path} is a result, which stands on the floor of its "
            "scene; expected motion files alone. Leave it out, and write motions that are compared "
            "with a result with their floor at z = 0 first (halfphysics convert --floor)"
        )
    result = Result.load(path)
    part = slice(*(how.frame_range() or (None, None)))
    if (error := few_frames(str(path), part, len(result))) is not None:
        raise error
    tracks = {
        name: ObjectTrack(position=track.position[part], quaternion=track.quaternion[part])
        for name, track in result.objects.items()
    }
    return Played(result, tuple(person.motion[part] for person in result.people), tracks)

"""The truth of a person: that of the same name in the file of truths, or of the same place."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.errors import HalfPhysicsError, InputError
from halfphysics.judging.played import played

if TYPE_CHECKING:
    from halfphysics.formats.loading import MotionOptions
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack

# Names in a message.
_NAMED = 12


@dataclass(frozen=True, eq=False)
class Truth:
    """What truly happened: a person's motion, and the tracks of objects; None: they are unknown."""

    motion: Motion
    objects: Mapping[str, ObjectTrack] | None = None


def truth_of(
    path: Path,
    how: MotionOptions,
    name: str | None,
    *,
    index: int = 0,
    count: int = 1,
    objects: bool = False,
) -> Truth:
    """The truth of one person.

    Args:
        path: The file of truths.
        how: What motion files cannot say; truths are read as clips are.
        name: The person's name in the file that is judged; None: they have none.
        index: Their place among the people of a result.
        count: How many people that result has; truths of as many may have other names.
        objects: Whether tracks of objects are read, where there are any.

    Raises:
        InputError: The file tells of several people, and which of them it is cannot be known.
    """
    from halfphysics.formats.results.result_file import is_result

    name = how.clip if name is None else name
    if is_result(path):
        found = played(path, how)
        names = [person.name for person in found.result.people]
        which = _which(f"truth: {path}", names, name, index, count)
        return Truth(found.motions[which], found.objects)
    names = list(_names_in(path))
    if len(names) > 1:
        which = _which(f"truth: {path}", names, name, index, count)
        how = replace(how, clip=names[which])
    return Truth(how.load(path), _recorded(path, how) if objects else None)


def reference_of(path: Path, name: str, *, index: int, count: int) -> Motion:
    """The motion that one of `count` people of a result is compared with (see `truth_of`).

    Raises:
        InputError: As `truth_of`; the file tells of one person, and the result of several.
    """
    from halfphysics.formats.loading import MotionOptions
    from halfphysics.formats.results.result_file import is_result
    from halfphysics.results.result import Result

    if count == 1:
        return MotionOptions().load(path)
    people = len(Result.load(path).people) if is_result(path) else len(_names_in(path))
    if people < 2:
        raise InputError(
            f"reference: {path} holds one person, and the result {count}; expected as many, or the "
            "same names. Compare with a result or a file of all of them"
        )
    return truth_of(path, MotionOptions(), name, index=index, count=count).motion


def _names_in(path: Path) -> Sequence[str]:
    """Names of the people or clips in a motion file, in its order; empty: it holds one motion."""
    from halfphysics.formats.format import Source
    from halfphysics.formats.registry import identify

    source = Source(path)
    format = identify(source)
    if format is None:
        return ()
    if format.people is not None:
        return [track.name for track in format.people(source)]
    return () if format.clips is None else list(format.clips(source))


def _which(where: str, names: Sequence[str], name: str | None, index: int, count: int) -> int:
    """Which of the people or clips of a file of truths a person is."""
    if len(names) < 2:
        return 0
    if name in names:
        return names.index(name)
    if 1 < count == len(names):
        return index
    shown = ", ".join(names[:_NAMED]) + (", ..." if len(names) > _NAMED else "")
    who = "one motion without a name" if name is None else f"none of the name {name!r}"
    raise InputError(
        f"{where} holds {len(names)} ({shown}); found {who} to judge, expected one of these "
        "names. Give the truth of this person in a file of its own (halfphysics convert --clip "
        "writes one)"
    )


def _recorded(path: Path, how: MotionOptions) -> Mapping[str, ObjectTrack] | None:
    """Tracks of the objects that a data set recorded with a motion."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # said of the motion already
        try:
            return replace(how, adapt=False).sequence(path).recorded or None
        except HalfPhysicsError:  # its meshes are elsewhere: contact with them is unknown
            return None

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
    index: int | None = None,
    count: int = 1,
    objects: bool = False,
    what: str = "truth",
) -> Truth:
    """The truth of one person.

    Args:
        path: The file of truths.
        how: What motion files cannot say; truths are read as clips are.
        name: The person's name in the file that is judged; None: they have none.
        index: Their place among the people of a result; None: the file is none.
        count: How many people are judged; truths of as many may have other names in a result.
        objects: Whether tracks of objects are read, where there are any.
        what: The file of truths in messages.

    Raises:
        InputError: Which of the people that the file tells of it is cannot be known, or it tells of
            one, and of the people who are judged that is another one.
    """
    from halfphysics.formats.results.result_file import is_result

    name = how.clip if name is None else name
    if is_result(path):
        found = played(path, how)
        names = [person.name for person in found.result.people]
        which = _which(f"{what}: {path}", names, name, index, count)
        return Truth(found.motions[which], found.objects)
    names = list(_names_in(path))
    which = _which(f"{what}: {path}", names, name, index, count)
    how = replace(how, clip=names[which] if len(names) > 1 else None)  # that of who is judged
    return Truth(how.load(path), _recorded(path, how) if objects else None)


def reference_of(path: Path, name: str, *, index: int, count: int) -> Motion:
    """The motion that one of `count` people of a result is compared with (see `truth_of`).

    Raises:
        InputError: As `truth_of`.
    """
    from halfphysics.formats.loading import MotionOptions

    if count == 1:
        return MotionOptions().load(path)
    return truth_of(path, MotionOptions(), name, index=index, count=count, what="reference").motion


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


def _which(
    where: str, names: Sequence[str], name: str | None, index: int | None, count: int
) -> int:
    """Which of the people or clips of a file of truths a person is."""
    if name in names:
        return names.index(name)
    if len(names) < 2:
        if count > 1:
            other = "the clip" if index is None else "the result"
            raise InputError(
                f"{where} holds one person, and {other} {count}; expected as many, or the same "
                "names. Compare with a result or a file of all of them"
            )
        return 0
    if index is not None and 1 < count == len(names):
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

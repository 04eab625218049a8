"""Several people in one file: who is there when, and who is read.

Video estimators track everyone they see; each track begins and ends with its own frame and may have
gaps. `Motion.load` reads one person: the one that `clip=` names, else who is there longest.
`load_sequence` reads those who are there at the same time (`together`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.base.suggestions import did_you_mean
from halfphysics.errors import FileError, InputError

Array = NDArray[np.float64]

#: People are read together while the frames that they share are at least this part of the frames
#: of who is there longest: below it a passer-by would cost the others most of their motion.
SHARED = 0.5
#: A gap that is filled between two frames is told from this length on [frames].
_LONG_GAP = 5
# Number of names in a message.
_NAMED = 12


@dataclass(frozen=True)
class Track:
    """One person of a file: a name, and the frames from `start` to before `stop` of the video."""

    name: str
    start: int
    stop: int

    def __len__(self) -> int:
        return self.stop - self.start


def chosen(where: str, tracks: Sequence[Track], clip: str) -> Track:
    """The person whom `clip` names, or who is there longest.

    Warns:
        HalfPhysicsWarning: One of several people was chosen.

    Raises:
        InputError: Nobody has that name. FileError: Nobody is there.
    """
    if not tracks:
        raise _nobody(where)
    if clip:
        for track in tracks:
            if track.name == clip:
                return track
        names = [track.name for track in tracks]
        hint = did_you_mean(clip, names, count=3, otherwise=f", such as {names[0]!r}")
        raise InputError(
            f"clip: {where} has no {clip!r}, expected one of its {len(names)} people{hint}"
        )
    track = max(tracks, key=len)  # the first of those of equal length
    if len(tracks) > 1:
        warn(
            f"{where}: of {len(tracks)} people {track.name!r} is read, who is there longest "
            f"({len(track)} frames). clip= names another ({_names(tracks, track)}); load_sequence "
            "reads those who are there together"
        )
    return track


def together(where: str, tracks: Sequence[Track]) -> tuple[list[Track], int, int]:
    """Those who are there at the same time, in the order of the file, and the frames they share.

    Returns:
        The people, and the first of their common frames and the frame after the last.

    Warns:
        HalfPhysicsWarning: Somebody is left out, or frames are.

    Raises:
        FileError: Nobody is there.
    """
    if not tracks:
        raise _nobody(where)
    longest = max(tracks, key=len)
    start, stop, kept = longest.start, longest.stop, [longest]
    for track in sorted(tracks, key=len, reverse=True):
        first, last = max(start, track.start), min(stop, track.stop)
        if track is not longest and last - first >= SHARED * len(longest):
            start, stop = first, last
            kept.append(track)
    kept.sort(key=list(tracks).index)
    left = [track for track in tracks if track not in kept]
    notes = []
    if stop - start < len(longest):
        notes.append(f"frames {start} to {stop}, in which all of them are there")
    if left:
        notes.append(f"without {_names(left)}, who are there at other times (clip= reads one)")
    if notes:
        who = ", ".join(repr(track.name) for track in kept[:_NAMED])
        warn(f"{where}: {who} are read, {'; '.join(notes)}")
    return kept, start, stop


def _nobody(where: str) -> FileError:
    return FileError(f"{where}: found nobody in it, expected at least one person")


def _names(tracks: Sequence[Track], but: Track | None = None) -> str:
    names = [repr(track.name) for track in tracks if track is not but]
    return ", ".join(names[:_NAMED]) + (", ..." if len(names) > _NAMED else "")


def filled(where: str, frames: Array, translation: Array, rotations: Array) -> tuple[Array, Array]:
    """A track without gaps: missing frames are put between those before and after.

    Args:
        where: Name of the track in messages.
        frames: Numbers (n,) of its frames, whole and increasing.
        translation: (n, 3).
        rotations: Axis-angle (n, J, 3) [rad].

    Returns:
        Translation (T, 3), linear in gaps, and rotations (T, J, 3), along the shortest turn, of
        the T frames from the first to the last.

    Warns:
        HalfPhysicsWarning: A gap of over five frames was filled.

    Raises:
        FileError: The numbers are not whole or do not increase.
    """
    steps = np.diff(frames)
    if (np.asarray(frames) % 1 != 0).any() or (steps <= 0).any():
        raise FileError(
            f"{where}: found frame numbers that are not whole or do not increase, expected each "
            "frame once, in order"
        )
    if not len(steps) or steps.max() == 1:
        return translation, rotations
    wanted = np.arange(int(frames[0]), int(frames[-1]) + 1)
    before = np.clip(np.searchsorted(frames, wanted, side="right") - 1, 0, len(frames) - 2)
    part = ((wanted - frames[before]) / steps[before])[:, None]
    places = translation[before] + part * (translation[before + 1] - translation[before])
    a, b = rot.exp(rotations[before]), rot.exp(rotations[before + 1])
    turns = rot.log(rot.slerp(a, b, part))
    known = np.isin(wanted, frames)
    own = np.searchsorted(frames, wanted[known])
    places[known], turns[known] = translation[own], rotations[own]
    if steps.max() > _LONG_GAP:
        at = int(np.argmax(steps))
        warn(
            f"{where}: {int((steps - 1).sum())} frames are missing and filled between those before "
            f"and after, at most {int(steps[at]) - 1} from frame {int(frames[at])} on"
        )
    return places, turns

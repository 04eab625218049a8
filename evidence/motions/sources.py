"""The motions of the tables: made from a seed, or read from folders of the user."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evidence.model import Options
from evidence.motions import choreography
from evidence.motions import daily as everyday
from halfphysics.errors import FileError

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion

#: Of a quick report: numbers of the dances and daily motions, number of clips of the user, and the
#: duration taken of each [s] (dances are whole).
QUICK_DANCES, QUICK_DAILY, QUICK_CLIPS, QUICK_SECONDS = (3, 4, 6, 7), (0, 1), 4, 4.0
#: Of a full report: largest number of clips of the user, and the duration taken of each [s].
MOST_CLIPS, MOST_SECONDS = 40, 60.0
#: The test set of AIST++, beside its motions or in the folder above, one name a line.
AIST_TEST = Path("splits") / "crossmodal_test.txt"
_SUFFIXES = {".npz", ".pkl", ".bvh", ".npy", ".pt", ".p"}


@dataclass(frozen=True)
class Source:
    """One motion: its name, what `load` needs to make it, and the file or folder it is in."""

    name: str
    arguments: Mapping[str, Any]
    file: str | None = None


@dataclass(frozen=True)
class Group:
    """Motions that make one row.

    Attributes:
        key: Letters: the first part of the keys of its tasks.
        data: Description.
        sources: The motions.
        judged: Whether the tables of the paper are about such motions.
    """

    key: str
    data: str
    sources: tuple[Source, ...]
    judged: bool = True


def load(arguments: Mapping[str, Any]) -> Motion:
    """The motion of a source, without a body shape.

    Raises:
        FileError: The file is missing, damaged, or no motion.
    """
    from halfphysics.motion.motion import Motion

    given = dict(arguments)
    kind = given.pop("kind")
    if kind == "dance":
        return choreography.dance(**given)
    if kind == "daily":
        return everyday.daily(**given)
    path, fps = Path(given["path"]), given.get("fps")
    if not path.exists():
        raise FileError(f"{path}: no such file, though the test set names it")
    # Every motion is played on the default body, which has no use for betas of other models.
    motion = replace(Motion.load(path, clip=given["clip"]), betas=None)
    motion = motion[: max(2, round(given["seconds"] * motion.fps))]
    return motion if fps is None or fps >= motion.fps else motion.resample(fps)


def dances(options: Options) -> Group:
    """The embedded dances."""
    numbers = QUICK_DANCES if options.quick else tuple(range(choreography.CLIPS))
    seconds = choreography.SECONDS
    data = f"dance, embedded, {len(numbers)} clips of {seconds:g} s at {choreography.FPS:g} fps"
    return Group("dance", data, _made("dance", numbers, options.seed, seconds))


def slower(group: Group, fps: float) -> Group:
    """The same motions at fewer frames per second."""
    sources = (replace(s, arguments={**s.arguments, "fps": fps}) for s in group.sources)
    data = f"{group.data}, taken at {fps:g} fps"
    return Group(f"{group.key}-{fps:g}fps", data, tuple(sources), group.judged)


def daily(options: Options) -> Group:
    """The embedded daily motions."""
    numbers = QUICK_DAILY if options.quick else tuple(range(everyday.CLIPS))
    seconds = QUICK_SECONDS if options.quick else None
    data = f"daily, embedded, {len(numbers)} clips at {everyday.FPS:g} fps"
    return Group("daily", data, _made("daily", numbers, options.seed, seconds))


def _made(
    kind: str, numbers: Sequence[int], seed: int, seconds: float | None
) -> tuple[Source, ...]:
    return tuple(
        Source(f"{n:02d}", {"kind": kind, "number": n, "seed": seed, "seconds": seconds})
        for n in numbers
    )


def brought(options: Options) -> list[Group]:
    """Motions of the user: AIST++ and any others."""
    groups = []
    if "aist" in options.data:
        folder = Path(options.data["aist"])
        groups.append(options.once("aist", lambda: _aist(folder, options.quick)))
    if "clips" in options.data:
        others = Path(options.data["clips"])
        groups.append(options.once("clips", lambda: _clips(others, options.quick)))
    return groups


def _aist(folder: Path, quick: bool) -> Group:
    """The test set where the folder or the one above lists it, else all clips in order."""
    places = (folder / AIST_TEST, folder.parent / AIST_TEST)
    split = next((place for place in places if place.is_file()), None)
    # The release has keypoints and cameras, which are .pkl too, beside the motions.
    motions = folder / "motions" if (folder / "motions").is_dir() else folder
    if split is None:
        paths = sorted(motions.rglob("*.pkl"))
        what = "AIST++, the first {} in order of {} clips: there is no splits/crossmodal_test.txt"
    else:
        try:
            names = split.read_text(encoding="utf-8").split()
        except (OSError, UnicodeDecodeError) as error:
            raise FileError(f"{split}: cannot read the names of the test set: {error}") from None
        paths = [motions / f"{name.removesuffix('.pkl')}.pkl" for name in names]
        what = "AIST++ test set, {} of its {} clips"
    if not paths:
        raise FileError(f"{folder}: no .pkl of AIST++ in it; expected its folder of motions")
    taken = paths[: QUICK_CLIPS if quick else MOST_CLIPS]
    data = what.format(len(taken), len(paths))
    return Group("aist", _shortened(data, quick), _files([(p, None) for p in taken], quick))


def _clips(folder: Path, quick: bool) -> Group:
    """The first motions in the folder, and the files there that should be motions but are not."""
    from halfphysics.formats.library import clips

    count = QUICK_CLIPS if quick else MOST_CLIPS
    # One more, to know whether there are more: a library of thousands is not listed to its end.
    walked = [(clip.path, clip.name) for clip in islice(clips(folder), count + 1)]
    last = str(walked[-1][0]) if len(walked) > count else ""
    found = sorted(
        walked + [(path, None) for path in _damaged(folder, {path for path, _ in walked}, last)],
        key=lambda clip: (str(clip[0]), clip[1] or ""),
    )
    if not found:
        raise FileError(f"{folder}: no motion in it of a format that is known")
    many = f"the first {count} clips in order" if len(found) > count else f"{len(found)} clips"
    data = _shortened(f"{folder.name}, {many}", quick)
    return Group("clips", data, _files(found[:count], quick), judged=False)


def _damaged(folder: Path, known: set[Path], last: str) -> list[Path]:
    """Files named like motions that cannot be read, up to a path in order ("": all)."""
    from halfphysics.formats.format import Source as File
    from halfphysics.formats.registry import identify

    out = []
    for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() in _SUFFIXES):
        inside = path in known or not known.isdisjoint(path.parents)
        if inside or not path.is_file() or (last and str(path) > last):
            continue
        try:
            identify(File(path))
        except FileError:
            out.append(path)  # its task reports the error
    return out


def _shortened(data: str, quick: bool) -> str:
    return f"{data}, the first {QUICK_SECONDS if quick else MOST_SECONDS:g} s of each"


def _files(found: Sequence[tuple[Path, str | None]], quick: bool) -> tuple[Source, ...]:
    seconds = QUICK_SECONDS if quick else MOST_SECONDS
    out = []
    for i, (path, clip) in enumerate(found):
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", f"{path.stem}-{clip}" if clip else path.stem)
        arguments = {"kind": "file", "path": str(path), "clip": clip, "seconds": seconds}
        file = str(path) if path.exists() else None
        out.append(Source(f"{i:02d}-{name[:60]}", arguments, file))
    return tuple(out)

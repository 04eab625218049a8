"""The options of a caller who reads a file, checked before the file is opened."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Literal

from halfphysics.base.axes import AXES
from halfphysics.base.validation import file_path, frame_rate, is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.formats.format import Assets, Options
from halfphysics.motion.motion import GENDERS, MODELS


def checked_options(
    fps: float | None,
    up: str | None,
    hands: str | None,
    model: str | os.PathLike[str] | None,
    gender: str | None,
    frames: tuple[int | None, int | None] | None,
    clip: str | None,
    assets: Assets,
    objects: str = "free",
    floor: float | Literal["lowest"] | None = None,
) -> Options:
    """The options of `Motion.load` and `load_sequence` (see there), checked.

    Raises:
        InputError: An impossible value, or a model or a folder that does not exist.
    """
    if up is not None and (not isinstance(up, str) or up not in AXES):
        raise InputError(f"up: found {shown(up)}, expected one of {', '.join(map(repr, AXES))}")
    if floor is not None and not (isinstance(floor, str) and floor == "lowest"):
        try:
            floor = number(floor, "floor", unit="m")
        except InputError as error:
            raise InputError(f"{error}, or 'lowest'") from None
    if hands is not None and not (isinstance(hands, str) and hands in ("flat", "mean")):
        raise InputError(f"hands: found {shown(hands)}, expected 'flat' or 'mean'")
    if fps is not None:
        fps = frame_rate(fps)
    if model is not None and str(model) not in MODELS and not file_path(model).exists():
        raise InputError(
            f"model: found '{model}', expected one of {', '.join(MODELS)} or the path of a "
            "body-model file that exists"
        )
    if gender is not None and not (isinstance(gender, str) and gender in GENDERS):
        raise InputError(f"gender: found {shown(gender)}, expected one of {', '.join(GENDERS)}")
    if frames is not None:
        frames = _checked_frames(frames)
    if clip is not None and (not isinstance(clip, str) or not clip):
        raise InputError(f"clip: found {shown(clip)}, expected the name of a clip in the file")
    if assets is None:
        assets = ()
    elif isinstance(assets, str | os.PathLike) or not isinstance(assets, Iterable):
        assets = (assets,)
    folders = tuple(file_path(folder) for folder in assets)
    for folder in folders:
        if not folder.is_dir():
            raise InputError(f"assets: found '{folder}', expected a folder that exists")
    return Options(
        fps=fps,
        up=up,
        hands=hands,
        model=model,
        gender=gender,
        frames=slice(*frames) if frames else slice(None),
        clip=clip or "",
        assets=folders,
        objects=objects,
        floor=floor,
    )


def _checked_frames(frames: object) -> tuple[int | None, int | None]:
    """First frame and end of what is read, as Python's own numbers."""
    pair = isinstance(frames, list | tuple) and len(frames) == 2
    if not (pair and all(i is None or is_whole(i, plain=False) for i in frames)):  # type: ignore[attr-defined]
        raise InputError(
            f"frames: found {shown(frames)}, expected (start, stop), whole numbers or None"
        )
    start, stop = (None if i is None else int(i) for i in frames)  # type: ignore[attr-defined]
    return start, stop

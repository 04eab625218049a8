"""Real clips: as they are read, in empty scenes, and in a furnished room."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import motion_values, result_values
from result_cases.scenes import body, clip, clips, floor, furnished
from result_cases.settings import DRIVES


def read(name: str) -> dict[str, Any]:
    """What is in the file, joints and skin of some of its poses, and it at another frame rate."""
    motion = hp.Motion.load(clips()[name])
    some = motion[: min(len(motion), 40) : 7]
    return {
        "motion": motion_values(motion),
        "length": (len(motion), motion.gender, motion.model, motion.duration),
        "joints": body().joints(motion),
        "vertices": body().vertices(some),
        "resampled": motion_values(some.resample(50.0)),
        "grounded": motion.grounded(body()).translation,
    }


def empty(name: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The clip with nothing in its way."""
    settings = hp.Settings(**changes)
    return result_values(hp.simulate(clip(name), body=body(), settings=settings))


def on_floor(name: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The clip on a floor a centimetre too high for it."""
    scene = floor(friction=0.6) if not changes else hp.Scene()
    if changes:
        scene.add_static("floor", hp.Box((6.0, 6.0, 0.1)), position=(0.0, 0.0, -0.04))
    return result_values(
        hp.simulate(clip(name), scene, body=body(), settings=hp.Settings(**changes))
    )


def in_room(name: str, changes: Mapping[str, Any], first: float, seconds: float) -> dict[str, Any]:
    """The clip in a furnished room, which is in its way everywhere."""
    motion = clip(name, seconds, first)
    settings = hp.Settings(**changes)
    return result_values(hp.simulate(motion, furnished(), body=body(), settings=settings))


def cases() -> Iterator[Case]:
    """Every clip."""
    for name in clips():
        yield Case(f"clip/{name}/read", partial(read, name), quick=True)
        for drive, changes in DRIVES.items():
            yield Case(f"clip/{name}/empty_{drive}", partial(empty, name, changes), quick=True)
            yield Case(f"clip/{name}/floor_{drive}", partial(on_floor, name, changes))
            for contact in ("skin", "parts"):
                chosen = {**changes, "contact": contact}
                for first in (0.0, 0.4, 0.9):
                    run = partial(in_room, name, chosen, first, 1.5)
                    yield Case(f"clip/{name}/room_{drive}_{contact}_{first:g}", run)
        run = partial(in_room, name, {"self_contact": True}, 0.4, 0.6)
        yield Case(f"clip/{name}/room_short", run, quick=True)

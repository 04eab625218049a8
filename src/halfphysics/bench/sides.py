"""Measurement of one row: ours with the skin, with the rigid parts, and the peer, in turns."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from halfphysics.bench.clips import SUBSTEPS, body, drives
from halfphysics.bench.record import Options, Record
from halfphysics.bench.timing import in_turns
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import follow
from halfphysics.simulation.simulator import Simulator

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.settings import Settings

A = TypeVar("A")


@dataclass(frozen=True, kw_only=True)
class Measured(Generic[A]):
    """A row without its checks, and the return value of each side; None for a missing side."""

    record: Record
    ours: A
    parts: A | None
    peer: Any


def simulators(
    person: Body, settings: Settings, fps: float, scene: Scene | None = None
) -> tuple[Simulator, Simulator]:
    """Two simulators: contact by the skin, and contact by the rigid parts."""
    skin, parts = (
        Simulator(scene, body=person, settings=replace(settings, contact=contact), fps=fps)
        for contact in ("skin", "parts")
    )
    return skin, parts


def followed(simulator: Simulator, motion: Motion) -> Callable[[], Result]:
    """A side that simulates a motion in a world built before."""
    return lambda: follow(simulator.world, [motion])


def driven(
    case: str,
    name: str,
    motion: Motion,
    options: Options,
    *,
    ours: Callable[[Simulator, Motion], Callable[[], A]],
    peer: Callable[[], Any],
    scene: Scene | None = None,
    substeps: int = SUBSTEPS,
    stiffness: tuple[float, ...] = (1.0,),
) -> Iterator[tuple[Simulator, Measured[A]]]:
    """Time both drives at every stiffness: a motion of the default body, by skin and by parts.

    Args:
        case: Case of the records.
        name: First part of their settings.
        motion: The motion; a pass plays all of it.
        options: Options of the measurement.
        ours: Function that makes one side from a simulator.
        peer: The peer's side; it has neither drives nor stiffness.
        scene: The scene.
        substeps, stiffness: Settings of the simulation.

    Yields:
        The simulator with skin contact, and the measurement.
    """
    for label, settings in drives(substeps, *stiffness):
        skin, parts = simulators(body(), settings, motion.fps, scene)
        yield (
            skin,
            measure(
                case,
                f"{name}, {label}",
                len(motion) - 1,
                options,
                ours=ours(skin, motion),
                parts=ours(parts, motion),
                peer=peer,
            ),
        )


def measure(
    case: str,
    setting: str,
    frames: int,
    options: Options,
    *,
    ours: Callable[[], A],
    parts: Callable[[], A] | None = None,
    peer: Callable[[], Any] | None = None,
    unit: str = "frames/s",
) -> Measured[A]:
    """Time one pass of `frames` frames of every side, in turns.

    Args:
        case, setting, frames, unit: Fields of the record.
        options: Options of the measurement.
        ours: One pass of ours, with skin contact.
        parts: The same pass with the rigid parts, or None.
        peer: One pass of the peer, or None.
    """
    sides: dict[str, Callable[[], Any]] = {"ours": ours}
    sides |= {} if parts is None else {"parts": parts}
    sides |= {} if peer is None else {"peer": peer}
    timings = dict(zip(sides, in_turns(list(sides.values()), options), strict=True))
    figures = {
        name: timing.seconds if unit == "s" else timing.rates(frames)
        for name, timing in timings.items()
    }
    record = Record(
        case=case,
        setting=setting,
        frames=frames,
        unit=unit,
        ours=figures["ours"],
        parts=figures.get("parts"),
        peer=figures.get("peer"),
    )
    results = {name: timing.result for name, timing in timings.items()}
    return Measured(
        record=record,
        ours=results["ours"],
        parts=results.get("parts"),
        peer=results.get("peer"),
    )

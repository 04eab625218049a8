"""The jobs of `simulate_many`: what each simulates, from lists with one entry each or for all."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from halfphysics.base.validation import shown
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.sequence import Sequence as Story

if TYPE_CHECKING:
    from halfphysics.simulation.simulate import Stiffness


@dataclass(frozen=True)
class Job:
    """The arguments of one `simulate`."""

    motion: Motion | Sequence[Motion]
    scene: Scene | None
    body: Body | Sequence[Body] | None
    settings: Settings | None
    stiffness: Stiffness | Sequence[Stiffness] | None


def jobs_of(
    jobs: Iterable[Any], scenes: Any, body: Any, settings: Any, stiffness: Any
) -> list[Job]:
    """One job for each entry of `jobs`; the arguments are those of `simulate_many`.

    Raises:
        InputError: `jobs` is not several, or a list has another length.
    """
    if isinstance(jobs, Motion | Story | str | bytes) or not isinstance(jobs, Iterable):
        raise InputError(
            f"jobs: found {shown(jobs)}, expected a list: of each job the motion, a list of one "
            "motion per person, or a halfphysics.Sequence"
        )
    motions = list(jobs)
    count = len(motions)
    columns = (
        motions,
        _each("scenes", scenes, count),
        _each("body", body, count),
        _each("settings", settings, count),
        _each("stiffness", stiffness, count),
    )
    return [_job(*row) for row in zip(*columns, strict=True)]


def _each(name: str, value: Any, count: int) -> list[Any]:
    if not isinstance(value, list | tuple):
        return [value] * count
    if len(value) != count:
        raise InputError(
            f"{name}: found {len(value)} for {count} jobs, expected one for all jobs, or a list "
            "with one for each"
        )
    return list(value)


def _job(motion: Any, scene: Any, body: Any, settings: Any, stiffness: Any) -> Job:
    """What a sequence says counts where nothing else is said."""
    if not isinstance(motion, Story):
        return Job(motion, scene, body, settings, stiffness)
    if body is None and all(isinstance(own, Body) for own in motion.bodies):
        body = list(motion.bodies)
    return Job(
        motion=list(motion.motions),
        scene=motion.scene if scene is None else scene,
        body=body,
        settings=motion.settings if settings is None else settings,
        stiffness=stiffness,
    )

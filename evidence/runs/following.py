"""Tracking errors without obstacles: the task, and the means that its rows show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from evidence.model import Outcome, Series, Task
from evidence.motions import sources
from evidence.motions.sources import Group, Source
from evidence.runs.choices import Choice
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.settings import Settings

#: Samples of an error curve per second [1/s].
_CURVE = 10.0
_PICTURES, _SIZE = 6, (240, 280)


def follow(source: Mapping[str, Any], runs: Mapping[str, Choice], strip: str = "") -> Outcome:
    """Follow one motion with each setting of `runs`.

    Args:
        source: The motion, see `sources.load`.
        runs: Name -> setting.
        strip: The run that gets pictures, "" for none.

    Returns:
        Values "frames", "fps" and "runs": name -> success (every frame came back, finite), errors
        [mm] (None without success), the cause of a failure, and the mean error of every tenth of
        a second, "curve" [mm].
    """
    from halfphysics.baselines import from_options
    from halfphysics.body.body import Body
    from halfphysics.render.contact_sheet import contact_sheet_png

    motion, body = sources.load(source), Body.default()
    values, pictures = {}, {}
    for name, chosen in runs.items():
        result, found = _followed(motion, body, from_options(chosen))
        values[name] = found
        if name == strip and result is not None:
            frames = np.linspace(0, len(motion) - 1, _PICTURES + 1)[1:].round().astype(int)
            pictures[name] = contact_sheet_png(result, frames.tolist(), _PICTURES, _SIZE)
    content = {"frames": len(motion), "fps": motion.fps, "runs": values}
    return Outcome(values=content, pictures=pictures)


def _followed(
    motion: Motion, body: Body, settings: Settings
) -> tuple[Result | None, dict[str, Any]]:
    from halfphysics.simulation.simulate import simulate

    failed: dict[str, Any] = {"success": False, "mpjpe": None, "mpjpe_global": None, "curve": []}
    try:
        result = simulate(motion, body=body, settings=settings)
    except InputError as error:  # the result is no motion: not finite, or torn apart
        return None, {**failed, "cause": str(error)}
    apart = np.linalg.norm(body.joints(result.motion) - body.joints(motion), axis=2)
    if len(result.motion) != len(motion) or not np.isfinite(apart).all():
        return None, {**failed, "cause": "frames are missing or not finite"}
    return result, errors(result.motion, motion, body)


def errors(came: Motion, asked: Motion, body: Body) -> dict[str, Any]:
    """Errors of a motion that was followed to its end."""
    from halfphysics import metrics

    apart = np.linalg.norm(body.joints(came) - body.joints(asked), axis=2).mean(axis=1)
    every = max(1, round(asked.fps / _CURVE))
    return {
        "success": True,
        "cause": "",
        "mpjpe": metrics.mpjpe(came, asked, body),
        "mpjpe_global": metrics.mpjpe_global(came, asked, body),
        "curve": 1000.0 * apart[::every],
    }


def task(
    group: Group,
    source: Source,
    runs: Mapping[str, Choice],
    seconds: float,
    strip: str = "",
    function: str = ".runs.following:follow",
) -> Task:
    """The task that follows a source of a group; its key is "group/source"."""
    return Task(
        key=f"{group.key}/{source.name}",
        function=function,
        arguments={"source": source.arguments, "runs": runs, "strip": strip},
        inputs=() if source.file is None else (source.file,),
        seconds=seconds,
    )


def outcomes(values: Mapping[str, Any], group: Group, run: str) -> list[Mapping[str, Any]]:
    """Outcomes of one run on all motions of a group that have one."""
    keys = [f"{group.key}/{source.name}" for source in group.sources]
    found = [values[key]["runs"] for key in keys if key in values]
    return [runs[run] for runs in found if run in runs]


def success(found: Sequence[Mapping[str, Any]], group: Group) -> float | None:
    """Percentage of the motions that were followed to their end.

    All motions that are made here count; of those of the user, the ones that could be read.
    """
    made = sum(source.arguments["kind"] != "file" for source in group.sources)
    whole = max(made, len(found))
    return 100.0 * sum(one["success"] for one in found) / whole if found else None


def mean(found: Sequence[Mapping[str, Any]], name: str) -> float | None:
    """Mean over the motions that were followed to their end, with equal weights."""
    errors = [one[name] for one in found if one["success"]]
    return float(np.mean(errors)) if errors else None


def curve(found: Mapping[str, Any], name: str) -> Series:
    """The error of a run over time."""
    error = found["curve"]
    return Series(name, [i / _CURVE for i in range(len(error))], error)


def remarks(found: Sequence[Mapping[str, Any]], group: Group) -> str:
    """Number of motions of the group without an outcome, and why others were not followed to
    their end."""
    count, absent = len(group.sources), len(group.sources) - len(found)
    said = [f"without {absent} of the {count} clips, which failed"] if absent else []
    return "; ".join([*said, *sorted({one["cause"] for one in found if not one["success"]})])

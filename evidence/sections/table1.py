"""Table 1: without obstacles the result is the reference."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evidence import published
from evidence.model import (
    Content,
    Figure,
    Options,
    Outcome,
    Picture,
    Row,
    Section,
    Task,
    at_least,
    at_most,
)
from evidence.motions import sources
from evidence.motions.sources import Group
from evidence.runs import following
from evidence.runs.choices import LIMP, Choice, said
from evidence.runs.following import mean, outcomes, remarks, success, task
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion.motion import Motion

#: Rows of every group of motions: name -> setting.
RUNS: dict[str, Choice] = {"half-physics": LIMP, "half-physics, our default": {}}
_SHOWN = "half-physics"
#: One more row: the steps that the core skips where nothing is near, computed one by one.
INTEGRATED, SUBSTEPS = "Algorithm 1, step by step", 8


def follow(source: Mapping[str, Any], runs: Mapping[str, Choice], strip: str = "") -> Outcome:
    """As `following.follow`, and the run `INTEGRATED`."""
    outcome = following.follow(source, runs, strip)
    motion, body = sources.load(source), Body.default()
    found = following.errors(integrated(motion), motion, body)
    values = {**outcome.values, "runs": {**outcome.values["runs"], INTEGRATED: found}}
    return Outcome(values=values, pictures=outcome.pictures)


def integrated(motion: Motion) -> Motion:
    """A motion from its velocities alone, each constant over a frame, integrated in substeps.

    Algorithm 1 in plain numpy without obstacles: velocities of the joints and of the root's
    rotation lead from the actual to the reference pose, those of its position from one reference
    to the next.
    """
    asked, h = rot.exp(motion.rotations), 1.0 / motion.fps / SUBSTEPS
    turns, places = asked.copy(), motion.translation.copy()
    now, place = asked[0], places[0]
    for t in range(1, len(motion)):
        spin = rot.log(rot.multiply(rot.conjugate(now), asked[t])) * motion.fps
        velocity = (motion.translation[t] - motion.translation[t - 1]) * motion.fps
        for _ in range(SUBSTEPS):
            now = rot.multiply(now, rot.exp(spin * h))
            place = place + velocity * h
        turns[t], places[t] = now, place
    return motion.with_frames(places, rot.log(rot.normalize(turns)))


def _groups(options: Options) -> list[Group]:
    return [sources.dances(options), sources.daily(options), *sources.brought(options)]


def tasks(options: Options) -> list[Task]:
    """One task per motion."""
    shown = sources.QUICK_DANCES[0]
    return [
        task(
            group,
            source,
            RUNS,
            4.0 if pictured else 1.0,
            _SHOWN if pictured else "",
            ".sections.table1:follow",
        )
        for group in _groups(options)
        for source in group.sources
        for pictured in [group.key == "dance" and source.arguments["number"] == shown]
    ]


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """A row per group and setting; PHC+ as the paper quotes it."""
    rows = [
        Row(
            name="PHC+, a tracker trained for 7 days",
            data="AIST++ test set, 40 clips",
            figures=tuple(
                Figure(name=name, unit=unit, ours=None, paper=paper)
                for (name, unit), paper in zip(_MEASURES, published.PHC_PLUS, strict=True)
            ),
            note="quoted, not run here; its errors are of the runs that succeeded",
            quoted=True,
        )
    ]
    for group in _groups(options):
        for name, chosen in RUNS.items():
            rows.append(_row(group, name, said(chosen), values))
        setting = f"velocities integrated in plain numpy, {SUBSTEPS} substeps"
        rows.append(_row(group, INTEGRATED, setting, values))
    number = sources.QUICK_DANCES[0]
    picture = Picture(
        caption="Figure 3: a dance, here one made from a seed, is followed to its end",
        task=f"dance/{number:02d}",
        name=_SHOWN,
    )
    return Content(rows=tuple(rows), pictures=(picture,) if picture.task in values else ())


_MEASURES = (("success", "%"), ("MPJPE-g", "mm"), ("MPJPE", "mm"))


def _row(group: Group, name: str, setting: str, values: Mapping[str, Any]) -> Row:
    found = outcomes(values, group, name)
    whole, world, local = published.HALF_PHYSICS
    return Row(
        name=name,
        data=group.data,
        setting=setting,
        figures=(
            at_least(whole, success(found, group), name="success", unit="%", paper=whole),
            at_most(world, mean(found, "mpjpe_global"), name="MPJPE-g", unit="mm", paper=world),
            at_most(local, mean(found, "mpjpe"), name="MPJPE", unit="mm", paper=local),
        ),
        note=remarks(found, group),
    )


SECTION = Section(
    key="table1",
    title="Table 1: how exactly a motion is followed",
    about=(
        "With nothing in the way half-physics gives back the motion that it was given: the paper "
        "follows all 40 clips of the AIST++ test set to 0.003 mm, where a learned tracker falls in "
        "some of them and is some centimetres off in the others. Where nothing is near, ours puts "
        "everybody where velocities held for a frame take them, which is the next frame of the "
        "motion; beside it the same velocities are integrated step by step. Success: every frame "
        "came back, finite. MPJPE-g is the mean error of 55 joints in the world, MPJPE relative to "
        "the pelvis; means over clips."
    ),
    tasks=tasks,
    content=content,
)

"""Figure 8: a fast kick at a fixed ball, with limp joints and with firm ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from evidence.model import (
    Content,
    Figure,
    Options,
    Outcome,
    Picture,
    Plot,
    Row,
    Section,
    Series,
    Task,
    at_least,
    at_most,
)
from evidence.runs import choices, playing
from halfphysics.motion.skeleton import JOINT_INDEX

#: Speed of the foot as it meets the ball [m/s].
SPEED = 12.0
#: Values of lambda; those of the paper's figure are 0 and 1.
SWEEP = (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
QUICK_SWEEP = (0.0, 0.1, 1.0, 10.0)
#: Limp: the leg bends this much more than when firm [degrees; 17.2 are measured, 24.6 before limp
#: joints were damped], and the pelvis stays this near its
#: path [mm]. Firm: the leg bends at most this much, the body is displaced by at least this [mm],
#: and by this many times the displacement when limp.
BENDS, STAYS, STRAIGHT, DISPLACED, TIMES = 16.0, 50.0, 15.0, 100.0, 10.0
# The part of the knee curve that is drawn, before and after its largest error [s].
_ABOUT = 0.4
# Frames of the pictures, from the largest error of the foot.
_FRAMES, _QUICK_FRAMES = (-3, -1, 1, 4), (0, 3)


def kick(stiffness: float, speed: float, quick: bool, strip: bool) -> Outcome:
    """A kick at a fixed ball: errors of leg and body against the reference."""
    choice = {**choices.LIMP, "stiffness": stiffness}
    result = playing.play("kick_ball", {"fixed": True, "speed": speed}, choice)
    knee, hip = JOINT_INDEX["right_knee"], JOINT_INDEX["right_hip"]
    bend = [
        np.degrees(np.linalg.norm(m.rotations[:, knee], axis=1))
        for m in (result.motion, result.reference)
    ]
    turned = playing.joint_angles(result.reference, result.motion)
    away = 1e3 * playing.pelvis_distance(result)
    at = int(turned[:, knee].argmax())
    values = {
        "fps": result.fps,
        "at": at,
        "bend": bend[0].tolist(),
        "asked": bend[1].tolist(),
        "more": float((bend[0] - bend[1]).max()),
        "knee": float(turned[:, knee].max()),
        "hip": float(turned[:, hip].max()),
        "ankle": float(turned[:, JOINT_INDEX["right_ankle"]].max()),
        "root": float(away.max()),
        "deepest": playing.penetration(result, quick=quick).depth_max_mm,
    }
    frames = [at + f for f in (_QUICK_FRAMES if quick else _FRAMES)]
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick, frames=frames))


def _key(stiffness: float) -> str:
    return f"lambda-{stiffness:g}"


def tasks(options: Options) -> list[Task]:
    """One kick per lambda."""
    return [
        Task(
            key=_key(stiffness),
            function=".sections.figure8:kick",
            arguments={
                "stiffness": stiffness,
                "speed": SPEED,
                "quick": options.quick,
                "strip": stiffness in (0.0, 1.0),
            },
            seconds=0.5 if options.quick else 2.0,
        )
        for stiffness in (QUICK_SWEEP if options.quick else SWEEP)
    ]


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """A row per lambda; knee and root over time and over lambda."""
    sweep = [s for s in (QUICK_SWEEP if options.quick else SWEEP) if _key(s) in values]
    limp, firm = values.get(_key(0.0)), values.get(_key(1.0))
    rows = tuple(_row(s, values[_key(s)], limp, firm) for s in sweep)
    pictures = tuple(
        Picture(
            caption=f"Figure 8, lambda {s:g}: {what}. Blue: reference.",
            task=_key(s),
            name="strip",
        )
        for s, what in ((0.0, "the leg bends past the ball"), (1.0, "the body is displaced"))
        if _key(s) in values
    )
    return Content(rows=rows, plots=_plots(sweep, values), pictures=pictures)


def _row(stiffness: float, found: Mapping[str, Any], limp: Any, firm: Any) -> Row:
    figures = []
    if stiffness == 0.0:
        less = found["more"] - firm["more"] if firm else None
        figures = [
            Figure(name="knee bends more than the reference", unit="°", ours=found["more"]),
            at_least(BENDS, less, name="knee bends more than at lambda 1", unit="°"),
            at_most(STAYS, found["root"], name="pelvis from its place", unit="mm"),
        ]
    elif stiffness == 1.0:
        times = found["root"] / limp["root"] if limp else None
        figures = [
            at_most(STRAIGHT, found["more"], name="knee bends more than the reference", unit="°"),
            at_least(DISPLACED, found["root"], name="pelvis from its place", unit="mm"),
            at_least(TIMES, times, name="pelvis, of that at lambda 0"),
        ]
    else:
        figures = [
            Figure(name="knee bends more than the reference", unit="°", ours=found["more"]),
            Figure(name="pelvis from its place", unit="mm", ours=found["root"]),
        ]
    figures.append(Figure(name="turn of the hip", unit="°", ours=found["hip"]))
    figures.append(Figure(name="turn of the ankle", unit="°", ours=found["ankle"]))
    figures.append(at_most(0.0, found["deepest"], name="deepest", unit="mm"))
    return Row(
        name=f"stiffness {stiffness:g}",
        data=f"kick_ball fixed=True speed={SPEED:g}",
        setting=choices.said({**choices.LIMP, "stiffness": stiffness}),
        figures=tuple(figures),
    )


def _plots(sweep: list[float], values: Mapping[str, Any]) -> tuple[Plot, ...]:
    if not sweep:
        return ()
    names = [f"{s:g}" for s in sweep]
    found = [values[_key(s)] for s in sweep]
    plots = [
        Plot(
            title="How far the knee bends beyond the reference",
            x=("lambda", ""),
            y=("angle", "°"),
            series=(Series("knee", names, [v["more"] for v in found]),),
            kind="bars",
        ),
        Plot(
            title="How far the body is displaced",
            x=("lambda", ""),
            y=("pelvis from its place", "mm"),
            series=(Series("pelvis", names, [v["root"] for v in found]),),
            kind="bars",
        ),
    ]
    ends = [s for s in (0.0, 1.0) if s in sweep]
    if ends:
        first = values[_key(ends[0])]
        about = round(_ABOUT * first["fps"])
        kick = slice(max(0, first["at"] - about), first["at"] + about + 1)
        times = [round(t / first["fps"], 6) for t in range(len(first["asked"]))][kick]
        lines = [Series("reference", times, first["asked"][kick])]
        lines += [Series(f"lambda {s:g}", times, values[_key(s)]["bend"][kick]) for s in ends]
        plots.append(
            Plot(
                title="The knee of the leg that kicks",
                x=("time", "s"),
                y=("angle", "°"),
                series=tuple(lines),
            )
        )
    return tuple(plots)


SECTION = Section(
    key="figure8",
    title="Figure 8: stiffness",
    about="A fast kick at a ball that is fixed to the floor. With lambda 0 the leg bends past it "
    "and the body keeps its path; with lambda 1 the leg stays as it is and the whole body is "
    "displaced. Beyond the paper: all that lies between and beyond.",
    tasks=tasks,
    content=content,
)

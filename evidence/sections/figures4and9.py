"""Figures 4 and 9, and the scenes in the text of the paper: obstacles block, and only they do."""

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
from halfphysics import metrics
from halfphysics.motion.skeleton import JOINT_NAMES

#: Row -> its figure in the paper, the scenario and its options.
SCENES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "half the body through a doorway's wall": ("Figure 4", "doorway", {"right_jamb": -0.1}),
    "an arm through a door frame": ("Figure 4", "doorway", {}),
    "a leg through a coffee table": ("Figure 4", "leg_through_table", {}),
    "sinking into a sofa": ("Figure 4", "sit_on_sofa", {}),
    "leaning on a TV cabinet": ("Figure 9", "step_back_onto_cabinet", {}),
    "sitting on a bed's edge": ("Figure 9", "sit_on_bed", {}),
    "stretching on a bed": ("Figure 9", "stretch_on_bed", {}),
    "crawling under a table": ("text", "crawl_under_table", {}),
    "climbing onto a bed": ("text", "climb_onto_bed", {}),
    "flying with a ball": ("text", "fly_with_ball", {}),
}
#: The row that goes around the obstacle in its reference, so that its position is not judged.
AROUND = "half the body through a doorway's wall"
#: Intent kept: largest error of the pelvis [mm], and of joints without contact [degrees].
NEAR, TURNED = 100.0, 5.0
#: Smallest depth of the reference in the scene [mm], without which a zero of ours means little.
#: Held objects are exempt, because their positions come from our run.
ASKED, HELD = 10.0, "flying with a ball"
#: Largest slip of a ball between two palms in flight [mm].
SLIP = 20.0
#: When the ball has been taken [s].
_TAKEN = 1.0
#: In a quick report: the scene that is left out, and the scenes with pictures.
_LEFT_OUT = "an arm through a door frame"
_PICTURED = ("half the body through a doorway's wall", "sinking into a sofa")
#: Settings -> the end of a task's key.
_CHOICES = {"": choices.OURS, "/firm": choices.FIRM}


def scene(
    name: str, options: Mapping[str, Any], choice: Mapping[str, Any], strip: bool, quick: bool
) -> Outcome:
    """Simulate a scenario: penetration of the reference and of the result, and tracking errors."""
    result = playing.play(name, options, choice)
    motion, things, body = result.reference, result.scene, result.people[0].body
    # Positions of held objects come from our run: they say nothing about the reference.
    asked = metrics.penetration(motion[:: playing.EVERY if quick else 1], body, things)
    ours = playing.penetration(result, quick=quick)
    free = playing.free_joints(result)
    angle = np.where(free, playing.joint_angles(motion, result.motion), 0.0).max(axis=0)
    away = playing.pelvis_distance(result)
    values = {
        "frames": len(motion),
        "fps": motion.fps,
        "asked": _depths(asked),
        "ours": _depths(ours),
        "into": {k: float(v.max()) for k, v in asked.by_name.items() if v.max() > 0.0},
        "pelvis_mm": float(1e3 * away.max()),
        "free_joint": JOINT_NAMES[int(angle.argmax())],
        "free_deg": float(angle.max()),
        "lost_time": float(result.lost_time.sum()),
    }
    if "ball" in result.objects and name == "fly_with_ball":
        values["slip_mm"] = _slip(result)
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick))


def _depths(report: metrics.PenetrationReport) -> dict[str, float]:
    return {
        "rate": report.rate_percent,
        "mean_mm": report.depth_mean_mm,
        "max_mm": report.depth_max_mm,
    }


def _slip(result: Any) -> float:
    """Slip of the ball against the middle of both hands, once taken [mm]."""
    joints = result.people[0].body.joints(result.motion)
    hands = [joints[:, JOINT_NAMES.index(f"{side}_middle1")] for side in ("left", "right")]
    way = (result.objects["ball"].position - 0.5 * (hands[0] + hands[1]))[
        round(_TAKEN * result.fps) :
    ]
    return float(1e3 * np.linalg.norm(way - way[0], axis=1).max())


def tasks(options: Options) -> list[Task]:
    """Every scene with our defaults and, in a full report, with the setting of the paper."""
    found = []
    for row, (_, name, chosen) in SCENES.items():
        for end, choice in _CHOICES.items():
            if options.quick and (end or row == _LEFT_OUT):
                continue
            found.append(
                Task(
                    key=_key(row) + end,
                    function=".sections.figures4and9:scene",
                    arguments={
                        "name": name,
                        "options": chosen,
                        "choice": choice,
                        "strip": not end and (row in _PICTURED or not options.quick),
                        "quick": options.quick,
                    },
                    seconds=1.2 if options.quick else 4.0,
                )
            )
    return found


def _key(row: str) -> str:
    return "".join(c for c in row.replace(" ", "-") if c.isalnum() or c == "-").lower()


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """A row and a strip per scene; depths of the references and of the results side by side."""
    rows, pictures = [], []
    for name, (figure, scenario, chosen) in SCENES.items():
        for end, choice in _CHOICES.items():
            found = values.get(_key(name) + end)
            if found is None:
                continue
            rows.append(_row(name, figure, scenario, chosen, choice, found))
            if not end and (name in _PICTURED or not options.quick):
                caption = f"{figure}: {name}. Blue: reference; solid: half-physics."
                pictures.append(Picture(caption=caption, task=_key(name), name="strip"))
    shown = [n for n in SCENES if values.get(_key(n), {}).get("into")]
    plots = []
    if shown:
        deepest = {
            label: [values[_key(n)][which]["max_mm"] for n in shown]
            for label, which in (("reference", "asked"), ("half-physics", "ours"))
        }
        plots.append(
            Plot(
                title="How deep the skin goes into the furniture at most",
                x=("scene", ""),
                y=("depth", "mm"),
                series=tuple(Series(label, shown, depth) for label, depth in deepest.items()),
                kind="bars",
            )
        )
    return Content(rows=tuple(rows), plots=tuple(plots), pictures=tuple(pictures))


def _row(
    name: str,
    figure: str,
    scenario: str,
    chosen: Mapping[str, Any],
    choice: Mapping[str, Any],
    found: Mapping[str, Any],
) -> Row:
    asked, ours = found["asked"], found["ours"]
    deepest = Figure(name="deepest, reference", unit="mm", ours=asked["max_mm"])
    if name != HELD:
        deepest = at_least(ASKED, deepest.ours, name=deepest.name, unit=deepest.unit)
    figures = [
        Figure(name="penetration rate, reference", unit="%", ours=asked["rate"]),
        deepest,
        at_most(0.0, ours["rate"], name="penetration rate", unit="%"),
        at_most(0.0, ours["max_mm"], name="deepest", unit="mm"),
    ]
    if name == AROUND:
        figures.append(Figure(name="pelvis from its place", unit="mm", ours=found["pelvis_mm"]))
    else:
        figures.append(at_most(NEAR, found["pelvis_mm"], name="pelvis from its place", unit="mm"))
    figures.append(at_most(TURNED, found["free_deg"], name="error of free joints", unit="°"))
    figures.append(at_most(0.0, found["lost_time"], name="lost time", unit="s"))
    if "slip_mm" in found:
        figures.append(at_most(SLIP, found["slip_mm"], name="the ball slips", unit="mm"))
    words = [f"{key}={value}" for key, value in chosen.items()]
    into = ", ".join(f"{k} {v:.0f} mm" for k, v in found["into"].items())
    return Row(
        name=f"{figure}: {name}",
        data=" ".join([scenario, *words]),
        setting=choices.said(choice),
        figures=tuple(figures),
        note=f"the reference goes into: {into}" if into else "",
    )


SECTION = Section(
    key="figures4and9",
    title="Figures 4 and 9: scenes",
    about="Motions that go into walls and furniture: each is stopped where it meets something, "
    "and what meets nothing goes on as intended. The paper shows pictures; here is also how deep "
    "the reference goes and how deep ours, how far the pelvis is from its place, "
    "and the largest error of a joint that no contact can have turned.",
    tasks=tasks,
    content=content,
)

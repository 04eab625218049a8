"""Figure 5: objects are held, kicked and dropped according to their mass and friction."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from evidence.model import (
    Content,
    Figure,
    Options,
    Picture,
    Plot,
    Row,
    Section,
    Series,
    Task,
    at_least,
    at_most,
    between,
)
from evidence.runs import choices
from evidence.runs.handling import GRAVITY, Values

#: Largest slip [mm] and rotation [degrees] of a glass in the hand.
GLASS_SLIP, GLASS_TURN = 10.0, 15.0
#: Largest error of a fall against gravity [m/s^2], and time until an opening hand is free [s].
FALL, FREED = 0.05, 0.2
#: Largest slip of a suitcase over the palms, and its largest lag behind the hands [mm].
CASE_SLIP, BEHIND = 10.0, 20.0
#: An object without contact of the person may settle by this [m]: a millionth of a millimetre.
STILL = 1e-9
#: Of an easy kick the ball gets about the speed of the foot, 5.5 m/s; a foot as fast as this lifts
#: it clear of the floor, by more than its radius.
KICKED, FAST, AIR = (4.0, 7.0), 12.0, 0.11
#: A ball of 200 kg is at most this much as fast as one of 0.5 kg, and the foot turns past it.
SLOWER, FOOT = 0.2, 45.0
#: A suitcase of 200 kg moves less than this [mm] and fingers bend more than this [degrees]; a
#: slippery one rises less than that [mm].
STAYS, BENT, SLIPPED = 0.01, 25.0, 10.0
#: How far a drawer opens [m], a lid closes and a door opens [degrees].
DRAWER, LID, DOOR = 0.25, 1.0, 60.0


def _missed(name: str, unit: str, expected: str) -> Figure:
    """A figure of an event that never happens: not reproduced."""
    return Figure(name=name, unit=unit, ours=None, expected=expected, reproduced=False)


def _held(v: Values, _: Values) -> list[Figure]:
    return [
        at_most(GLASS_SLIP, v["slip"], name="slip in the hand", unit="mm"),
        at_most(GLASS_TURN, v["turn"], name="turn in the hand", unit="°"),
        Figure(name="normal forces", unit="N", ours=v["force"]),
    ]


def _falls(v: Values, _: Values) -> list[Figure]:
    figures = [at_most(GLASS_SLIP, v["slip"], name="slip in the hand", unit="mm")]
    low, high = GRAVITY - FALL, GRAVITY + FALL
    if v["freed"] is None:
        expected = f"at most {FREED:g}"
        return [*figures, _missed("free after opening", "s", expected)]
    figures.append(at_most(FREED, v["freed"], name="free after opening", unit="s"))
    return [*figures, between(low, high, v["fall"], name="acceleration of the fall", unit="m/s²")]


def _lifted(v: Values, _: Values) -> list[Figure]:
    behind = abs(v["rise"] - v["hands"])
    return [
        Figure(name="rise", unit="mm", ours=v["rise"]),
        at_most(BEHIND, behind, name="rise, less that of the hands", unit="mm"),
        at_most(CASE_SLIP, v["slip"], name="slip", unit="mm"),
    ]


def _kicked(v: Values, _: Values) -> list[Figure]:
    return [between(*KICKED, v["speed"], name="speed of the ball", unit="m/s")]


def _flies(v: Values, _: Values) -> list[Figure]:
    return [
        Figure(name="speed of the ball", unit="m/s", ours=v["speed"]),
        at_least(AIR, v["height"], name="height of the flight", unit="m"),
    ]


def _untouched(v: Values, _: Values) -> list[Figure]:
    return [
        at_most(1e9 * STILL, 1e9 * v["moved"], name="moved", unit="nm"),
        at_most(0, v["different"], name="numbers unlike those with nobody moving"),
    ]


def _too_heavy_to_kick(v: Values, light: Values) -> list[Figure]:
    share = v["speed"] / light["speed"] if light else None
    return [
        Figure(name="speed of the ball", unit="m/s", ours=v["speed"]),
        at_most(SLOWER, share, name="speed, of that of 0.5 kg"),
        at_least(FOOT, v["ankle"], name="bend of the ankle", unit="°"),
    ]


def _too_heavy_to_lift(v: Values, _: Values) -> list[Figure]:
    return [
        at_most(STAYS, v["moved"], name="moved", unit="mm"),
        at_least(BENT, v["fingers"], name="bend of a finger", unit="°"),
    ]


def _slips(v: Values, _: Values) -> list[Figure]:
    return [
        at_most(SLIPPED, v["highest"], name="highest", unit="mm"),
        Figure(name="last touch", unit="s", ours=v["held_until"]),
    ]


def _opened(v: Values, _: Values) -> list[Figure]:
    return [at_least(DRAWER, v["end"], name="drawn out", unit="m")]


def _closed(v: Values, _: Values) -> list[Figure]:
    return [at_most(LID, np.degrees(v["end"]).item(), name="lid open", unit="°")]


def _swung(v: Values, _: Values) -> list[Figure]:
    return [at_least(DOOR, np.degrees(v["end"]).item(), name="door open", unit="°")]


@dataclass(frozen=True, kw_only=True)
class Case:
    """One part of the figure.

    Attributes:
        figure: Its letter.
        name: The event.
        run: Function of `handling`.
        options: Options of the scenario.
        judge: Makes figures from its values and those of the case `against`, if there is one.
        quick: Options in a quick report.
        extra: Further arguments of `run`.
        grip: Friction holds the object: shown with the setting of the paper at 120 fps too.
        beyond: The paper has no such case, and so no setting for it.
        strip: Whether it has a picture.
    """

    figure: str
    name: str
    run: str
    options: Values = field(default_factory=dict)
    judge: Callable[[Values, Values], list[Figure]]
    quick: Values = field(default_factory=dict)
    extra: Values = field(default_factory=dict)
    against: str = ""
    grip: bool = False
    beyond: bool = False
    strip: bool = False

    @property
    def said(self) -> str:
        """The scenario and its options."""
        words = [f"{k}={v}" for k, v in self.options.items()]
        return " ".join([self.extra.get("scenario", _SCENARIO.get(self.run, "")), *words])


_SCENARIO = {
    "grasp": "grasp_glass",
    "drop": "place_glass",
    "lift": "lift_suitcase",
    "kick": "kick_ball",
    "monitor": "reach_past_monitor",
}
#: Stiffness that Algorithm 1 needs to hold objects at 30 frames/s.
_SOFT: choices.Choice = {**choices.LIMP, "stiffness": 0.1}
_BRIEF = {"carry": 1.0, "shake": 0.0}
_FEW_STAGES = {"stages": ["lift", "shake", "open"]}

#: By the key of their tasks.
CASES = {
    "grasp": Case(
        figure="5a",
        name="a glass in one hand: lifted, shaken, carried, turned over",
        run="grasp",
        judge=_held,
        quick=_FEW_STAGES,
        grip=True,
        strip=True,
    ),
    "drop": Case(
        figure="5b",
        name="a wine glass is let go where the table has gone",
        run="drop",
        options={"shape": "wine"},
        judge=_falls,
        grip=True,
        strip=True,
    ),
    "lift": Case(
        figure="5c",
        name="a suitcase between two palms: lifted, carried, shaken",
        run="lift",
        judge=_lifted,
        quick=_BRIEF,
        grip=True,
        strip=True,
    ),
    "wine": Case(
        figure="5d",
        name="more objects: a wine glass",
        run="grasp",
        options={"shape": "wine"},
        judge=_held,
        quick=_FEW_STAGES,
        grip=True,
    ),
    "drawer": Case(
        figure="5d",
        name="more objects: a drawer is opened",
        run="jointed",
        judge=_opened,
        extra={"scenario": "open_drawer", "joint": "chest/top_rail"},
        beyond=True,
    ),
    "laptop": Case(
        figure="5d",
        name="more objects: a laptop is closed",
        run="jointed",
        judge=_closed,
        extra={"scenario": "close_laptop", "joint": "laptop/hinge"},
        beyond=True,
    ),
    "door": Case(
        figure="5d",
        name="more objects: a door is pushed open",
        run="jointed",
        judge=_swung,
        extra={"scenario": "push_door", "joint": "door/hinge"},
        beyond=True,
    ),
    "kick": Case(
        figure="5e",
        name="a ball of 500 g is kicked",
        run="kick",
        options={"mass": 0.5},
        judge=_kicked,
    ),
    "monitor": Case(
        figure="5f", name="a monitor that nobody touches stays", run="monitor", judge=_untouched
    ),
    "fast": Case(
        figure="5g",
        name="a fast kick lifts the ball",
        run="kick",
        options={"mass": 0.5, "speed": FAST},
        judge=_flies,
        strip=True,
    ),
    "heavy": Case(
        figure="5h",
        name="a ball of 200 kg hardly moves",
        run="kick",
        options={"mass": 200.0},
        judge=_too_heavy_to_kick,
        against="kick",
        strip=True,
    ),
    "stays": Case(
        figure="5i",
        name="a suitcase of 200 kg stays",
        run="lift",
        options={"mass": 200.0},
        judge=_too_heavy_to_lift,
        quick=_BRIEF,
    ),
    "slips": Case(
        figure="5j",
        name="a suitcase of friction 0.1 slips away",
        run="lift",
        options={"friction": 0.1},
        judge=_slips,
        quick=_BRIEF,
    ),
}
_PRESSED = "limp joints press less, or less evenly, than what our authored hands hold needs"
#: In a quick report: cases that are left out, and cases with pictures.
_LEFT_OUT = ("wine", "drawer", "laptop")
_PICTURED = ("drop", "heavy")


def _variants(case: Case, quick: bool) -> Iterator[tuple[str, choices.Choice, Values]]:
    """End of the key, settings and options: with our drive, and with the setting of the paper.

    Friction holds better at a higher frame rate and with stiffer joints: both are shown.
    """
    yield "", choices.OURS, {}
    if quick or case.beyond:
        return
    yield "/limp", choices.LIMP, {}
    if case.grip:
        yield "/limp-120", choices.LIMP, {"fps": 120.0}
        yield "/soft", _SOFT, {}


def tasks(options: Options) -> list[Task]:
    """Every case with our defaults and, in a full report, with the setting of the paper."""
    found = []
    for key, case in CASES.items():
        if options.quick and key in _LEFT_OUT:
            continue
        for end, choice, more in _variants(case, options.quick):
            chosen = {**case.options, **(case.quick if options.quick else {}), **more}
            arguments = {
                **case.extra,
                "options": chosen,
                "choice": choice,
                "strip": _pictured(key, end, options.quick),
                "quick": options.quick,
            }
            seconds = 6.0 if more else 1.0 if options.quick else 3.0
            found.append(
                Task(
                    key=key + end,
                    function=f".runs.handling:{case.run}",
                    arguments=arguments,
                    seconds=seconds,
                )
            )
    return found


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """A row per case and setting; speeds of the balls."""
    rows, pictures = [], []
    for key, case in CASES.items():
        for end, choice, more in _variants(case, options.quick):
            found = values.get(key + end)
            if found is None:
                continue
            figures = case.judge(found, values.get(case.against + end, {}))
            figures.append(at_most(0.0, found["deepest"], name="deepest", unit="mm"))
            rows.append(
                Row(
                    name=f"Figure {case.figure}: {case.name}",
                    data=" ".join([case.said, *(f"{k}={v:g}" for k, v in more.items())]),
                    setting=choices.said(choice),
                    figures=tuple(figures),
                    note=_PRESSED if case.grip and end.startswith("/limp") else "",
                )
            )
            if _pictured(key, end, options.quick):
                caption = f"Figure {case.figure}: {case.name}. Blue: reference."
                pictures.append(Picture(caption=caption, task=key, name="strip"))
    return Content(rows=tuple(rows), plots=_plots(options, values), pictures=tuple(pictures))


def _pictured(key: str, end: str, quick: bool) -> bool:
    return CASES[key].strip and not end and (key in _PICTURED or not quick)


def _plots(options: Options, values: Mapping[str, Any]) -> tuple[Plot, ...]:
    shown = [key for key in ("kick", "fast", "heavy") if key in values]
    if not shown:
        return ()
    series = []
    for key in shown:
        speeds = values[key]["speeds"]
        times = [round((t + 0.5) / values[key]["fps"], 6) for t in range(len(speeds))]
        series.append(Series(CASES[key].name, times, speeds))
    return (
        Plot(
            title="How fast the ball goes",
            x=("time", "s"),
            y=("speed", "m/s"),
            series=tuple(series),
        ),
    )


SECTION = Section(
    key="figure5",
    title="Figure 5: objects",
    about="What a person holds is held by friction, falls when it is let go, and gets the speed "
    "that its mass allows; what nobody touches stays; what is too heavy or too smooth makes the "
    "body give instead. The paper shows pictures at stiffness 0; each is a number here.",
    tasks=tasks,
    content=content,
)

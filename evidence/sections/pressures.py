"""Pressures of people who lie and sit on foam, beside what is published."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evidence.interface_pressures import rows
from evidence.model import Content, Figure, Options, Row, Section, Task, between

#: Posture -> its data, in words.
POSTURES = {
    "lying": "scenario stretch_on_bed, its mattress of the material 'mattress'",
    "sitting": "scenario sit_on_sofa, its seat and rest of the material 'sofa'",
}


def tasks(options: Options) -> list[Task]:
    """Both postures; they are quick."""
    return [
        Task(
            key=posture,
            function=".runs.lying:measure",
            arguments={"posture": posture},
            seconds=4.0,
        )
        for posture in POSTURES
    ]


def content(options: Options, values: Mapping[str, Any]) -> Content:
    """A row for each published measure, with its source."""
    out = []
    for posture, data in POSTURES.items():
        found = values.get(posture)
        if found is None:
            continue
        for one in rows(posture):
            figure = between(one.low, one.high, found[one.measure], name=one.measure, unit=one.unit)
            out.append(
                Row(
                    name=f"{posture}: {one.measure}",
                    data=data,
                    setting="Settings()",
                    figures=(figure,),
                    note=f"{one.how}. {one.source}",
                )
            )
        if "share of the weight" in found:
            out.append(
                Row(
                    name=f"{posture}: what the mattress carries",
                    data=data,
                    setting="Settings()",
                    figures=(_whole(found["share of the weight"]),),
                )
            )
    return Content(rows=tuple(out))


def _whole(share: float) -> Figure:
    return between(99.0, 101.0, share, name="share of the weight", unit="%")


SECTION = Section(
    key="pressures",
    title="Pressures on foam",
    about="The paper has rigid bodies only. Here a person lies on a mattress and sits on a sofa of "
    "foam with the values of its material; pressures and areas are judged by what is published of "
    "people on mats of sensors, whose sources stand in the notes.",
    tasks=tasks,
    content=content,
)

"""What the two halves of the picture show when the browser compares (player/compare.js)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.arrange import floor_height
from halfphysics.viewer.figure import Figure
from halfphysics.viewer.motions import is_untouched
from halfphysics.viewer.stage import Stage

#: Node below which the references of a stage are; hidden, except in a half of a picture.
REFERENCE = "reference"
# Nodes of a stage that only one of two results has, beside its statics.
_OWN = ("person", "ghost", "object", "contact", "support", "label", "edges")


class References:
    """The people of a stage as their references move, drawn like the simulated ones.

    Args:
        server: The viser server.
        stage: The stage; it calls `show` from then on.
        on: Whether poses are sent.
    """

    def __init__(self, server: Any, stage: Stage, on: bool = False) -> None:
        self.on = on
        self._stage = stage
        self._frame = 0
        self._frames = []
        self._figures: list[Figure] = []
        self.node = server.scene.add_frame(stage.path(REFERENCE), show_axes=False, visible=False)
        for k, person in enumerate(stage.drawing.result.people):
            frames = person.body.joint_frames(person.recorded)
            name = stage.path(f"{REFERENCE}/{k}")
            skin = stage.drawing.skin(k, False)
            self._figures.append(
                Figure(server, name, skin, person.body, stage.people[k].joints, person=k)
            )
            self._frames.append(frames)
        stage.followers.append(self.show)

    def show(self, frame: int) -> None:
        """Pose the people of a frame."""
        self._frame = frame
        if not self.on:
            return
        for figure, (positions, quaternions) in zip(self._figures, self._frames, strict=True):
            figure.pose(positions[frame], quaternions[frame])

    def switch(self, on: bool) -> None:
        """Send poses from now on, or none."""
        self.on = on
        self.show(self._frame)


def has_reference(drawing: Drawing) -> bool:
    """Whether there is a reference to compare with: not of a motion alone."""
    return not is_untouched(drawing.result)


def choices(stages: Sequence[Stage], labels: Sequence[str]) -> list[dict[str, Any]]:
    """The comparisons that the browser offers.

    One result: reference and simulated. Several: each with the next, in the place of the former.
    """
    if len(stages) == 1:
        (stage,) = stages
        if not has_reference(stage.drawing):
            return []
        hidden = [stage.path(name) for name in ("ghost", "contact", "support")]
        reference = {
            "label": "reference",
            "hide": [*hidden, stage.path("person")],
            "show": [stage.path(REFERENCE)],
        }
        return [{"a": reference, "b": {"label": "simulated", "hide": [stage.path("ghost")]}}]
    return [
        {
            "a": {"label": labels[k], "hide": _hidden(second, first)},
            "b": {
                "label": labels[k + 1],
                "hide": _hidden(first, second),
                "move": _moved(second, first),
            },
        }
        for k, (first, second) in enumerate(pairwise(stages))
    ]


def _hidden(stage: Stage, shown: Stage) -> list[str]:
    """The nodes to hide of a stage where another one is shown: all but a floor that both have."""
    statics = [
        stage.path(name)
        for name, item in stage.drawing.statics.items()
        if floor_height(item) is None or _has_floor(shown)
    ]
    return [stage.path(name) for name in _OWN] + statics


def _has_floor(stage: Stage) -> bool:
    """Whether a stage draws a floor of its own: of results on one level only the first does."""
    floors = [n for n, item in stage.drawing.statics.items() if floor_height(item) is not None]
    return any(stage.draws(name.removeprefix("static/")) for name in floors)


def _moved(stage: Stage, to: Stage) -> dict[str, list[float]]:
    """The parent node of a stage -> the place of another stage."""
    return {stage.prefix: [float(x) for x in to.offset]} if stage.prefix else {}

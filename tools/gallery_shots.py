"""How each built-in scenario is shown in docs/scenarios.md: which moments, seen from where.

Kept apart from `make_gallery.py`, which draws them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from halfphysics import Result
from halfphysics.base.rotations import rotate
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.viewpoint import FOV, cameras, choose_direction


@dataclass(frozen=True, kw_only=True)
class Shot:
    """Moments of a story and a point of view.

    Attributes:
        times: What is shown [s]; seconds of the story, not frames.
        turn: Where from, around the first person as they face at the start [degrees]: 0 is their
            front, 90 their left; None: chosen by the program.
        height: How far above the horizon [degrees].
        near: A joint of the first person, or an object, to look closely at; empty: everybody.
        reach: How far around it is in the picture [m].
    """

    times: tuple[float, ...]
    turn: float | None = None
    height: float = 16.0
    near: str = ""
    reach: float = 0.5

    def frames(self, result: Result) -> list[int]:
        """The frames of its moments."""
        last = len(result) - 1
        return [min(round(time * result.fps), last) for time in self.times]

    def views(self, result: Result, size: tuple[int, int]) -> list[Camera]:
        """A camera for each of its moments."""
        drawing, frames = Drawing(result), self.frames(result)
        if self.turn is None:
            towards = choose_direction(drawing, frames, size)
        else:
            towards = _direction(result, self.turn, self.height)
        if not self.near:
            return cameras(drawing, frames, towards, size)
        return [
            Camera.framing(
                _place(result, self.near, frame) + self.reach * np.vstack([np.eye(3), -np.eye(3)]),
                towards,
                size=size,
                fov=FOV,
            )
            for frame in frames
        ]


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A part of the README's film, beside the others.

    Attributes:
        name: Of the scenario.
        start: Where in the story it begins [s].
        camera: One of `halfphysics.render.film.CAMERAS`.
        width: [pixels].
        key: Say which body is which.
    """

    name: str
    start: float
    camera: str
    width: int
    key: bool = False


def _direction(result: Result, turn: float, height: float) -> np.ndarray:
    person = result.people[0]
    front = rotate(person.body.joint_frames(person.motion)[1][0, 0], np.array([0.0, 0.0, 1.0]))
    around = np.arctan2(front[1], front[0]) + np.radians(turn)
    up = np.radians(height)
    return np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])


def _place(result: Result, name: str, frame: int) -> np.ndarray:
    if name in JOINT_NAMES:
        person = result.people[0]
        return person.body.joints(person.motion)[frame, JOINT_NAMES.index(name)]
    return np.asarray(result.objects[name].position[frame])


#: Scenario -> what is shown of it.
SHOTS = {
    "ball_on_cushion": Shot(times=(0.1, 0.4, 0.5, 2.5), turn=300.0),
    "climb_onto_bed": Shot(times=(0.6, 1.7, 2.9, 4.2)),
    "close_drawer": Shot(times=(0.8, 1.6, 2.1, 2.7), turn=245.0, height=20.0),
    "close_laptop": Shot(
        times=(0.8, 1.6, 2.3, 3.0), turn=275.0, height=24.0, near="laptop/base", reach=0.55
    ),
    "crawl_under_table": Shot(times=(1.5, 3.1, 4.0, 5.0)),
    "doorway": Shot(times=(1.9, 2.4, 3.1, 5.5), turn=300.0),
    "fly_with_ball": Shot(times=(0.3, 1.2, 2.8, 4.4)),
    "grasp_glass": Shot(
        times=(1.0, 1.8, 3.0, 13.5), turn=20.0, near="right_wrist", height=12.0, reach=0.45
    ),
    "jump_on_bed": Shot(times=(1.1, 1.75, 2.1, 4.0), turn=300.0),
    "kick_ball": Shot(times=(2.6, 3.1, 3.2, 3.3)),
    "leg_through_table": Shot(times=(2.2, 2.7, 3.3, 4.6)),
    "lift_suitcase": Shot(times=(0.0, 3.0, 6.3, 9.4), turn=300.0),
    "meet": Shot(times=(1.2, 1.9, 2.4, 3.5)),
    "open_drawer": Shot(times=(0.8, 1.6, 2.6, 3.6), turn=245.0, height=20.0),
    "open_laptop": Shot(
        times=(0.8, 1.9, 2.8, 4.0), turn=275.0, height=24.0, near="laptop/base", reach=0.55
    ),
    "place_glass": Shot(times=(1.8, 3.5, 6.6, 8.2), turn=20.0),
    "push_door": Shot(times=(0.6, 1.5, 1.9, 2.6), turn=225.0),
    "reach_past_monitor": Shot(times=(0.0, 0.9, 1.6, 2.4), turn=225.0, height=24.0),
    "shake_hands": Shot(
        times=(2.6, 3.1, 3.6, 3.9), turn=270.0, near="right_wrist", height=10.0, reach=0.55
    ),
    "sit_on_bed": Shot(times=(0.4, 1.6, 2.9, 4.4)),
    "sit_on_sofa": Shot(times=(0.8, 2.2, 3.4, 4.2)),
    "squeeze_pillow": Shot(times=(0.0, 1.0, 2.6, 4.6), turn=300.0),
    "step_back_onto_cabinet": Shot(times=(0.6, 2.4, 3.2, 4.6)),
    "stretch_on_bed": Shot(times=(0.3, 1.5, 2.2, 4.5), turn=50.0, height=28.0),
    "walk_into_wall": Shot(times=(1.2, 1.9, 2.6, 4.2)),
}

#: The README's film, from left to right.
CLIPS = (
    Clip(name="sit_on_sofa", start=0.6, camera="fixed", width=270),
    Clip(name="meet", start=1.15, camera="fixed", width=360),
    Clip(name="lift_suitcase", start=1.5, camera="follow", width=270, key=True),
)

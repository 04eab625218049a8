"""The cases of `campaigns.ground`: scenarios, rooms, sunk and floating clips, pushes."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.geometry.shapes import Box, Cylinder
from halfphysics.motion.motion import Motion
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from support.ground.minute import long_walk, room
from support.rooms import furnished

#: Frames per second of clips, whatever their own [1/s].
FPS = 30.0
#: How clips are displaced: name -> height [m].
HEIGHTS = {"-30mm": -0.03, "-10mm": -0.01, "+10mm": 0.01, "+30mm": 0.03}
#: Tilt of a whole clip [rad].
TILT = np.deg2rad(2.0)
#: Stairs: rise and tread [m], and treads to each side of the start.
RISE, TREAD, TREADS = 0.10, 0.40, 8
#: Walks into things: speed [m/s], where they stand [m], friction of boxes.
SPEED, AHEAD, FRICTION = 1.2, 2.0, 0.3
BOXES = {"box20": 20.0, "box80": 80.0, "box200": 200.0}
PUSHES = (*BOXES, "wall", "jamb")
#: Seeds of rooms for a long walk.
LONG_SEEDS = (1, 2, 3)
#: How far a shaken case's motions are moved along the ground [m]: contact makes other runs of it,
#: no worse or better ones. Each shake goes another way, by the golden angle [rad].
SHAKEN, GOLDEN = 0.004, np.pi * (3.0 - np.sqrt(5.0))


@dataclass(frozen=True)
class Case:
    """One run: a kind, the clip, scenario or thing, how it is displaced or the room's seed.

    `shake`: 0, or the number of a small shift of all motions.
    """

    kind: str
    what: str
    how: str = ""
    shake: int = 0

    @property
    def id(self) -> str:
        name = "-".join(text for text in (self.kind, self.what, self.how) if text)
        return f"{name}~{self.shake}" if self.shake else name


@cache
def body() -> Body:
    return Body.default()


def clip_names(data):
    return sorted(p.stem for p in (data / "motion").iterdir() if p.suffix in (".npz", ".bvh"))


@cache
def clip(data, name) -> Motion:
    """A real clip at 30 fps, its lowest vertex at z = 0."""
    path = next(p for p in (data / "motion").iterdir() if p.stem == name and p.suffix != ".txt")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)  # matched BVH joints
        motion = Motion.load(path)
    return motion.resample(FPS).grounded(body(), z=0.0)


def all_cases(data, shakes=0) -> list[Case]:
    """Scenarios, pushes, displaced clips, rooms, long walks; those that need no data without it.

    Each as it is, or in its place `shakes` times, shaken.
    """
    cases = _cases(data)
    return [replace(c, shake=k) for c in cases for k in range(1, shakes + 1)] if shakes else cases


def _cases(data):
    cases = [Case("scenario", name) for name in scenarios.names()]
    cases += [Case("push", what) for what in PUSHES]
    if data is None:
        return cases
    names = clip_names(data)
    cases += [Case("sunk", name, how) for how in (*HEIGHTS, "tilt", "stairs") for name in names]
    cases += [Case("room", name, str(seed)) for seed, name in enumerate(names)]
    cases += [Case("long", "room", str(seed)) for seed in LONG_SEEDS]
    return cases


def set_up(case: Case, data):
    """Motions, scene and bodies of a case."""
    motions, scene, bodies = _set_up(case, data)
    if not case.shake:
        return motions, scene, bodies
    angle = case.shake * GOLDEN
    by = SHAKEN * np.array([np.cos(angle), np.sin(angle), 0.0])
    shaken = [m.with_frames(m.translation + by, m.rotations) for m in motions]
    return tuple(shaken), scene, bodies


def _set_up(case, data):
    if case.kind == "scenario":
        story = scenarios.load(case.what)
        return story.motions, story.scene, story.bodies
    if case.kind == "push":
        scene = stage.floor()
        put(scene, case.what)
        plan = Walk(distance=2.0 * AHEAD, speed=SPEED)
        return (walk(body(), plan, FPS),), scene, (body(),)
    if case.kind == "long":
        clips = {name: clip(data, name) for name in clip_names(data)}
        motion, sits = long_walk(clips, body(), int(case.how), FPS)
        return (motion,), room(motion, sits, body(), data / "meshes", int(case.how)), (body(),)
    motion = clip(data, case.what)
    if case.kind == "room":
        motion = motion.grounded(body(), z=0.002)
        scene = furnished(motion, body(), data / "meshes", int(case.how))
        return (motion,), scene, (body(),)
    scene = stage.floor()
    if case.how == "tilt":
        motion = tilted(motion)
    elif case.how == "stairs":
        motion, scene = upstairs(motion)
    else:
        motion = lifted(motion, np.full(len(motion), HEIGHTS[case.how]))
    return (motion,), scene, (body(),)


def put(scene, what) -> None:
    """Add what a person walks into, AHEAD of them."""
    if what in BOXES:
        scene.add_object(
            what, Box((0.6, 0.6, 1.0)), mass=BOXES[what], friction=FRICTION,
            position=(AHEAD, 0.0, 0.5),
        )  # fmt: skip
    elif what == "wall":
        scene.add_static(what, Box((0.1, 3.0, 2.4)), position=(AHEAD, 0.0, 1.2))
    else:
        scene.add_static(what, Cylinder(0.05, 2.4), position=(AHEAD, 0.2, 1.2))


def lifted(motion: Motion, height) -> Motion:
    """The motion raised by heights (T,) [m]."""
    translation = motion.translation.copy()
    translation[:, 2] += height
    return motion.with_frames(translation, motion.rotations)


def tilted(motion: Motion, angle: float = TILT) -> Motion:
    """The whole clip turned about a horizontal axis through the floor under its first pelvis."""
    turn = rot.exp([angle, 0.0, 0.0])
    root = motion.axes @ body().rest_joints[0]
    pelvis = motion.translation + root
    pivot = np.array([*pelvis[0, :2], 0.0])
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(turn, rot.exp(rotations[:, 0])))
    return motion.with_frames(rot.rotate(turn, pelvis - pivot) + pivot - root, rotations)


def upstairs(motion: Motion):
    """The clip lifted along the slope of stairs, as an estimator has it, and those stairs.

    They rise along the clip's longest way; feet are up to half a rise off the treads.
    """
    pelvis = (motion.translation + motion.axes @ body().rest_joints[0])[:, :2]
    way = pelvis - pelvis[0]
    along = way[np.linalg.norm(way, axis=1).argmax()]
    along = along / max(np.linalg.norm(along), 1e-9)
    scene = stage.floor()
    turn = rot.exp([0.0, 0.0, np.arctan2(along[1], along[0])])
    base = RISE * (TREADS + 1)  # the tread of the start, above the floor
    for k in range(-TREADS, TREADS + 1):
        top = base + k * RISE
        at = pelvis[0] + along * (k * TREAD)
        scene.add_static(
            f"tread{k + TREADS}", Box((TREAD, 3.0, top)), position=(*at, 0.5 * top), quaternion=turn
        )
    return lifted(motion, base + RISE / TREAD * (way @ along)), scene

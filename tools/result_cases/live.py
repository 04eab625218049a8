"""The simulator one frame at a time: live edits, states, things held, joints and trajectories."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import frame_values, frames_values, result_values
from result_cases.scenes import body, bowling, clip, floor, furnished, moved, standing

#: Edits of a running simulation: frame -> what is done before it.
Edits = Mapping[int, Callable[[hp.Simulator], Any]]

DOOR = """<mujoco><worldbody><body name="frame">
<geom type="box" pos="-0.06 0 1" size=".03 .05 1"/>
<body name="panel">
  <joint name="hinge" axis="0 0 1" range="-5 100" damping="0.5"/>
  <geom type="box" pos=".45 0 1" size=".44 .02 .98" mass="20"/>
  <geom type="sphere" pos=".85 -.05 1" size=".03" mass=".1"/>
</body></body></worldbody></mujoco>"""

CABINET = """<mujoco><worldbody>
<geom name="case" type="box" pos=".3 0 .4" size=".02 .3 .4"/>
<body name="drawer" pos="0 0 1.0"><joint name="rail" type="slide" axis="1 0 0" range="-.4 0"/>
<geom type="box" pos=".12 0 0" size=".15 .2 .08" mass="4"/></body></worldbody></mujoco>"""

PENDULUM = """<mujoco><worldbody><body name="arm" pos="0 0 1.6">
<joint name="ball" type="ball" damping="0.02"/>
<geom type="capsule" fromto="0 0 0 0 0 -.5" size=".03" mass="1"/>
<body name="tip" pos="0 0 -.5"><joint name="knee" axis="0 1 0" range="-90 90" armature="0.01"
 stiffness="2"/><geom type="capsule" fromto="0 0 0 0 0 -.4" size=".03" mass=".7"/></body>
</body></worldbody></mujoco>"""

#: The hinge stands at the side of a person who moves along x.
ACROSS = {"position": (0.6, 0.55, 0.03), "quaternion": (np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5))}


def played(simulator: hp.Simulator, motion: hp.Motion, edits: Edits) -> list[Any]:
    """Every frame of a motion, with edits in between."""
    frames = [simulator.reset(motion[0])]
    for t in range(1, len(motion)):
        if t in edits:
            edits[t](simulator)
        frames.append(simulator.step(motion[t]))
    return frames


def edited(edits: Edits, name: str = "asap_kick1", **changes: Any) -> dict[str, Any]:
    """A clip among solids, edited on its way: each frame as it came out."""
    motion = clip(name, seconds=1.2)
    simulator = hp.Simulator(
        bowling(), body=body(), settings=hp.Settings(**changes), fps=motion.fps
    )
    frames = played(simulator, motion, edits)
    every: dict[str, list[Any]] = {}
    for frame in frames:
        for key, value in frame_values(frame).items():
            every.setdefault(key, []).append(value)
    held = {name: list(where) for name, where in simulator.held.items()}
    return {**every, "names": simulator.names, "held": held}


def resumed(**changes: Any) -> dict[str, Any]:
    """A state taken in the middle; what went on, and what goes on from it in another simulator."""
    motion = clip("asap_kick1", seconds=1.2)
    settings = hp.Settings(**changes)
    first, second = (
        hp.Simulator(bowling(), body=body(), settings=settings, fps=motion.fps) for _ in range(2)
    )
    middle = len(motion) // 2
    first.reset(motion[0])
    for t in range(1, middle):
        first.step(motion[t])
    state = first.get_state()
    went_on = [first.step(motion[t]) for t in range(middle, len(motion))]
    second.set_state(state)
    goes_on = [second.step(motion[t]) for t in range(middle, len(motion))]
    return {
        "state": state.numbers,
        "went_on": frames_values(went_on),
        "goes_on": frames_values(goes_on),
    }


def holding(part: str, **changes: Any) -> dict[str, Any]:
    """A stick tied to a part, swung against what is around, let go in full swing."""
    motion = clip("asap_kick3", seconds=1.2)
    scene = furnished(0.2)
    at = body().joints(motion)[0, hp.JOINT_NAMES.index(part)] + (0.1, 0.0, 0.0)
    scene.add_object("stick", hp.Capsule(0.015, 0.6), mass=0.8, com=(0.0, 0.0, 0.1), position=at)
    scene.ignore("stick", "person")
    settings = hp.Settings(**changes)
    simulator = hp.Simulator(scene, body=body(), settings=settings, fps=motion.fps)
    edits: Edits = {1: lambda s: s.attach("stick", part), 28: lambda s: s.release("stick")}
    return frames_values(played(simulator, motion, edits))


def articulated(source: str, joints: Mapping[str, Any], **changes: Any) -> dict[str, Any]:
    """A person who walks into something with joints, which also falls or swings by itself."""
    scene = floor()
    scene.add_articulated("thing", source, **ACROSS, **joints)
    scene.add_object("ball", hp.Sphere(0.1), mass=2.0, position=(0.5, 0.3, 1.8))
    motion = clip("asap_walk1", seconds=1.5, first=0.3)
    settings = hp.Settings(**changes)
    return result_values(hp.simulate(motion, scene, body=body(), settings=settings))


def moving(loop: bool, **changes: Any) -> dict[str, Any]:
    """Things on trajectories: a board that pushes, a turning bar, a lift that carries a crate."""
    scene = floor()
    t = np.linspace(0.0, 1.0, 31)
    ahead = np.stack([-0.9 + 0.7 * t, 0.0 * t, 0.9 + 0.0 * t], axis=1)
    scene.add_moving("board", hp.Box((0.05, 0.8, 0.6)), ahead, fps=20.0, loop=loop)
    half = 0.5 * np.pi * t
    turns = np.stack([np.cos(half), 0.0 * t, 0.0 * t, np.sin(half)], axis=1)
    places = np.tile([0.6, 0.3, 0.7], (len(t), 1))
    scene.add_moving("bar", hp.Capsule(0.03, 0.8), places, turns, fps=30.0, loop=loop)
    lift = np.stack([1.2 + 0.0 * t, 0.0 * t, 0.05 + 0.3 * np.sin(3.0 * t)], axis=1)
    scene.add_moving("lift", hp.Box((0.5, 0.5, 0.1)), lift, fps=30.0, friction=0.8, loop=loop)
    scene.add_object("crate", hp.Box((0.2, 0.2, 0.2)), mass=4.0, position=(1.2, 0.05, 0.21))
    scene.add_static("wall", hp.Box((0.1, 3.0, 2.0)), position=(0.45, 0.0, 1.0))
    motion = clip("asap_squat3", seconds=1.5)
    return result_values(hp.simulate(motion, scene, body=body(), settings=hp.Settings(**changes)))


def inside(what: str, **changes: Any) -> dict[str, Any]:
    """A person or an object that starts inside something."""
    motion, scene = standing(40, lean=0.4), floor()
    if what == "floor":
        motion = moved(motion, (0.0, 0.0, -0.06))
    elif what == "table":
        top = {"position": (0.35, 0.0, 0.85)}
        scene.add_static("table", hp.Box((0.6, 1.2, 0.05)), **top)
        scene.add_static("leg", hp.Cylinder(0.05, 0.8), position=(0.05, 0.05, 0.41))
    elif what == "room":
        scene, motion = furnished(0.2), moved(clip("asap_squat3", 0.5), (-0.2, 0.1, 0.0))
    elif what == "object":
        scene.add_object("crate", hp.Box((0.4, 0.4, 0.4)), mass=10.0, position=(0.1, 0.1, 0.9))
        scene.add_object("low", hp.Box((0.3, 0.3, 0.3)), mass=5.0, position=(0.6, 0.0, 0.1))
        scene.add_object("in", hp.Sphere(0.1), mass=1.0, position=(0.65, 0.0, 0.15))
    settings = hp.Settings(**changes)
    people = [motion, moved(motion, (0.1, 0.05, 0.0))] if what == "person" else motion
    return result_values(hp.simulate(people, scene, body=body(), settings=settings))


def piled(**changes: Any) -> dict[str, Any]:
    """Objects alone: a tower, a heap, things that bounce, slide and sleep."""
    scene = floor(restitution=0.2)
    scene.friction("floor", scene.add_object("slider", hp.Box((0.2, 0.1, 0.1)), mass=1.0,
                   position=(1.0, 0.0, 0.051), velocity=(1.5, 0.0, 0.0)).name, 0.2)  # fmt: skip
    for i in range(5):
        size = (0.3 - 0.03 * i, 0.2, 0.1)
        at = (0.004 * i, 0.0, 0.051 + 0.1021 * i)
        scene.add_object(f"block{i}", hp.Box(size), density=500.0, position=at)
    for i in range(6):
        at = (-0.8 + 0.06 * (i % 2), 0.05 * i, 0.3 + 0.25 * i)
        shape = (hp.Sphere(0.1), hp.Capsule(0.06, 0.2), hp.Cylinder(0.08, 0.1))[i % 3]
        scene.add_object(f"heap{i}", shape, mass=0.5 + i, restitution=0.5, position=at)
    scene.add_object("asleep", hp.Sphere(0.1), mass=1.0, position=(1.9, 0.0, 0.5), start="asleep")
    simulator = hp.Simulator(scene, body=[], settings=hp.Settings(**changes))
    return frames_values([simulator.reset([]), *(simulator.step([]) for _ in range(45))])


def rays() -> dict[str, Any]:
    """What rays meet in a scene and in a running simulation."""
    motion, scene = clip("asap_kick1", seconds=1.2), furnished(0.2)
    simulator = hp.Simulator(scene, body=body(), fps=motion.fps)
    played(simulator, motion, {})
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    found: dict[str, list[Any]] = {"scene": [], "running": []}
    for angle in angles:
        towards = (np.cos(angle), np.sin(angle), -0.3)
        for name, where in (("scene", scene), ("running", simulator)):
            hit = where.ray((0.05, 0.02, 1.4), towards)
            found[name].append(None if hit is None else hit)
    return found


def edits() -> Iterator[tuple[str, Edits]]:
    """Every live edit alone, then all of them."""
    ball = {"mass": 0.4, "position": (0.4, 0.0, 1.2), "velocity": (-3.0, 0.0, 0.0)}
    one: dict[str, tuple[int, Callable[[hp.Simulator], Any]]] = {
        "add": (5, lambda s: s.add_object("new", hp.Sphere(0.1), **ball)),
        "remove": (9, lambda s: s.remove_object("crate")),
        "velocity": (12, lambda s: s.set_velocity("ball", (1.0, -2.0, 3.0), (0.0, 5.0, 0.0))),
        "impulse": (14, lambda s: s.apply_impulse("can", (0.3, 0.0, 0.2), (0.5, 0.2, 0.4))),
        "limp": (16, lambda s: s.set_stiffness({"arms": 0.1, "left_knee": 0.0})),
        "attach": (18, lambda s: s.attach("roll", "left_wrist")),
        "release": (25, lambda s: s.release("roll")),
    }
    yield "none", {}
    for name, (frame, edit) in one.items():
        if name != "release":
            yield name, {frame: edit}
    yield "all", dict(one.values())


def cases() -> Iterator[Case]:
    """All that a running simulation can be asked for."""
    limp = {"drive_time": None, "substeps": 8, "stiffness": 0.0, "contact": "parts"}
    ways: Mapping[str, dict[str, Any]] = {
        "default": {},
        "parts": {"contact": "parts"},
        "human": {"strength": "human"},
        "paper": limp,
        "self": {"self_contact": True},
        "substeps": {"record": "substeps"},
    }
    joints = {"joints": {"ball": (0.9, 0.3, 0.3, 0.1), "knee": 0.4}, "velocities": {"knee": 3.0}}
    for way, changes in ways.items():
        quick = way in ("default", "paper")
        for name, steps in edits():
            yield Case(
                f"live/{name}/{way}", partial(edited, steps, **changes), quick and name == "all"
            )
        yield Case(f"live/resumed/{way}", partial(resumed, **changes), quick)
        for part in ("right_wrist", "head", "left_foot"):
            yield Case(f"live/holding_{part}/{way}", partial(holding, part, **changes),
                       quick and part == "right_wrist")  # fmt: skip
        for name, text, start in (("door", DOOR, {}), ("cabinet", CABINET, {}),
                                  ("pendulum", PENDULUM, joints)):  # fmt: skip
            run = partial(articulated, text, start, **changes)
            yield Case(f"live/{name}/{way}", run, quick and name != "cabinet")
        for loop in (False, True):
            yield Case(f"live/moving_{'loop' if loop else 'once'}/{way}",
                       partial(moving, loop, **changes), quick and loop)  # fmt: skip
        for what in ("floor", "table", "room", "object", "person"):
            yield Case(f"live/inside_{what}/{way}", partial(inside, what, **changes),
                       quick and what != "room" and (way == "default" or what == "table"))  # fmt: skip
        yield Case(f"live/piled/{way}", partial(piled, **changes), way == "default")
    yield Case("live/rays", rays, True)

"""Bodies moved by different methods: the runs of Figures 6 and 7."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from evidence.model import Outcome
from evidence.runs import choices, lifting, playing, ragdoll
from halfphysics import scenarios
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import Result
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Values = Mapping[str, Any]

# Thickness of the wall [m]; how long the suitcase is carried and shaken [s].
_WALL = {"thickness": 0.1}
_LIFT = {"carry": 1.0, "shake": 0.0}
# A toe in contact with a ball is at most this far from its centre [m].
_NEAR = 0.5


def wall(choice: Values, strip: bool, quick: bool) -> Outcome:
    """A walk into a wall: final position, and penetration of the skin."""
    result = playing.play("walk_into_wall", _WALL, choice)
    body, there = result.people[0].body, result.scene.statics["wall"].position[0]
    pelvis, asked = (body.joints(m)[:, 0, 0] for m in (result.motion, result.reference))
    report = playing.penetration(result, quick=quick)
    values = {
        "fps": result.fps,
        "beyond": float(pelvis[-1] - there),
        "way": pelvis.tolist(),
        "rate": report.rate_percent,
        "deepest": report.depth_max_mm,
    }
    at = int((asked > there).argmax())  # the reference is in the wall
    frames = [at + 10] if quick else [at, at + 10]
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick, frames=frames))


def lift(choice: Values, strip: bool, quick: bool) -> Outcome:
    """A suitcase between two palms."""
    result = playing.play("lift_suitcase", _LIFT, choice)
    height = 1e3 * (result.objects["suitcase"].position[:, 2])
    values = {
        **lifting.judged(result, quick=quick),
        "fps": result.fps,
        "fastest": float(playing.object_speed(result, "suitcase").max()),
        "heights": (height - height[0]).tolist(),
    }
    frames = [round(t * result.fps) for t in ((2.2,) if quick else (0.9, 2.2))]
    return Outcome(values=values, pictures=playing.strip(result, strip, quick=quick, frames=frames))


def kick(choice: Values, masses: list[float]) -> Outcome:
    """The same kick at floating balls of several masses: their speeds, depth of the foot."""
    speeds, depths = [], []
    for mass in masses:
        result = playing.run(_floating(mass), choice)
        speeds.append(float(playing.object_speed(result, "ball").max()))
        report = playing.penetration(result, frames=_near(result))
        depths.append(float(report.by_name["ball"].max()))
    return Outcome(values={"masses": masses, "speeds": speeds, "depths": depths})


def _floating(mass: float) -> Sequence:
    """The authored kick without floor and gravity, so that no foot catches a ball."""
    story = scenarios.load("kick_ball", mass=mass)
    ball, scene = story.scene.objects["ball"], Scene(gravity=0.0)
    scene.add_object("ball", ball.shape, mass=mass, friction=ball.friction, position=ball.position)
    return Sequence(story.motion, scene, story.body)


def _near(result: Result) -> slice:
    """Frames in which a foot is near the ball."""
    joints = result.people[0].body.joints(result.motion)
    feet = joints[:, [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]]
    away = np.linalg.norm(feet - result.objects["ball"].position[:, None], axis=-1).min(axis=1)
    near = np.flatnonzero(away < _NEAR)
    return slice(int(near.min()), int(near.max()) + 1)


def limp(before: float, watched: float) -> Outcome:
    """A body that goes limp `before` a kick [s] and is `watched` [s], beside one that does not."""
    story = scenarios.load("kick_ball")
    motion, body = story.motions[0], playing.default_body(story)
    ours = playing.run(story, choices.OURS)
    hit = playing.first_touch(ours, "ball")
    frame = hit - round(before * motion.fps)
    fallen = ragdoll.let_go(story, frame)
    after = slice(frame, frame + round(watched * motion.fps))
    asked = body.joints(motion)[after]
    values = {}
    for name, its in (("ragdoll", fallen), ("ours", ours.motion)):
        joints = body.joints(its)[after]
        values[name] = {
            "mpjpe_g": float(1e3 * np.linalg.norm(joints - asked, axis=-1).mean()),
            "drop": float((asked - joints)[-1, 0, 2]),
            "heights": joints[:, 0, 2].tolist(),
        }
    return Outcome(values={"fps": motion.fps, "asked": asked[:, 0, 2].tolist(), **values})

"""Sessions of the playground for tests: scenes, consecutive frames, results of `simulate`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import halfphysics as hp
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.simulation.sequence import Sequence
from halfphysics.viewer.catalog import Catalog, Choice
from halfphysics.viewer.session import Session

KICK = Choice("kick_ball")


def standing(*, frames=90, fps=30.0, wall=None):
    """A person who stands still, a ball beside them, half a metre away."""
    story = hp.scenarios.load("kick_ball")
    first = story.motion[0]
    motion = hp.Motion(
        np.repeat(first.translation[None], frames, axis=0),
        np.repeat(first.rotations[None], frames, axis=0),
        fps,
    )
    scene = hp.Scene()
    scene.add_static("floor", Plane())
    pelvis = np.asarray(story.body.joints(first))[0]
    at = np.add(pelvis, [0.8, 0.0, 0.0])
    scene.add_object("ball", Sphere(0.11), mass=0.43, position=(at[0], at[1], 0.11))
    if wall is not None:
        scene.add_static("wall", Box((0.1, 4.0, 3.0)), position=(at[0] + wall, at[1], 1.5))
    return Sequence(motion, scene, story.body), pelvis


def playing(sequence):
    return Session(Catalog({"here": lambda: sequence}), Choice("here"))


def run(session, frames):
    """Consecutive frames of the session."""
    return [session.advance() for _ in range(frames)]


def ball(frames):
    return np.array([frame.objects["ball"][0] for frame in frames])


def simulated(choice, **changes):
    """The result of `simulate` for a scenario with other settings."""
    story = Catalog().load(choice)
    settings = replace(story.settings, **changes)
    return hp.simulate(story.motion, story.scene, body=story.body, settings=settings)

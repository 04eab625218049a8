"""Stories with soft things: what sinks in, comes to rest and is held."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from halfphysics import scenarios
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.simulation.simulate import simulate

G = 9.81


@functools.cache
def played(name, **options):
    story = scenarios.load(name, **options)
    return story, simulate(story.motion, story.scene, body=story.body, settings=story.settings)


def upward(result, name, frames=10):
    """Mean upward force of a thing on the person in the last frames [N]."""
    contacts = result.contacts
    some = contacts[(contacts.other == result.names.index(name)) & (contacts.subject < 0)]
    last = some.frame >= len(result) - frames
    return some.impulse[last, 2].sum() * result.fps / frames


def test_a_ball_that_is_dropped_on_a_cushion_comes_to_rest_in_it():
    mass, radius = 3.0, 0.11
    story, result = played("ball_on_cushion", mass=mass, radius=radius)
    height = np.asarray(result.objects["ball"].position)[:, 2]
    top = 0.20
    assert height.min() < height[-1] < top + radius
    assert height.min() > radius + 0.08  # the frame of the cushion is 8 cm high
    assert np.ptp(height[-10:]) < 0.002
    # F = pi k R d^2 of a ball on a spring foundation.
    soft = story.scene.statics["cushion"].soft
    depth = top + radius - height[-1]
    force = np.pi * soft.stiffness * radius * depth**2
    assert force == pytest.approx(mass * G, rel=0.1)  # the foam's memory is left


def test_who_jumps_on_a_bed_leaves_it_and_comes_to_rest_on_it():
    story, result = played("jump_on_bed", jumps=1)
    skin = story.body.vertices(result.motion)[..., 2].min(axis=1)
    top = 0.45
    assert skin.max() > top + 0.03  # in the air: the mattress takes the most of it
    assert skin.min() < top - 0.04  # and deep in the mattress
    assert skin.min() > top - 0.18  # not in its frame
    assert upward(result, "mattress") == pytest.approx(story.body.mass * G, rel=0.05)
    pelvis = [story.body.joints(m[-1])[0] for m in (story.motion, result.motion)]
    assert np.abs(pelvis[0] - pelvis[1])[:2].max() < 0.05


def test_landing_presses_harder_than_standing():
    story, result = played("jump_on_bed", jumps=1)
    contacts = result.contacts
    some = contacts[contacts.other == result.names.index("mattress")]
    force = np.bincount(some.frame, weights=some.impulse[:, 2], minlength=len(result)) * result.fps
    assert 1.5 < force.max() / (story.body.mass * G) < 5.0


def test_a_pillow_is_squeezed_lifted_and_held():
    story, result = played("squeeze_pillow")
    pillow = np.asarray(result.objects["pillow"].position)
    assert pillow[-1, 2] - pillow[0, 2] > 0.25
    wrists = [JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"]]
    asked, made = (
        np.linalg.norm(np.diff(story.body.joints(m[-1])[wrists], axis=0)[0])
        for m in (story.motion, result.motion)
    )
    assert made < asked + 0.03  # the palms go in as far as they want to


def test_a_suitcase_is_held_by_soft_hands_as_by_hard_ones():
    story = scenarios.load("lift_suitcase", carry=1.0, shake=1.0)
    risen = []
    for soft in (False, True):
        settings = replace(story.settings, soft_skin=soft)
        result = simulate(story.motion, story.scene, body=story.body, settings=settings)
        at = np.asarray(result.objects["suitcase"].position)
        hands = story.body.joints(result.motion)[:, JOINT_INDEX["left_wrist"], 2]
        lifted = slice(75, None)
        risen.append(np.ptp((at[:, 2] - hands)[lifted]))
    assert risen[1] < risen[0] + 0.005  # slips by no more

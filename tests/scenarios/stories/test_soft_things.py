"""Stories with soft things: what sinks in, comes to rest and is held."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from halfphysics import scenarios
from halfphysics.metrics.result_report import UNSETTLED
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.stories.lift_suitcase import RISE, UP
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
    """Both palms press it in by centimetres, and then it is where they are, to millimetres."""
    _, result = played("squeeze_pillow")
    pillow = np.asarray(result.objects["pillow"].position)
    assert pillow[-1, 2] - pillow[0, 2] == pytest.approx(RISE, abs=0.02)
    up = round((UP + 0.5) * result.fps)
    assert np.ptp(pillow[up:, 2]) < 0.005  # carried for seconds, it slips by no more
    assert np.abs(pillow[up:, 1]).max() < 0.002  # both palms press alike
    rows = result.soft_contacts.at(len(result) - 1)
    person, thing = (result.names.index(n) for n in ("person", "pillow"))
    palms = rows[(rows.other == person) & (rows.layer == thing)]
    left = palms.position[:, 1] > pillow[-1, 1]
    for side in (palms[left], palms[~left]):
        assert 0.02 < side.depth.max() < 0.05
        assert 20.0 < np.abs(side.force[:, 1].sum()) < 150.0  # of two hands, without effort
    # It stands on the stool by its weight alone: what presses is shallow.
    every = result.soft_contacts
    stool = every[(every.other == thing) | (every.layer == result.names.index("stool"))]
    assert stool.depth.max() < 0.01
    assert result.diagnostics["friction_tolerances"].max() <= UNSETTLED


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

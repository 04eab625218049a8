"""A person's strength limits bound the drive's torques in every substep, at any impact."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.body.strength import limits_of
from halfphysics.geometry.shapes import Box
from halfphysics.motion.skeleton import JOINT_INDEX
from support.as_it_is import as_it_is
from support.held import HAND, holding, pointing
from support.people import along_x, violent
from support.self_touch import between, hand_on_face, relaxed

#: What is left of torques in a hold that has just come to rest [N m].
HELD = 0.05

#: Relative rounding: a limit is met exactly.
ROUNDING = 1e-6


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


def walled(x=1.0):
    scene = hp.Scene()
    scene.add_static("wall", Box((0.1, 4.0, 4.0)), position=(x + 0.05, 0.0, 0.0))
    return scene


def thrown(mass, x=1.0):
    """A box that flies at 8 m/s into a standing person."""
    scene = hp.Scene(gravity=0.0)
    scene.add_object(
        "box", Box((0.5, 0.5, 0.5)), mass=mass, position=(x, 0.0, 0.2), velocity=(-8.0, 0.0, 0.0)
    )
    return scene


def cases():
    flailing = violent(16).resample(240.0)
    return {
        "walks into a wall": (along_x(1.5, 200, start=0.3, fps=240.0), walled()),
        "runs into a wall at 6 m/s": (along_x(6.0, 60, start=0.3, fps=240.0), walled()),
        "flails at 15 m/s and more": (
            flailing.with_frames(0.3 * flailing.translation, flailing.rotations),
            walled(0.4),
        ),
        "is hit by 300 kg": (along_x(0.0, 80, start=0.0, fps=240.0), thrown(300.0)),
    }


@pytest.mark.parametrize("case", cases())
@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_no_torque_above_its_limit_in_any_substep(body, case, contact):
    """One substep a frame, so that the reported torque is that of every substep."""
    share = shares(body, *cases()[case], contact)
    assert share.max() <= 1.0 + ROUNDING
    assert share.max() >= 0.9  # the limits were reached


@pytest.mark.parametrize("forward", [0.002, 0.004, 0.0066667, 0.01, 0.0133333])
@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_nor_from_other_starts(body, forward, contact):
    """Steps made in pieces, joints that whirl: 5 of 24 such starts exceeded a limit."""
    motion, scene = cases()["flails at 15 m/s and more"]
    moved = motion.with_frames(motion.translation + np.array([forward, 0.0, 0.0]), motion.rotations)
    assert shares(body, moved, scene, contact).max() <= 1.0 + ROUNDING


def shares(body, motion, scene, contact):
    """Torques of all substeps as shares of the limits (T, 55)."""
    settings = as_it_is(strength="human", contact=contact)
    assert settings.substeps_for(1.0 / motion.fps) == 1
    simulator = hp.Simulator(scene, body=body, settings=settings, fps=motion.fps)
    _, limits = limits_of("human", body)
    simulator.reset(motion[0])
    torque = []
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t])
        assert np.isfinite(frame.pose.rotations).all()
        torque.append(np.linalg.norm(frame.torques[0], axis=-1))
    return np.array(torque) / limits


def test_without_limits_the_same_blow_takes_more(body):
    """In the same case the drive alone would exert many times a neck's strength."""
    motion, scene = cases()["runs into a wall at 6 m/s"]
    result = hp.simulate(motion, scene, body=body, settings=as_it_is())
    _, limits = limits_of("human", body)
    assert (np.linalg.norm(result.people[0].torque, axis=-1) / limits).max() > 3.0


def test_who_was_hit_gets_back_to_the_motion(body):
    held = along_x(0.0, 90, start=0.0)
    settings = as_it_is(strength="human")
    result = hp.simulate(held, thrown(20.0), body=body, settings=settings)
    off = np.degrees(np.linalg.norm(result.motion.rotations - held.rotations, axis=-1))
    assert off.max() > 10.0
    assert off[-1, 1:].max() < 5.0


def test_a_limp_arm_leaves_the_rest_its_strength(body):
    """The joints that were hit recover; the arm, which is not driven, swings on."""
    arm = [f"right_{j}" for j in ("shoulder", "elbow", "wrist")]
    held = along_x(0.0, 90, start=0.0)
    settings = as_it_is(strength=dict.fromkeys(arm, 0.0))
    result = hp.simulate(held, thrown(20.0), body=body, settings=settings)
    off = np.degrees(np.linalg.norm(result.motion.rotations - held.rotations, axis=-1))
    index = [JOINT_INDEX[j] for j in arm]
    torque = np.linalg.norm(result.people[0].torque[:, index], axis=-1)
    assert torque.max() < 1e-6
    assert off[:, index].max() > 20.0
    assert off[-1, : JOINT_INDEX["left_collar"]].max() < 1.0
    assert np.linalg.norm(result.motion.translation - held.translation, axis=1).max() < 0.2


@pytest.mark.parametrize("mass", [1.0, 8.0])
def test_what_is_held_counts_on_impacts_too(body, mass):
    """A stick held ahead hits a wall at 3 m/s: the torques for load and impact together
    stays within the limits, in every substep."""
    motion = pointing(path=along_x(3.0, 60, start=0.0, fps=240.0).translation, fps=240.0)
    tip = body.joints(motion[0])[HAND, 0] + 0.55 + 0.3
    simulator = holding(
        body,
        motion,
        scene=walled(tip + 0.3),
        mass=mass,
        settings=as_it_is(contact="parts", strength="human"),
    )
    _, limits = limits_of("human", body)
    frames = [simulator.step(motion[t]) for t in range(1, len(motion))]
    share = np.array([np.linalg.norm(f.torque, axis=1) for f in frames]) / limits
    assert any(len(f.contacts.part) > 0 for f in frames)
    assert share.max() <= 1.0 + ROUNDING
    assert share.max() >= 0.9


@pytest.mark.parametrize("substeps", [4, 8, 16])
@pytest.mark.parametrize("strength", [None, "human"])
def test_a_hand_on_the_face_loads_no_joint_below_the_shoulders(body, strength, substeps):
    """The forces of self-contact sum to nothing: in a hold the trunk bears nothing of them."""
    face = hand_on_face(body)
    motion = between([relaxed(body), face, face], [12, 30])
    settings = as_it_is(self_contact=True, strength=strength, substeps=substeps)
    result = hp.simulate(motion, hp.Scene(), body=body, settings=settings)
    torque = np.linalg.norm(result.people[0].torque[-2], axis=-1)
    own = [JOINT_INDEX[name] for name in ("pelvis", "spine1", "spine2", "spine3", "left_hip")]
    assert torque[JOINT_INDEX["neck"]] > 10.0
    assert torque[own].max() < HELD

"""Legs and arms of one frame are those of all frames (`scenarios.acting`)."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.actors import turns
from halfphysics.actors.limbs import ArmBones, LegBones
from halfphysics.base import rotations as rot
from halfphysics.scenarios.acting import arms, legs
from support.acted import body

RNG = np.random.default_rng(1)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_leg_is_that_of_many_frames(side):
    leg, own = legs.leg_of(body(), side), LegBones.of(body(), side)
    for _ in range(30):
        yaw, pitch = RNG.uniform(-2, 2), RNG.uniform(-0.6, 0.3)
        x, y = RNG.uniform(-0.3, 0.3, 2)
        ankle, foot = own.planted(x, y, yaw, pitch)
        expected = legs.planted(leg, np.array([x, y]), yaw, np.array([pitch]))[0]
        np.testing.assert_allclose(ankle, expected, atol=1e-14)
        root = rot.exp([0.05, -0.04, yaw]), turns.WORLD_FROM_REST
        turn = tuple(rot.multiply(*root).tolist())
        hip = (float(x), float(y), RNG.uniform(0.5, 1.0))
        got = own.solve(turn, hip, ankle, foot)
        many = legs.solve(
            leg,
            rot.to_matrix(turn)[None],
            np.array([hip]),
            np.array([ankle]),
            rot.to_matrix(foot)[None],
            np.zeros(1),
        )
        for joint, q in zip(leg.joints, got, strict=False):
            np.testing.assert_allclose(turns.log(q), many[joint][0], atol=1e-9)


@pytest.mark.parametrize("side", ["left", "right"])
def test_an_arm_is_that_of_many_frames(side):
    arm, own = arms.arm_of(body(), side), ArmBones.of(body(), side)
    for _ in range(30):
        collar = tuple(rot.exp(RNG.normal(0, 0.5, 3)).tolist())
        hand = tuple(rot.exp(RNG.normal(0, 0.5, 3)).tolist())
        wrist = tuple(RNG.uniform(-0.35, 0.35, 3).tolist())
        pole = tuple(RNG.normal(size=3).tolist())
        got = own.solve(collar, (0.0, 0.0, 0.0), wrist, hand, pole)
        many = arms.solve(
            arm,
            rot.to_matrix(collar)[None],
            np.zeros((1, 3)),
            np.array([wrist]),
            rot.to_matrix(hand)[None],
            np.array(pole),
        )
        # As rotations: about half a turn, either sign is right, and the parts of a twist that is
        # over half a turn differ by a whole one.
        whole = many[arm.joints[1]][0], many[arm.joints[2]][0]
        if np.linalg.norm(whole[1]) > 1.2:
            continue
        for joint, q in zip(arm.joints, got, strict=True):
            assert float(rot.angles(turns.log(q), many[joint][0])) < 1e-7

"""Two people shake hands: clasped, shaken and let go, clear of each other at every frame."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.motion.skeleton import JOINT_INDEX, RIGHT_HAND_JOINTS
from halfphysics.scenarios.stories import shake_hands
from support.as_it_is import as_it_is
from support.judges.pair_judge import PairJudge
from support.pairs_of_people import check_clear, motions, simulated

pytestmark = pytest.mark.slow

HAND = [JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS]


def bodies():
    """Two people of other shapes, not just scaled."""
    rng = np.random.default_rng(3)
    return [hp.Body.default(betas=rng.normal(size=10)) for _ in range(2)]


def hands(result):
    """Rows of the first person's contacts that are between both right hands."""
    c = result.contacts
    return (c.person == 0) & np.isin(c.part, HAND) & np.isin(c.other_part, HAND)


@pytest.mark.parametrize(("fps", "stature"), [(30.0, 1.60), (60.0, 1.60), (30.0, 0)])
def test_hands_are_clasped_shaken_and_let_go(fps, stature):
    who = {"stature": stature} if stature else dict(zip(("body", "other"), bodies(), strict=True))
    sequence = hp.scenarios.load("shake_hands", fps=fps, **who)
    result = simulated(sequence)
    check_clear(sequence, result, 0.015)
    contacts, times = result.contacts, shake_hands.held(3)
    frames = np.arange(round(times[0] * fps), round(times[1] * fps) + 1)
    rows = hands(result)
    force = np.bincount(
        contacts.frame[rows],
        np.linalg.norm(contacts.impulse[rows], axis=1) * fps,
        minlength=len(result),
    )
    # Fingers are around the other's hand, both ways, in every frame from the clasp to its end.
    assert force[frames].min() > 20.0
    assert force.max() < 300.0
    assert set(contacts.part[rows]) >= {JOINT_INDEX[f"right_{n}3"] for n in ("index", "thumb")}
    # No other contact: before and after the clasp the bodies are apart.
    people = contacts.other_part >= 0
    assert rows.sum() == people[contacts.person == 0].sum()
    assert np.flatnonzero(force).min() > frames[0] - round(0.7 * fps)
    assert np.flatnonzero(force).max() < frames[-1] + round(0.7 * fps)
    # Three times up and down, both hands together.
    wrists = np.stack(
        [p.body.joints(p.motion)[frames, JOINT_INDEX["right_wrist"]] for p in result.people]
    )
    between = wrists[0] - wrists[1]
    assert np.linalg.norm(between - between[0], axis=1).max() < 0.01
    height = wrists[0][:, 2] - wrists[0][0, 2]
    assert height.max() > 0.03
    assert height.min() < -0.03
    signs = np.sign(height[np.abs(height) > 0.015])
    assert np.count_nonzero(np.diff(signs)) == 5
    # They stand at their reference positions.
    for person in result.people:
        off = person.motion.translation - person.reference.translation
        assert np.linalg.norm(off, axis=1).max() < 0.01


def test_limp_and_firm_hands():
    """The firmer both hands are, the harder they hold; a limp hand yields to a firm one."""
    sequence = hp.scenarios.load("shake_hands", shakes=1)
    begin, end = (round(t * 30.0) for t in shake_hands.held(1))
    force, bent = [], []
    for stiffness in ([0.0, 0.0], [0.0, 10.0], [10.0, 10.0]):
        result = simulated(sequence, settings=as_it_is(), stiffness=stiffness)
        rows = hands(result) & (result.contacts.frame >= begin) & (result.contacts.frame <= end)
        force.append(np.linalg.norm(result.contacts.impulse[rows], axis=1).sum())
        fingers = [
            p.motion.rotations[begin:end, HAND[1:]] - p.reference.rotations[begin:end, HAND[1:]]
            for p in result.people
        ]
        bent.append([np.abs(turn).mean() for turn in fingers])
        assert PairJudge(sequence.body).judge(motions(result), skin_every=80).clear
    assert force[2] > 1.5 * max(force[:2])
    # Hands as flat as wrists allow have less of a finger around the other's edge to bend: 1.9.
    assert bent[1][0] > 1.5 * bent[1][1]

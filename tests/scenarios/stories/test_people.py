"""Two people: who meet head-on, and who shake hands. They stay out of each other at every frame."""

from __future__ import annotations

import re

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli import main
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, RIGHT_HAND_JOINTS
from halfphysics.scenarios.stories import shake_hands
from support.judges.pair_judge import PairJudge

#: Who stands still moves less than this in the last 0.2 s [m/s].
STILL = 0.01
HAND = [JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS]


def bodies():
    """Two people of other shapes, not just scaled."""
    rng = np.random.default_rng(3)
    return [hp.Body.default(betas=rng.normal(size=10)) for _ in range(2)]


def simulated(sequence, **options):
    return hp.simulate(
        sequence.motion,
        sequence.scene,
        body=sequence.body,
        **{"settings": sequence.settings, **options},
    )


def motions(result):
    return [person.motion for person in result.people]


def check_clear(sequence, result, asked_depth):
    """Clear of each other and of the floor where the motions alone are deep inside."""
    judge, step = PairJudge(sequence.body), round(result.fps / 7.5)
    asked = judge.judge([p.reference[::step] for p in result.people], skin_every=10**9)
    assert asked.gap < -asked_depth  # it can tell
    verdict = judge.judge(motions(result), skin_every=24)
    assert verdict.clear, str(verdict)
    assert verdict.near > 0
    assert result.clearance.min() > 0.0
    assert result.lost_time.sum() == 0.0


def pelvis(result):
    """Of both people (T, 2, 3) [m]."""
    return np.stack([p.body.joints(p.motion)[:, 0] for p in result.people], axis=1)


# -- meeting head-on -----------------------------------------------------------------------


@pytest.mark.parametrize("stature", [1.60, 1.85])
def test_two_people_who_meet_stop_clear_of_each_other(stature):
    sequence = hp.scenarios.load("meet", stature=stature)
    result = simulated(sequence)
    check_clear(sequence, result, 0.10)
    at = pelvis(result)
    touched = int(result.contacts.frame[result.contacts.other_part >= 0].min())
    speed = np.diff(at[:touched, :, 0], axis=0) * result.fps
    # Head-on at 1.5 m/s each, and neither ever gets past the other.
    np.testing.assert_allclose(speed[-15:].mean(axis=0), [1.5, -1.5], atol=0.1)
    apart = at[:, 1, 0] - at[:, 0, 0]
    assert apart.min() > 0.15
    asked = [p.body.joints(p.reference)[-1, 0, 0] for p in result.people]
    assert asked[0] - asked[1] > 1.5  # where they wanted to be
    last = round(0.2 * result.fps)
    assert np.linalg.norm(np.diff(at[-last:], axis=0), axis=2).max() * result.fps < STILL


def test_beside_each_other_they_pass_untouched():
    sequence = hp.scenarios.load("meet", offset=0.9)
    result = simulated(sequence)
    assert not len(result.contacts)
    for person in result.people:
        np.testing.assert_allclose(
            person.motion.translation, person.reference.translation, rtol=0.0, atol=1e-9
        )


def test_each_with_their_own_firmness():
    """Of two alike who meet, the limp one's joints give more; exchanged, the other's."""
    sequence = hp.scenarios.load("meet", stature=hp.Body.default().stature)
    given = []
    for stiffness in ([0.05, 10.0], [10.0, 0.05]):
        result = simulated(sequence, stiffness=stiffness)
        given.append([hp.metrics.mpjpe(p.motion, p.reference, p.body) for p in result.people])
        judge = PairJudge(sequence.body)
        assert judge.judge(motions(result), skin_every=80).clear
        assert result.lost_time.sum() == 0.0
    assert given[0][0] > 1.5 * given[0][1]
    assert given[1][1] > 1.5 * given[1][0]


# -- shaking hands -------------------------------------------------------------------------


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
    # Nothing else touches: before and after the clasp nobody is near the other.
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
    # They stand where they wanted to stand.
    for person in result.people:
        off = person.motion.translation - person.reference.translation
        assert np.linalg.norm(off, axis=1).max() < 0.01


def test_limp_and_firm_hands():
    """The firmer both are, the harder they hold; a limp hand gives way to a firm one."""
    sequence = hp.scenarios.load("shake_hands", shakes=1)
    begin, end = (round(t * 30.0) for t in shake_hands.held(1))
    force, bent = [], []
    for stiffness in ([0.0, 0.0], [0.0, 10.0], [10.0, 10.0]):
        result = simulated(sequence, stiffness=stiffness)
        rows = hands(result) & (result.contacts.frame >= begin) & (result.contacts.frame <= end)
        force.append(np.linalg.norm(result.contacts.impulse[rows], axis=1).sum())
        fingers = [
            p.motion.rotations[begin:end, HAND[1:]] - p.reference.rotations[begin:end, HAND[1:]]
            for p in result.people
        ]
        bent.append([np.abs(turn).mean() for turn in fingers])
        assert PairJudge(sequence.body).judge(motions(result), skin_every=80).clear
    assert force[2] > 1.5 * max(force[:2])
    assert bent[1][0] > 3.0 * bent[1][1]


# -- both ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "depth"), [("meet", 50.0), ("shake_hands", 5.0)])
def test_from_the_command_line(name, depth, tmp_path, capsys):
    target = tmp_path / "r.npz"
    assert main(["scenario", name, "--fps", "6", "--out", str(target)]) == 0
    assert hp.Result.load(target).summary() in capsys.readouterr().out
    assert main(["evaluate", str(target)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    rows = re.findall(r"^deepest in other people \[mm\] +(\S+) +(\S+)$", out, re.MULTILINE)
    assert len(rows) == 2  # one a person
    for asked, got in rows:
        assert float(asked) > depth
        assert float(got) == 0.0


def test_mistakes():
    with pytest.raises(InputError, match=r"offset: expected a number from -2 to 2 \[m\], found 3"):
        hp.scenarios.load("meet", offset=3.0)
    with pytest.raises(InputError, match="shakes: found -1, expected 0 to 50"):
        hp.scenarios.load("shake_hands", shakes=-1)
    with pytest.raises(InputError, match=r"press: expected .* from 0 to 0\.02 \[m\], found 0\.5"):
        hp.scenarios.load("shake_hands", press=0.5)
    with pytest.raises(InputError, match=r"stature: found .* people more alike"):
        hp.scenarios.load("shake_hands", stature=0.5)

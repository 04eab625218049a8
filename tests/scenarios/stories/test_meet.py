"""Two people who meet head-on stop clear of each other."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from support.as_it_is import as_it_is
from support.judges.pair_judge import PairJudge
from support.pairs_of_people import check_clear, motions, simulated

pytestmark = pytest.mark.slow

#: A standing person moves less than this in the last 0.2 s [m/s].
STILL = 0.01


def pelvis(result):
    """Pelvis positions of both people (T, 2, 3) [m]."""
    return np.stack([p.body.joints(p.motion)[:, 0] for p in result.people], axis=1)


@pytest.mark.parametrize("stature", [1.60, 1.85])
def test_two_people_who_meet_stop_clear_of_each_other(stature):
    sequence = hp.scenarios.load("meet", stature=stature)
    result = simulated(sequence, settings=as_it_is())
    check_clear(sequence, result, 0.10)
    at = pelvis(result)
    touched = int(result.contacts.frame[result.contacts.other_part >= 0].min())
    speed = np.diff(at[:touched, :, 0], axis=0) * result.fps
    # Head-on at 1.5 m/s each, and neither ever gets past the other.
    np.testing.assert_allclose(speed[-15:].mean(axis=0), [1.5, -1.5], atol=0.1)
    apart = at[:, 1, 0] - at[:, 0, 0]
    assert apart.min() > 0.15
    asked = [p.body.joints(p.reference)[-1, 0, 0] for p in result.people]
    assert asked[0] - asked[1] > 1.5  # their references
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
    """Of two equal people who meet, the limp one's joints give more; the same when exchanged."""
    sequence = hp.scenarios.load("meet", stature=hp.Body.default().stature)
    given = []
    for stiffness in ([0.05, 10.0], [10.0, 0.05]):
        result = simulated(sequence, settings=as_it_is(), stiffness=stiffness)
        given.append([hp.metrics.mpjpe(p.motion, p.reference, p.body) for p in result.people])
        judge = PairJudge(sequence.body)
        assert judge.judge(motions(result), skin_every=80).clear
        assert result.lost_time.sum() == 0.0
    assert given[0][0] > 1.5 * given[0][1]
    assert given[1][1] > 1.5 * given[1][0]

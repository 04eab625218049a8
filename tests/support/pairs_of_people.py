"""Runs of scenarios with two people, judged clear of each other."""

from __future__ import annotations

import halfphysics as hp
from support.judges.pair_judge import PairJudge


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
    """Clear of each other and of the floor where the references alone are deep inside."""
    judge, step = PairJudge(sequence.body), round(result.fps / 7.5)
    asked = judge.judge([p.reference[::step] for p in result.people], skin_every=10**9)
    assert asked.gap < -asked_depth  # the measure can fail
    verdict = judge.judge(motions(result), skin_every=24)
    assert verdict.clear, str(verdict)
    assert verdict.near > 0
    assert result.clearance.min() > 0.0
    assert result.lost_time.sum() == 0.0

"""The campaign runs every kind of actor; how fast is for the campaign to say."""

from __future__ import annotations

from campaigns.actors import cases, cost
from support.acted import body


def test_every_actor_runs():
    for make in cases(body()).values():
        assert cost(make(), 40) > 0.0

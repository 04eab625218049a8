"""Momentum of an arm and a person in a MuJoCo world: a short run of the campaign."""

from __future__ import annotations

import os

import pytest

from campaigns.hosted import BALANCE, balance

STEPS = int(os.environ.get("HALFPHYSICS_HOSTED", "400"))


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_momentum_of_both_is_balanced(contact):
    found = balance(STEPS, contact)
    assert found.touched > 50
    assert found.exchanged > 1.0
    assert max(found.run, found.step, found.joints) < BALANCE
    assert found.touch < BALANCE

"""Simulated scenarios in which a hand moves a joint of an object."""

from __future__ import annotations

import functools

import halfphysics as hp
from halfphysics.scenarios.props import chest, laptop
from support.as_it_is import as_it_is
from support.judges.jointed import Jointed

#: Scenario -> object, link and joint that the hand moves, its start and its end.
MOVED = {
    "close_drawer": ("chest", "top", "top_rail", 0.28, 0.0),
    "close_laptop": ("laptop", "lid", "hinge", laptop.OPEN, 0.0),
    "open_drawer": ("chest", "top", "top_rail", 0.0, chest.TRAVEL),
    "open_laptop": ("laptop", "lid", "hinge", 0.0, laptop.OPEN),
}


@functools.cache
def done(name, fps=30.0, stiffness=0.0, options=()):
    sequence = hp.scenarios.load(name, fps=fps, **dict(options))
    settings = as_it_is(stiffness=stiffness)
    result = hp.simulate(sequence.motion, sequence.scene, body=sequence.body, settings=settings)
    thing, link, joint, *_ = MOVED[name]
    return sequence, result, Jointed(result, thing), link, result.joints[f"{thing}/{joint}"]

"""Plausibility of contact impulses against mechanics, including wrong impulses."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import metrics, scenarios
from halfphysics.bench.clips import straight
from halfphysics.results.contacts import Contacts
from halfphysics.results.result import Result

LEFT_FOOT = hp.JOINT_NAMES.index("left_foot")


@cache
def kick(contact: str = "skin", record: str = "substeps") -> Result:
    """A ball on a floor, kicked away: the scenario, from shortly before the kick."""
    story = scenarios.load("kick_ball")
    motion = story.motions[0][60:110]
    settings = hp.Settings(contact=contact, record=record)  # type: ignore[arg-type]
    return hp.simulate(motion, story.scene, body=story.bodies[0], settings=settings)


def _changed(result: Result, **columns: Any) -> Result:
    """The result with other columns in its contacts."""
    old = {name: getattr(result.contacts, name) for name in Contacts.columns()}
    return dataclasses.replace(
        result, scene=result.scene, contacts=Contacts(**(old | columns)), people=result.people
    )


def test_a_kick_is_plausible_and_balanced() -> None:
    report = metrics.contact_forces(kick())
    assert report.push_percent == report.cone_percent == 100.0
    assert list(report.balance) == ["ball"]
    # Relative to momenta of a few N s.
    assert report.unbalanced < 1e-11
    assert (
        np.abs(kick().objects["ball"].position[-1] - kick().objects["ball"].position[0]).max() > 1
    )


def test_every_frame_but_no_substeps_leaves_the_balance_open() -> None:
    report = metrics.contact_forces(kick(record="frames"))
    assert report.balance == {}
    assert np.isnan(report.unbalanced)
    assert report.push_percent == 100.0


def test_what_a_wrong_impulse_leaves_out_of_balance() -> None:
    """Half of one impulse on the ball is omitted: the imbalance is that half, in that frame."""
    result = kick()
    ball = result.names.index("ball")
    row = int(np.argmax(np.where(result.contacts.other == ball, result.contacts.strength, 0.0)))
    impulse = np.array(result.contacts.impulse)
    impulse[row] *= 0.5
    report = metrics.contact_forces(_changed(result, impulse=impulse))
    missing = 0.5 * result.contacts.strength[row]
    assert missing > 0.1
    assert report.balance["ball"][result.contacts.frame[row]] == pytest.approx(missing, rel=1e-9)
    assert report.unbalanced == pytest.approx(missing, rel=1e-9)
    others = np.delete(report.balance["ball"], result.contacts.frame[row])
    assert others.max() < 1e-11


def test_pull_and_slip_by_hand() -> None:
    """Friction of the ball with the body is 0.6: one impulse pulls, one is 3 N s past its cone."""
    result = kick()
    assert result.scene.friction_of("person/left_foot", "ball") == 0.6
    ball, floor = (result.names.index(n) for n in ("ball", next(iter(result.scene.statics))))
    n = 4
    columns: dict[str, Any] = {
        "frame": np.arange(1, n + 1),
        "person": np.zeros(n, dtype=int),
        "part": np.full(n, LEFT_FOOT),
        "other": np.array([ball, ball, ball, floor]),
        "subject": np.full(n, -1),
        "other_part": np.full(n, -1),
        "position": np.zeros((n, 3)),
        "normal": np.tile([0.0, 0.0, 1.0], (n, 1)),
        "impulse": np.array([[6.0, 0, 10], [9.0, 0, 10], [0, 0, -0.5], [0, 10.0, 10]]),
    }
    report = metrics.contact_forces(_changed(result, **columns))
    assert report.contacts == 4
    assert report.push_percent == 75.0
    assert result.scene.friction_of("person/left_foot", result.names[floor]) >= 1.0
    assert report.cone_percent == 50.0  # a pulling impulse is in no cone
    assert report.pull == pytest.approx(0.5)
    assert report.slip == pytest.approx(3.0)


def test_what_sleeps_is_not_out_of_balance() -> None:
    """A sleeping box in the air carries no weight until a body touches it."""
    scene = hp.Scene()
    scene.add_object(
        "box", hp.Box((0.2, 0.2, 0.2)), mass=2.0, position=(0.4, -0.4, 0.0), start="asleep"
    )
    scene.add_object("high", hp.Sphere(0.1), mass=2.0, position=(9.0, 0, 9.0), start="asleep")
    scene.add_object("falls", hp.Sphere(0.1), mass=2.0, com=(0, 0, 0.05), position=(5.0, 0, 9.0),
                     angular_velocity=(3.0, 0, 0))  # fmt: skip
    result = hp.simulate(straight(1.5, 0.8, -0.6), scene, settings=hp.Settings(record="substeps"))
    report = metrics.contact_forces(result)
    assert np.abs(result.objects["box"].position[-1] - [0.4, -0.4, 0.0]).max() > 0.01
    assert sorted(report.balance) == ["box", "falls", "high"]
    assert report.unbalanced < 1e-9

"""Variants set up on trial: what is impossible is found before a sweep runs."""

from __future__ import annotations

import pytest

from halfphysics.errors import InputError
from halfphysics.sweep.make import rehearsal
from halfphysics.sweep.make.rehearsal import rehearse
from halfphysics.sweep.plan.plan import resolve_inputs
from halfphysics.sweep.plan.variants import Variants
from support.sweeps.sweep_case import PLAN, planned

HEAD = "inputs:\n  - scenarios: [kick_ball]\nfactors:\n  scenario.fps: [10]\n"


def told(folder, text):
    plan = planned(folder, text)
    return rehearse(plan, Variants(plan, resolve_inputs(plan)))


def test_a_sound_plan(tmp_path):
    found = told(tmp_path, PLAN)
    assert (found.tried, found.failed) == (11, ())  # `keep` leaves one of twelve out
    assert str(found) == "11 variants set up on trial, all can be made"


@pytest.mark.parametrize(
    ("factors", "message"),
    [
        ("  object.bal.mass: [1, 2]\n", r"^object\.bal\.mass: this variant's scene has no object"),
        ("  static.floor.scale: [2]\n", r"^static\.floor\.scale: .*plane, which has no size"),
        ("  statics.scale: [1, 2]\n", r"^statics\.scale: this variant's scene has no static of"),
        ("  scenario.speed: [1, 99]\n", r"^scenario\.speed: found 99.*expected 0\.5 to 15"),
        ("  motion.fps: [30, 0.01]\n", r"^motion\.fps: found 0\.01, which leaves one frame"),
        ("  motion.fps: {uniform: [0.01, 30]}\nsamples: 90\n", r"^motion\.fps: found 0\.01"),
    ],
)
def test_impossible_factors(factors, message, tmp_path):
    with pytest.raises(InputError, match=message):
        told(tmp_path, HEAD + factors)


def test_what_some_scenes_have_is_possible(tmp_path):
    """A factor of the ball: in one scenario of two there is one."""
    text = (
        "inputs:\n  - scenarios: [kick_ball, walk_into_wall]\n"
        "factors:\n  scenario.fps: [10]\n  object.ball.mass: [1, 2]\n"
    )
    found = told(tmp_path, text)
    assert found.tried == 4
    assert len(found.failed) == 2
    assert str(found).startswith("4 variants set up on trial, 2 cannot:\n  object.ball.mass: this")
    assert str(found).count("\n") == 1


def test_a_large_sweep_is_tried_at_its_extremes(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(rehearsal, "_cause", lambda shop, variant: made.append(variant) or "")
    listed = ", ".join(str(0.01 * k) for k in range(1, 101))
    found = told(
        tmp_path,
        f"{HEAD}  objects.friction: [{listed}]\n  objects.mass: {{from: 1, to: 5, count: 50}}\n"
        "  body.stature: {uniform: [1.5, 1.9]}\nsamples: 3\n",
    )
    assert found.tried == len(made) <= rehearsal.MOST
    for name, ends in (("objects.friction", {0.01, 1.0}), ("objects.mass", {1.0, 5.0}),
                       ("body.stature", {1.5, 1.9})):  # fmt: skip
        assert ends <= {variant.factors[name] for variant in made}


def test_variants_are_tried_where_conditions_leave_out_nearly_all(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(rehearsal, "_cause", lambda shop, variant: made.append(variant) or "")
    many = "  objects.friction: {from: 0.1, to: 1, count: 91}\n"
    many += "  motion.yaw: {from: 0, to: 90, count: 91}\n"
    few = told(tmp_path, f"{HEAD}{many}keep: motion.yaw == 44 and 0.3 < objects.friction < 0.9\n")
    assert few.tried == len(made) == rehearsal.MOST
    frictions = [variant.factors["objects.friction"] for variant in made]
    assert {variant.factors["motion.yaw"] for variant in made} == {44}
    assert min(frictions) < 0.4
    assert max(frictions) > 0.8
    none = told(tmp_path, f"{HEAD}{many}keep: motion.yaw > 90\n")
    assert none.tried == 0
    assert (
        str(none) == "no variant set up: the plan's conditions (keep) leave out all that were tried"
    )


def test_time_is_bounded(tmp_path, monkeypatch):
    clock = iter(range(0, 10_000, 20))
    monkeypatch.setattr(rehearsal.time, "monotonic", lambda: next(clock))
    assert told(tmp_path, PLAN).tried == 2

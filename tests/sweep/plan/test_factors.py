"""Factors of a sweep: their names, their values, and the draws."""

from __future__ import annotations

import json
import math
from collections import Counter
from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from halfphysics.errors import InputError
from halfphysics.sweep.plan.draws import Stream, exp, log
from halfphysics.sweep.plan.factors import FactorName, check_factors, check_settings
from halfphysics.sweep.plan.values import Choice, Listed, LogUniform, Normal, Range, Uniform, spec

DRAWS = 20_000
#: Of a test of a distribution: with fixed seeds it passes or fails for good.
SIGNIFICANCE = 1e-3


def draws(values: object, count: int = DRAWS, seed: int = 5, name: str = "x") -> np.ndarray:
    made = spec(values)
    stream = Stream(seed, name)
    return np.array([made.draw(stream, k) for k in range(count)])


@given(st.floats(1e-300, 1e300))
def test_logarithm_and_exponential_are_those_of_mathematics(x: float) -> None:
    # Four units in the last place.
    assert log(x) == pytest.approx(math.log(x), rel=1e-15, abs=1e-15)
    assert exp(math.log(x)) == pytest.approx(math.exp(math.log(x)), rel=1e-15)


def test_draws_are_what_they_were() -> None:
    """Frozen: a sweep repeated on another machine has the same variants."""
    stream = Stream(7, "objects.friction")
    numbers = (0, 1, 12345678)
    assert [stream.uniform(k) for k in numbers] == FROZEN_UNIFORM
    assert [next(stream.normals(k)) for k in numbers] == FROZEN_NORMAL
    assert [spec({"log_uniform": [0.1, 10]}).draw(stream, k) for k in numbers] == FROZEN_LOG


FROZEN_UNIFORM = [0.11957265893192737, 0.7290489564666486, 0.4356398832333582]
FROZEN_NORMAL = [0.13084691569176565, 0.1575018758044323, -1.7045223731444907]
FROZEN_LOG = [0.17343842373404886, 2.8714278806840507, 0.7434979346947964]


def test_draws_need_no_others_and_never_meet_their_ends() -> None:
    stream = Stream(3, "a")
    forward = [stream.uniform(k) for k in range(100)]
    assert [Stream(3, "a").uniform(k) for k in reversed(range(100))] == forward[::-1]
    assert next(stream.uniforms(5)) == forward[5]
    many = list(islice(stream.uniforms(1), 1000))
    assert len(set(many)) == 1000
    assert 0.0 < min(many) < 0.01 < 0.99 < max(many) < 1.0
    assert [Stream(4, "a").uniform(k) for k in range(5)] != forward[:5]
    # A seed and a name cannot be confused with others that concatenate to the same text.
    assert Stream(1, "1a").uniform(0) != Stream(11, "a").uniform(0)


@pytest.mark.parametrize(
    ("values", "law"),
    [
        ({"uniform": [-2, 3]}, stats.uniform(-2, 5)),
        ({"log_uniform": [0.1, 20]}, stats.loguniform(0.1, 20)),
        ({"normal": [4, 0.5]}, stats.norm(4, 0.5)),
        ({"normal": [1, 2], "within": [0, 2.5]}, stats.truncnorm(-0.5, 0.75, 1, 2)),
    ],
)
def test_distributions_are_what_they_say(values: object, law: object) -> None:
    assert stats.kstest(draws(values), law.cdf).pvalue > SIGNIFICANCE


def test_choices_come_in_proportion_to_their_weights() -> None:
    drawn = Counter(draws({"choice": ["a", "b", "c"], "weights": [1, 2, 5]}).tolist())
    expected = [DRAWS * share / 8 for share in (1, 2, 5)]
    assert stats.chisquare([drawn[k] for k in "abc"], expected).pvalue > SIGNIFICANCE
    even = Counter(draws({"choice": [True, 3, None]}).tolist())
    assert stats.chisquare(list(even.values())).pvalue > SIGNIFICANCE


def test_factors_and_neighbours_are_independent() -> None:
    a, b = (draws({"uniform": [0, 1]}, name=name) for name in ("objects.mass", "objects.masses"))
    bound = 4 / math.sqrt(DRAWS)  # four standard deviations of a zero correlation
    assert abs(np.corrcoef(a, b)[0, 1]) < bound
    assert abs(np.corrcoef(a[1:], a[:-1])[0, 1]) < bound
    assert (
        abs(np.corrcoef(a, draws({"uniform": [0, 1]}, seed=6, name="objects.mass"))[0, 1]) < bound
    )
    cells = np.histogram2d(a, b, bins=10, range=[[0, 1], [0, 1]])[0]
    assert stats.chisquare(cells.ravel()).pvalue > SIGNIFICANCE


def test_ranges_have_their_ends_and_even_steps() -> None:
    tidy = Range(first=0, last=1.0, count=11)
    assert tidy.listed() == tuple(k / 10 for k in range(11))
    whole = Range(first=2, last=8, count=4).listed()
    assert whole == (2, 4, 6, 8)
    assert all(isinstance(k, int) for k in whole)
    falling = Range(first=10.0, last=0.01, count=4, scale="log").listed()
    assert falling == pytest.approx((10, 1, 0.1, 0.01), rel=1e-14)
    assert (falling[0], falling[-1]) == (10.0, 0.01)


@pytest.mark.parametrize(
    "document",
    [
        {"log_uniform": [1e-150, 1e150]},
        {"uniform": [-8e307, 8e307]},
        {"from": 1e-150, "to": 1e150, "count": 9, "scale": "log"},
        {"from": -1e307, "to": 1e307, "count": 9},
    ],
)
def test_values_far_apart_are_finite_and_inside(document: object) -> None:
    values = spec(document)
    drawn = isinstance(values, Uniform | LogUniform)
    found = [values.draw(Stream(0, "x"), k) for k in range(99)] if drawn else values.listed()
    low, high = values.extremes()[0], values.extremes()[-1]
    assert all(low <= value <= high for value in found)
    assert len(set(found)) == len(found)


@pytest.mark.parametrize(
    "document",
    [
        [1, 2.5, "a", None, True],
        {"from": 1, "to": 2, "count": 3, "scale": "linear"},
        {"uniform": [0, 1]},
        {"log_uniform": [0.5, 1]},
        {"normal": [0, 1]},
        {"normal": [0, 1], "within": [-1, 2]},
        {"choice": [1, "b"]},
        {"choice": [1, "b"], "weights": [0.5, 2]},
    ],
)
def test_values_survive_their_document(document: object) -> None:
    made = spec(document)
    assert made.document() == document
    assert spec(json.loads(json.dumps(made.document()))) == made
    assert spec(made) is made


def test_a_single_value_is_a_list_of_one() -> None:
    assert spec(0.5) == Listed(values=(0.5,))
    assert spec("human") == Listed(values=("human",))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([], "expected a list of one value or more"),
        ([1, 1.0], "1.0 twice"),
        ([[1]], r"found \[1\], expected a number, text"),
        ([math.inf], "found inf"),
        ([10**400], "found inf"),
        ({}, "expected a value, a list of values, a range"),
        ({"unifrom": [0, 1]}, "found a mapping with unifrom; expected a value"),
        ({"uniform": [0, 1], "within": [0, 1]}, "found a mapping with uniform, within"),
        ({"uniform": [1, 0]}, r"uniform: found \[1, 0\], expected the smaller number first"),
        ({"uniform": [1]}, "uniform: found .* expected a list of two numbers"),
        ({"uniform": [0, "b"]}, "uniform: expected a number, found 'b'"),
        ({"log_uniform": [0, 1]}, "log_uniform: found 0, expected numbers above 0"),
        ({"log_uniform": [1e-200, 1e200]}, r"1e-200 to 1e\+200, expected at most 1e\+300 times"),
        ({"log_uniform": [5e-324, 1]}, r"log_uniform: found 4.94066e-324 to 1, expected at most"),
        ({"from": 1e-200, "to": 1e200, "count": 3, "scale": "log"}, r"to: .*at most 1e\+300 times"),
        ({"from": 1e200, "to": 1e-200, "count": 3, "scale": "log"}, r"to: .*at most 1e\+300 times"),
        ({"uniform": [-1e308, 1e308]}, r"uniform: found -1e\+308 to 1e\+308, .* less far apart"),
        ({"uniform": [-(10**308), 10**308]}, "uniform: .*expected numbers less far apart"),
        ({"from": -1e308, "to": 1e308, "count": 3}, "to: .*expected numbers less far apart"),
        ({"from": 0, "to": 1e308, "count": 9}, "to: .*expected numbers less far apart"),
        ({"normal": [0, 0]}, "standard deviation 0, expected one above 0"),
        ({"normal": [0, 1], "within": [5, 6]}, "within: .*where 2.9e-05 % .* at least 1 %"),
        ({"normal": [0, 1], "within": [2, 1]}, "within: .*smaller number first"),
        ({"choice": []}, "choice: "),
        ({"choice": [1, 2], "weights": [1]}, "weights: .* expected one number for each of the 2"),
        ({"choice": [1, 2], "weights": [1, 0]}, "weights: expected a number above 0, found 0"),
        ({"from": 1, "to": 2}, "a range without count"),
        ({"from": 1, "to": 1, "count": 2}, "to: found 1, where it begins"),
        ({"from": 1, "to": 2, "count": 1}, "count: .*at least 2"),
        ({"from": 1, "to": 2, "count": 2.0}, "count: .*a whole number"),
        ({"from": 1.0, "to": 1.0 + 2**-51, "count": 9}, "count: found 9, more numbers than"),
        ({"from": -1, "to": 2, "count": 3, "scale": "log"}, "scale: found log for -1 to 2"),
        ({"from": 1, "to": 2, "count": 3, "scale": "cubic"}, "scale: found 'cubic'"),
        ({"from": True, "to": 2, "count": 3}, "from: expected a number"),
    ],
)
def test_impossible_values(value: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        spec(value)


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("settings.clearance", ("settings", "", "clearance")),
        ("body.stature", ("body", "", "stature")),
        ("body.betas.12", ("body", "", "betas.12")),
        ("motion.yaw", ("motion", "", "yaw")),
        ("scenario.mass", ("scenario", "", "mass")),
        ("objects.mass_factor", ("objects", "", "mass_factor")),
        ("object.cup.scale", ("object", "cup", "scale")),
        ("object.tea.pot.offset_x", ("object", "tea.pot", "offset_x")),
        ("statics.yaw", ("statics", "", "yaw")),
        ("static.wall.friction", ("static", "wall", "friction")),
    ],
)
def test_names(name: str, parts: tuple[str, str, str]) -> None:
    parsed = FactorName.parse(name)
    assert (parsed.group, parsed.item, parsed.what) == parts
    assert parsed.beta == (12 if "betas" in name else None)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mass", "no factor is called that. Expected settings.FIELD; body.stature"),
        ("setings.clearance", "did you mean settings"),
        ("settings.clearence", "did you mean clearance"),
        ("settings", "no factor is called that"),
        ("body.height", "Expected stature, or betas.K"),
        ("body.betas.-1", "whole number K from 0 to 399"),
        ("body.betas.01", "betas.K"),
        ("body.betas.400", "betas.K"),
        ("body.betas.²", "betas.K"),
        ("motion.offset", "did you mean offset_[xyz]"),
        ("objects.weight", "Expected one of mass, mass_factor"),
        ("object.mass", "object.NAME.X.*objects.mass is of all"),
        ("object.cup.weight", "'weight'"),
        ("static.wall.mass", "'mass'"),
        ("statics.mass", "'mass'"),
    ],
)
def test_names_that_no_factor_has(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        FactorName.parse(name)


def checked(factors: dict[str, object], settings: dict[str, object] | None = None) -> None:
    check_factors({k: spec(v) for k, v in factors.items()}, settings or {}, ["kick_ball"], False)


def test_possible_factors() -> None:
    checked({"settings.clearance": [0.001, 0.05], "settings.strength": [None, "human"]})
    checked({"scenario.mass": {"uniform": [0.1, 3]}, "objects.restitution": [0, 1]})
    checked({"motion.yaw": {"normal": [0, 30]}, "body.stature": {"normal": [1.7, 0.1]}})
    checked({"objects.mass": {"normal": [2, 1], "within": [0.5, 4]}})
    # Neither fits the usual value of the other; one combination does.
    checked({"settings.strength": ["human"], "settings.drive_time": [0.01, None]})


@pytest.mark.parametrize(
    ("factors", "settings", "message"),
    [
        ({"settings.clearance": [0.2]}, {}, "settings.clearance: Settings.clearance is 0.2"),
        ({"settings.clearance": {"uniform": [0.01, 0.2]}}, {}, "clearance is 0.2"),
        ({"settings.substeps": [8, 0]}, {}, "substeps is 0"),
        ({"settings.substeps": {"uniform": [4, 8]}}, {}, "substeps is 4.0; expected a whole"),
        ({"settings.clearance": {"normal": [0.01, 0.01]}}, {}, "is -0.04.* Add within"),
        ({"objects.mass": {"normal": [2, 1]}}, {}, "found -4.0, expected .* Add within"),
        (
            {"settings.drive_time": [None]},
            {"strength": {"arms": 50.0}},
            "None without drive_time",
        ),
        ({"settings.mode": ["velocity", "torqe"]}, {}, "mode"),
        ({"settings.clearance": [0.01]}, {"clearance": 0.02}, "also in settings"),
        ({"objects.mass": [0]}, {}, "objects.mass: found 0, expected a number above 0"),
        ({"objects.mass": ["heavy"]}, {}, "found 'heavy', expected a number above 0"),
        ({"objects.mass": [True]}, {}, "found True"),
        ({"statics.restitution": {"uniform": [0, 1.5]}}, {}, "found 1.5, expected a number of"),
        ({"body.stature": [3]}, {}, "found 3, expected a number of at least 0.4 and of at most"),
        ({"object.cup.mass": [1], "object.cup.mass_factor": [2]}, {}, "beside object.cup.mass;"),
        ({"scenario.weight": [1]}, {}, "kick_ball has no option 'weight'"),
        ({"scenario.body": [1]}, {}, "kick_ball has no option 'body'"),
    ],
)
def test_impossible_factors(
    factors: dict[str, object], settings: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        checked(factors, settings)


def test_options_of_scenarios_need_scenarios() -> None:
    factors = {"scenario.mass": spec([1])}
    with pytest.raises(InputError, match="inputs are all scenarios"):
        check_factors(factors, {}, [], True)
    with pytest.raises(InputError, match="inputs are all scenarios"):
        check_factors(factors, {}, ["kick_ball"], True)


def test_settings_are_those_of_a_simulation() -> None:
    check_settings({"stiffness": {"left_arm": 0.5}, "clearance": 0.002})
    with pytest.raises(InputError, match=r"stifness: .*did you mean stiffness"):
        check_settings({"stifness": 1})
    with pytest.raises(InputError, match=r"clearance is 0\.2"):
        check_settings({"clearance": 0.2})


def test_extremes_are_where_values_are_checked() -> None:
    assert Uniform(low=0, high=1).extremes() == (0, 1)
    assert LogUniform(low=1, high=2).extremes() == (1, 2)
    assert Normal(mean=0, sd=1).extremes() == (-6, 6)
    assert Normal(mean=0, sd=1, within=(-1, 1)).extremes() == (-1, 1)
    assert Choice(values=(1, "a")).extremes() == (1, "a")

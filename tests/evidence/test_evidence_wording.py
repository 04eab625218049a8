"""Numbers, verdicts and names in the report."""

from __future__ import annotations

import math

import evidence_sample as sample
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evidence import document
from evidence.page.wording import number, plain, published, quantity, signed
from evidence.verdicts import VERDICTS, tally, verdict


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (None, "–"), (0, "0"), (0.0, "0"), (-0.0, "0"), (True, "yes"), (False, "no"),
        (100.0, "100"), (83.1094, "83.11"), (0.00042, "0.00042"), (1.3e-10, "1.3e-10"),
        (-0.0131, "-0.0131"), (952.94, "952.9"), (10423.71, "10,424"), (1234567.0, "1,234,567"),
        (1e7, "1e7"), (1.2345e12, "1.23e12"), (-2e300, "-2e300"), (5e-324, "4.94e-324"),
        (12345678, "12,345,678"), (1000, "1000"), (9999.6, "10,000"), (0.99996, "1"),
        (math.nan, "–"), (math.inf, "∞"), (-math.inf, "-∞"), ("blocked", "blocked"), ("", "–"),
    ],
)  # fmt: skip
def test_numbers_have_the_digits_that_mean_something(value, said):
    assert number(value) == said


@pytest.mark.parametrize(
    ("ours", "paper", "said"),
    [
        (61.4567, 83.109, "61.457"), (61.0, 83.109, "61.000"), (0.00312, 0.003, "0.00312"),
        (1.3e-10, 0.003, "1.3e-10"), (0.00042, 0.003, "0.00042"), (0.0213, 0.0, "0.0213"),
        (100.0, 92.5, "100.0"), (0.0, 83.109, "0"), (99.96, 100.0, "99.96"), (99.0, 100, "99"),
        (133.2, None, "133.2"), (10423.71, 952.94, "10,423.7"),
    ],
)  # fmt: skip
def test_ours_has_the_decimals_of_the_papers(ours, paper, said):
    assert number(ours, beside=paper) == said


@settings(deadline=None)
@given(st.floats(-1.79e308, 1.79e308))
def test_what_is_printed_is_the_number(value):
    assert float(number(value).replace(",", "")) == pytest.approx(value, rel=6e-3, abs=5e-324)
    assert published(value) == published(-value) or value != 0


@settings(deadline=None)
@given(st.floats(1e-3, 1e6).map(lambda x: round(x, 3)))
def test_the_papers_numbers_are_printed_in_full(value):
    assert float(published(value).replace(",", "")) == value


def test_minus_is_typeset():
    assert signed("-3.5") == "−3.5"
    assert signed("1e-5") == "1e-5"


def test_quantities():
    assert quantity("distance", "mm") == "distance [mm]"
    assert quantity("λ", "") == "λ"
    assert quantity("", "s") == "[s]"


@settings(deadline=None)
@given(st.text())
def test_names_are_one_line_that_steers_nothing(text):
    said = plain(text)
    said.encode("utf-8")
    assert "\x1b" not in said
    assert "\u202e" not in said
    assert said == " ".join(said.split())
    assert plain(said) == said


def test_names_in_any_script_stay():
    assert plain(" Übung\n\t舞蹈 кино λ ✓ ") == "Übung 舞蹈 кино λ ✓"
    assert plain("a\udcffb\x00c\u202ed") == "a\ufffdb\ufffdc\ufffdd"


def test_verdicts():
    def of(ours, expected, reproduced, direction=False, quoted=False):
        row = sample.row("x", [], quoted=quoted)
        return verdict(row, sample.figure("m", "", 1.0, ours, expected, reproduced, direction))

    assert of(1.0, "1", True) == "reproduced"
    assert of(1.0, "2", False) == "not_reproduced"
    assert of(1.0, "1", True, direction=True) == "direction"
    assert of(1.0, "2", False, direction=True) == "not_reproduced"
    assert of(1.0, "", None) == "shown"
    assert of(None, "", None) == "shown"
    assert of(None, "1", None) == "missing"
    assert of(None, "1", False) == "missing"
    assert of(None, "", None, quoted=True) == "quoted"
    marks = [mark for mark, _ in VERDICTS.values()]
    assert len(set(marks)) == len(marks)


def test_the_tally_counts_every_figure_and_every_error():
    sections = sample.document()["sections"]
    counts = tally(sections)
    figures = sum(len(row["figures"]) for s in sections for row in s["rows"])
    assert sum(counts.values()) == figures + 2
    assert counts["quoted"] == 2
    assert min(counts.values()) > 0
    assert document.verdict(sections) == {k: n for k, n in counts.items() if k != "quoted"}

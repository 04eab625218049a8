"""-q, -v and -vv: what is printed, by any command."""

from __future__ import annotations

import logging

import pytest

from halfphysics.cli.loudness import Loudness, is_quiet, taken
from halfphysics.errors import InputError
from support.command_line import run


@pytest.mark.parametrize(
    ("arguments", "rest", "steps"),
    [
        (["formats"], ["formats"], 0),
        (["-q", "formats"], ["formats"], -1),
        (["formats", "--quiet", "-q"], ["formats"], -1),
        (["simulate", "-v", "walk.npz"], ["simulate", "walk.npz"], 1),
        (["simulate", "-v", "--verbose"], ["simulate"], 2),
        (["simulate", "-vv"], ["simulate"], 2),
        (["view", "--", "-q"], ["view", "--", "-q"], 0),
    ],
)
def test_what_is_taken(arguments, rest, steps):
    assert taken(arguments) == (rest, Loudness(steps))


def test_less_and_more_is_a_mistake():
    with pytest.raises(InputError, match="-q and -vv: expected --quiet or --verbose"):
        taken(["-q", "formats", "-vv"])


def test_quiet_prints_errors_alone(capsys):
    assert run("formats", "-q") == 0
    assert capsys.readouterr() == ("", "")
    assert run("-q", "simulate", "no.npz") == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("halfphysics: error: no.npz")
    assert not is_quiet()


@pytest.mark.parametrize(("steps", "seen"), [(0, ""), (1, "info\n"), (2, "info\ndebug\n")])
def test_verbose_shows_the_log(steps, seen, capsys):
    logger = logging.getLogger("halfphysics.some.module")
    with Loudness(steps).applied():
        logger.info("info")
        logger.debug("debug")
    logger.info("after")
    assert capsys.readouterr().err.replace("halfphysics: ", "") == seen
    assert logging.getLogger("halfphysics").level == logging.NOTSET

"""Scenarios of two people: the command line, and mistakes."""

from __future__ import annotations

import re

import pytest

import halfphysics as hp
from halfphysics.cli import main
from halfphysics.errors import InputError


@pytest.mark.parametrize(("name", "depth"), [("meet", 50.0), ("shake_hands", 5.0)])
def test_from_the_command_line(name, depth, tmp_path, capsys):
    target = tmp_path / "r.npz"
    assert main(["scenario", name, "--fps", "6", "--out", str(target)]) == 0
    assert hp.Result.load(target).summary() in capsys.readouterr().out
    assert main(["evaluate", str(target)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    rows = re.findall(r"^deepest in other people \[mm\] +(\S+) +(\S+)$", out, re.MULTILINE)
    assert len(rows) == 2  # one a person
    for asked, got in rows:
        assert float(asked) > depth
        assert float(got) == 0.0


def test_mistakes():
    with pytest.raises(InputError, match=r"offset: expected a number from -2 to 2 \[m\], found 3"):
        hp.scenarios.load("meet", offset=3.0)
    with pytest.raises(InputError, match="shakes: found -1, expected 0 to 50"):
        hp.scenarios.load("shake_hands", shakes=-1)
    with pytest.raises(InputError, match=r"press: expected .* from 0 to 0\.02 \[m\], found 0\.5"):
        hp.scenarios.load("shake_hands", press=0.5)
    with pytest.raises(InputError, match=r"stature: found .* people more alike"):
        hp.scenarios.load("shake_hands", stature=0.5)

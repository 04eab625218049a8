"""halfphysics play: what it refuses."""

from __future__ import annotations

import pytest

from support.command_line import run


@pytest.mark.parametrize(
    "words",
    [
        ["--no-ground"],
        ["--static", "box=box:1:1:1"],
        ["--stature", "1.5"],
        ["--frames", "0:9"],
    ],
)
@pytest.mark.parametrize("what", ["kick_ball", "ws://127.0.0.1:1"])
def test_options_of_motions_are_refused_without_one(what, words, capsys):
    assert run("play", what, *words) == 2
    err = capsys.readouterr().err
    assert "give a motion file, or leave them out" in err

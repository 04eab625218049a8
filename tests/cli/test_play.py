"""halfphysics play: what it refuses, and who is played."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics.formats import save_people
from halfphysics.viewer import playground
from support.command_line import run
from support.files import model_files
from support.files.wrong_axes import walker

FRAMES = 12
ASIDE = np.array([0.0, 1.5, 0.0])
#: Places in double precision.
ROUNDING = 1e-12


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


def two_people(path, genders):
    """A file of two people who walk side by side."""
    people = [dataclasses.replace(walker()[:FRAMES], gender=gender) for gender in genders]
    aside = people[1].with_frames(people[1].translation + ASIDE, people[1].rotations)
    save_people([people[0], aside], path, [None, None], format="interhuman")
    return path


def test_everybody_in_a_file_is_played(tmp_path, monkeypatch):
    started = []
    monkeypatch.setattr(
        playground, "play", lambda catalog, choice, **_: started.append((catalog, choice))
    )
    assert run("play", two_people(tmp_path / "pair.pkl", ("male", "female"))) == 0
    ((catalog, choice),) = started
    sequence = catalog.load(choice)
    assert len(sequence.motions) == len(sequence.bodies) == 2
    between = sequence.motions[1].translation - sequence.motions[0].translation
    assert np.abs(between - ASIDE).max() < ROUNDING


def test_the_body_has_to_fit_everybody_in_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(playground, "play", lambda catalog, choice, **_: catalog.load(choice))
    path = two_people(tmp_path / "pair.pkl", ("male", "female"))
    np.savez(tmp_path / "SMPLH_MALE.npz", **model_files.fields("smplh"))
    assert run("play", path, "--body", tmp_path / "SMPLH_MALE.npz") == 2
    assert "the motion is of smplh female, the body" in capsys.readouterr().err

"""halfphysics scenario: names, the options of each, files written, messages for mistakes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.cli import main, scenario


def run(*arguments):
    return main(["scenario", *(str(argument) for argument in arguments)])


def test_the_list_names_every_scenario_and_option(capsys):
    assert run("--list") == 0
    out, err = capsys.readouterr()
    assert err == ""
    blocks = {block.split("\n")[0]: block for block in out.strip().split("\n\n")}
    assert tuple(blocks) == scenarios.names()
    for name, block in blocks.items():
        assert scenarios.describe(name) in " ".join(block.split())
        for option, default in scenarios.options(name).items():
            flag = f"--{option.replace('_', '-')}"
            if isinstance(default, bool):
                form = f"--no-{flag[2:]}" if default else flag
            elif default is None:
                form = f"{flag} none"
            elif isinstance(default, float):
                form = f"{flag} {default:g}"
            else:
                form = f"{flag} {' '.join(default) if isinstance(default, tuple) else default}"
            assert (form in block) == (option not in ("body", "other")), form


@pytest.mark.parametrize("name", scenarios.names())
def test_every_scenario_has_a_help_for_each_option(name, capsys):
    assert run(name, "--help") == 0
    out = capsys.readouterr().out
    assert f"usage: halfphysics scenario {name}" in out
    reserved = {f.name for f in dataclasses.fields(hp.Settings)}
    reserved |= {f.name for f in dataclasses.fields(scenario.Outputs)}
    helps = scenarios.explain(name)
    for option in set(scenarios.options(name)) - {"body", "other"}:
        assert option not in reserved
        assert f"--{option.replace('_', '-')}" in out
        assert helps[option]


def test_a_run_is_that_of_python(tmp_path, capsys):
    target = tmp_path / "r.npz"
    options = ("--mass", 2, "--fps", 15, "--stiffness", 0.5, "--contact", "parts")
    assert run("kick_ball", *options, "--out", target) == 0
    out, err = capsys.readouterr()
    assert err == ""
    result = hp.Result.load(target)
    assert result.summary() in out
    story = scenarios.load("kick_ball", mass=2.0, fps=15.0)
    settings = hp.Settings(stiffness=0.5, contact="parts")
    same = hp.simulate(story.motion, story.scene, body=story.body, settings=settings)
    assert result.settings == settings
    np.testing.assert_array_equal(result.motion.rotations, same.motion.rotations)
    ball = result.objects["ball"].position
    np.testing.assert_array_equal(ball, same.objects["ball"].position)


def test_what_is_not_said_is_as_the_scenario_has_it(monkeypatch):
    story = scenarios.load("kick_ball")
    own = dataclasses.replace(story, settings=hp.Settings.paper(stiffness=0.0))
    monkeypatch.setattr(scenarios, "load", lambda name, **options: own)
    play = scenario.read("halfphysics scenario", ["kick_ball", "--stiffness", "1.0"])
    assert play.settings == hp.Settings.paper(stiffness=1.0)
    play = scenario.read("halfphysics scenario", ["kick_ball"])
    assert play.settings == own.settings


def test_page_and_pictures(tmp_path, capsys, monkeypatch):
    drawn = []
    # Drawing takes seconds and has its own tests.
    monkeypatch.setattr(
        "halfphysics.render.contact_sheet.save_contact_sheet",
        lambda result, path: drawn.append(path),
    )
    page, pictures = tmp_path / "p.html", tmp_path / "p.png"
    assert run("kick_ball", "--fps", 5, "--page", page, "--pictures", pictures) == 0
    out = capsys.readouterr().out
    assert f"page: {page}" in out
    assert "halfphysics kick_ball" in page.read_text(encoding="utf-8")
    assert drawn == [pictures]


MISTAKES = {
    "no name": ((), "found nothing, expected a name first: one of ball_on_cushion"),
    "an option first": (("--mass", 3), "found '--mass', expected a name first"),
    "unknown name": (("kick_bal",), r"unknown scenario 'kick_bal'; did you mean kick_ball\?"),
    "unknown option": (("kick_ball", "--wight", 3), "unknown option --wight; did you mean"),
    "no number": (("kick_ball", "--mass", "heavy"), "--mass.*'heavy'"),
    "impossible": (("kick_ball", "--speed", 99), "speed: found 99.0, expected 0.5 to 15.0 m/s"),
    "list of one": (("kick_ball", "--list"), "--list: found 'kick_ball' beside it"),
    "no folder": (("kick_ball", "--out", "nowhere/r.npz"), "folder nowhere does not exist"),
    "one file twice": (("kick_ball", "--out", "a.html", "--page", "a.html"), "one file for two"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_mistakes_end_in_one_message(case, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments, expected = MISTAKES[case]
    assert run(*arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("halfphysics: error: ")
    assert err.count("\n") == 1
    with pytest.raises(hp.HalfPhysicsError, match=expected):
        raise hp.HalfPhysicsError(err)
    assert not list(tmp_path.iterdir())

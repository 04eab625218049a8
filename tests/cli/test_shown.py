"""What commands that show take: results and motions, with options for motions only."""

from __future__ import annotations

import pytest

import halfphysics as hp
from halfphysics.cli.options import BodyOptions, MotionOptions
from halfphysics.cli.shown import opened
from halfphysics.errors import InputError
from halfphysics.viewer.motions import is_untouched
from support.command_line import run
from support.people import along_x


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    motion = along_x(1.0, 12, 0.0, z=1.2)
    motion.save(folder / "walk.npz")
    hp.simulate(motion, settings=hp.Settings(contact="parts")).save(folder / "result.npz")
    return folder / "walk.npz", folder / "result.npz"


def test_results_and_motions_are_opened_with_their_options(files):
    walk, result = files
    first, second = opened([walk, result], MotionOptions(frames="2:7"), BodyOptions(stature=1.9))
    assert (len(first), len(second)) == (5, 12)
    assert is_untouched(first)
    assert first.people[0].body.mass > second.people[0].body.mass


def test_options_for_motions_are_refused_where_all_are_results(files):
    _, result = files
    with pytest.raises(InputError, match="a result has its own bodies and frames"):
        opened([result], MotionOptions(frames="2:7"), BodyOptions())
    assert len(opened([result], MotionOptions(), BodyOptions())) == 1


def test_a_motion_is_rendered(files, tmp_path, capsys):
    walk, _ = files
    for name in ("still.png", "page.html"):
        arguments = ["--frame", "3"] if name.endswith("png") else []
        assert run("render", walk, tmp_path / name, *arguments) == 0
        assert (tmp_path / name).stat().st_size > 1000
    assert "<title>walk</title>" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_options_of_a_motion_and_of_its_film_have_names_of_their_own(files, tmp_path, capsys):
    walk, _ = files
    of_motion = ["--frames", "2:7", "--motion-fps", "30"]
    assert run("render", walk, tmp_path / "last.png", "--frame", "4", *of_motion) == 0
    assert run("render", walk, tmp_path / "beyond.png", "--frame", "5", *of_motion) == 2
    assert "5 frames" in capsys.readouterr().err

"""halfphysics render: the files that it writes, and its messages for mistakes."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

import halfphysics as hp
from halfphysics.cli import main
from halfphysics.render.film import FilmOptions, save_film
from support.results.small_result import small_result


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A result file of 8 frames."""
    made = small_result()
    result = hp.simulate(made.reference[:8], made.scene)
    path = tmp_path_factory.mktemp("source") / "walk.npz"
    result.save(path)
    return path


@pytest.fixture(autouse=True)
def quick(monkeypatch, tmp_path):
    """In an empty folder; without the search for the best direction, which takes a second."""
    best = np.array([0.5, -0.8, 0.33]) / np.linalg.norm([0.5, -0.8, 0.33])
    monkeypatch.setattr("halfphysics.render.film.tracking.choose_direction", lambda *_: best)
    monkeypatch.setattr("halfphysics.render.contact_sheet.choose_direction", lambda *_: best)
    monkeypatch.chdir(tmp_path)


def run(*arguments):
    return main(["render", *map(str, arguments)])


SMALL = ("--size", "96x64", "--samples", "1")


@pytest.mark.slow
def test_the_suffix_says_what_is_written(source, tmp_path, capsys):
    pytest.importorskip("imageio_ffmpeg")
    for name, kind in (
        ("film.mp4", "film"),
        ("film.gif", "film"),
        ("strip.png", "picture"),
    ):
        assert run(source, name, *SMALL) == 0
        assert capsys.readouterr().out == f"{kind}: {name}\n"
    assert (tmp_path / "film.mp4").read_bytes()[4:8] == b"ftyp"
    assert (tmp_path / "film.gif").read_bytes()[:6] == b"GIF89a"
    with Image.open("strip.png") as strip:
        assert strip.size[0] == 2 * 14 + 6 * (96 + 6) - 6
    assert run(source, "page.html", "--fps", "15", "--label", "A walk") == 0
    assert "<title>A walk</title>" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_the_command_writes_what_python_writes(source, tmp_path):
    options = ("--camera", "follow", "--camera", "top", "--speed", "0.5", "--end", "0.1")
    assert run(source, "a.gif", *SMALL, *options, "--no-ghost", "--label", "a", "--fps", "30") == 0
    same = FilmOptions(
        camera=("follow", "top"), size=(96, 64), samples=1, speed=0.5, end=0.1, ghost=False,
        label=("a",), fps=30.0,
    )  # fmt: skip
    save_film(hp.Result.load(source), "b.gif", same)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


def test_a_page_shows_what_holds_people_up_when_asked(source, tmp_path):
    pytest.importorskip("viser")
    assert run(source, "plain.html") == 0
    assert run(source, "held.html", "--support") == 0
    assert "supporting force" not in (tmp_path / "plain.html").read_text(encoding="utf-8")
    assert "supporting force" in (tmp_path / "held.html").read_text(encoding="utf-8")


def test_one_frame_and_several_results(source):
    assert run(source, "one.png", "--frame", "-1", *SMALL) == 0
    with Image.open("one.png") as one:
        assert one.size == (96, 64)
    assert run(source, source, "two.png", "--frame", "3", "--samples", "1") == 0
    with Image.open("two.png") as two:
        assert two.size == (1280, 480)
        corner = np.asarray(two)[:40, :70].max(axis=2)
    assert (corner < 90).sum() > 20  # the file's name, in dark letters


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["R"], "file to write"),
        (["R", "film.avi"], "expected .html, .png, .mp4, .webm, .gif"),
        (["gone.npz", "film.gif"], "gone.npz"),
        (["R", "no/film.gif"], "does not exist"),
        (["R", "R"], "suffix '.npz'"),
        (["R", "a.png", "--frame", "8"], "8 frames (0 to 7)"),
        (["R", "a.gif", "--frame", "1"], "a frame is for a .png"),
        (["R", "a.gif", "--support"], "shown on a page"),
        (["R", "a.gif", "--camera", "sky"], "'sky'"),
        (["R", "a.gif", "--size", "0x10"], "16 to 8192"),
        (["R", "a.mp4", "--size", "641x480"], "642x480"),
        (["R", "a.gif", "--start", "7"], "ends at 0.233 s"),
        (["R", "a.html", "--camera", "top"], "for a page"),
        (["R", "a.gif", "--label", "a", "--label", "b"], "label"),
    ],
)
def test_a_mistake_is_one_message_and_leaves_nothing(source, tmp_path, capsys, arguments, words):
    assert run(*(str(source) if a == "R" else a for a in arguments)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("halfphysics: error: ")
    assert err.count("\n") == 1
    assert words in err
    assert list(tmp_path.iterdir()) == []

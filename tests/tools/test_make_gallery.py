"""docs/scenarios.md: every built-in scenario, up to date, with a picture."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from PIL import Image

from halfphysics import scenarios
from support.paths import ROOT

PICTURES = ROOT / "docs" / "pictures"
AGAIN = "python tools/make_gallery.py makes it anew"


@pytest.fixture(scope="module")
def gallery():
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import make_gallery

        yield make_gallery
    finally:
        sys.path.remove(str(ROOT / "tools"))


def test_the_page_is_what_the_scenarios_say_of_themselves(gallery):
    written = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    assert written == gallery.markdown(), AGAIN
    heads = [line[3:] for line in written.splitlines() if line.startswith("## ")]
    assert heads == list(scenarios.names())
    for name in scenarios.names():
        assert scenarios.describe(name) in written
        texts = {k: v for k, v in scenarios.options(name).items() if k not in ("body", "other")}
        missing = set(texts) - set(scenarios.explain(name))
        assert not missing, f"{name}: no word on {missing}"


def test_every_scenario_has_a_small_picture_and_every_picture_a_scenario(gallery):
    assert set(gallery.SHOTS) == set(scenarios.names()), "a line in tools/gallery_shots.py"
    files = {path.name: path.stat().st_size for path in PICTURES.glob("*.png")}
    assert set(files) == {f"{name}.png" for name in scenarios.names()}, AGAIN
    assert max(files.values()) < 60_000
    assert sum(files.values()) < 1_500_000
    for name, shot in gallery.SHOTS.items():
        with Image.open(PICTURES / f"{name}.png") as picture:
            assert picture.format == "PNG"
            assert picture.width > len(shot.times) * gallery.SIZE[0]
            colors = np.asarray(picture.convert("RGB")).reshape(-1, 3)
        assert colors.std(axis=0).min() > 15, f"{name}: nothing to see"


def test_a_picture_shows_what_the_program_does_now(gallery, tmp_path, monkeypatch):
    monkeypatch.setattr(gallery, "PICTURES", tmp_path)
    now, committed = (
        np.asarray(Image.open(path).convert("RGB")).astype(float)
        for path in (gallery.draw("crawl_under_table"), PICTURES / "crawl_under_table.png")
    )
    assert now.shape == committed.shape
    # Palettes and last bits may differ between machines, a camera or a pose may not.
    assert np.abs(now - committed).mean() < 1.0, AGAIN


def test_one_scenario_can_be_asked_for_alone(gallery, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(gallery, "DOCS", tmp_path)
    monkeypatch.setattr(gallery, "PICTURES", tmp_path / "pictures")
    gallery.main(["--text"])
    assert [path.name for path in tmp_path.iterdir()] == ["scenarios.md"]
    with pytest.raises(SystemExit):
        gallery.main(["kick_bal"])
    assert "kick_bal" in capsys.readouterr().err


def test_the_film_is_short_moves_and_repeats():
    path = ROOT / "docs" / "film.webp"
    assert path.stat().st_size < 3_000_000
    with Image.open(path) as film:
        assert film.format == "WEBP"
        assert film.info["loop"] == 0  # the film repeats forever
        pictures = []
        for k in (0, film.n_frames // 2, film.n_frames - 1):
            film.seek(k)
            pictures.append(np.asarray(film.convert("RGB")).astype(float))
        assert film.n_frames >= 40
    assert pictures[0].shape[1] >= 640
    assert np.abs(np.diff(pictures, axis=0)).mean(axis=(1, 2, 3)).min() > 1.0
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert readme.index("docs/film.webp") < readme.index("docs/demo.png") < readme.index("## ")
    assert (ROOT / "docs" / "demo.png").stat().st_size < 300_000

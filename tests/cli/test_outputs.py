"""What is written of a result, and what is refused before the work."""

from __future__ import annotations

import subprocess
import sys
import webbrowser
from pathlib import Path

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli import outputs
from halfphysics.cli.options import check_output
from halfphysics.cli.outputs import Outputs, open_page
from halfphysics.errors import FileError, InputError


@pytest.fixture
def result():
    """Two frames of the default body by a ball."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    motion = hp.Motion(np.full((2, 3), (0.0, 0.0, 1.2)), np.zeros((2, 55, 3)), 30.0)
    return hp.simulate(motion, scene, settings=hp.Settings(contact="parts"))


def test_all_is_written(result, tmp_path, capsys, monkeypatch):
    drawn, opened = [], []
    # Drawing takes seconds and has its own tests.
    for what in ("contact_sheet.save_contact_sheet", "film.save_film"):
        monkeypatch.setattr(
            f"halfphysics.render.{what}", lambda result, path, **options: drawn.append(path.name)
        )
    monkeypatch.setattr(outputs, "open_page", opened.append)
    files = {"out": "r.npz", "page": "r.html", "pictures": "r.png", "film": "r.gif"}
    chosen = Outputs(**{name: tmp_path / file for name, file in files.items()}, open=True)
    chosen.check()
    chosen.write(result, "a title")
    assert drawn == ["r.png", "r.gif"]
    assert opened == [tmp_path / "r.html"]
    assert len(hp.Result.load(tmp_path / "r.npz")) == 2
    assert "<title>a title" in (tmp_path / "r.html").read_text(encoding="utf-8")
    said = capsys.readouterr().out.splitlines()
    assert said == [
        f"{what}: {tmp_path / files[name]}"
        for name, what in (
            ("out", "result"),
            ("pictures", "pictures"),
            ("film", "film"),
            ("page", "page"),
        )
    ]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"page": "p.htm"}, r"--page: found p\.htm, expected a name that ends in \.html"),
        ({"pictures": "p.jpg"}, r"--pictures: found p\.jpg, .* \.png"),
        ({"film": "f.avi"}, r"--film: found f\.avi, .* \.mp4 or \.webm or \.gif"),
        ({"out": "a.png", "pictures": "a.png"}, "--out, --pictures: found one file for two"),
        ({"out": "a.html"}, r"--out: found a\.html, .* \(\.npz\); --page writes a\.html"),
        ({"out": "a.MP4"}, r"--out: found a\.MP4, .* --film writes"),
        ({"out": "a.glb"}, r"--out: found a\.glb, .* halfphysics convert RESULT a\.glb"),
        ({"open": True}, "--open: shows the page in a browser; say where with --page FILE"),
    ],
)
def test_mistakes(given, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    paths = {name: Path(v) if isinstance(v, str) else v for name, v in given.items()}
    with pytest.raises(InputError, match=message):
        Outputs(**paths).check()


@pytest.mark.parametrize("option", ["out", "page", "pictures", "film"])
def test_a_folder_that_is_not_there_is_noticed_for_each(option, tmp_path):
    suffix = {"out": "npz", "page": "html", "pictures": "png", "film": "gif"}[option]
    with pytest.raises(FileError, match="no does not exist"):
        Outputs(**{option: tmp_path / "no" / f"r.{suffix}"}).check()


def test_devices_are_refused():
    with pytest.raises(FileError, match="pipe or a device"):
        check_output(Path("/dev/full" if Path("/dev/full").exists() else "/dev/null"))


@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
def test_a_full_folder_is_noticed_before_the_work(tmp_path):
    """A process that may write no file of a megabyte, as on a full disk."""
    script = (
        "import resource, sys; from pathlib import Path\n"
        "from halfphysics.cli.options import check_output\n"
        "from halfphysics.errors import FileError\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try: check_output(Path(sys.argv[1]))\n"
        "except FileError as error: print(error)\n"
    )
    target = tmp_path / "r.npz"
    done = subprocess.run(
        [sys.executable, "-c", script, target], capture_output=True, text=True, check=True
    )
    assert done.stdout == (
        f"{target}: cannot write in {tmp_path}: File too large. Make room on the disk and try "
        "again\n"
    )
    assert not list(tmp_path.iterdir())


def test_no_browser_is_no_error(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(webbrowser, "open", lambda uri: asked.append(uri) or True)
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert not open_page(tmp_path / "p.html")
    assert asked == []
    monkeypatch.setenv("DISPLAY", ":0")
    assert open_page(tmp_path / "p.html")
    assert asked == [(tmp_path / "p.html").as_uri()]

    def fails(uri):
        raise webbrowser.Error("no browser")

    monkeypatch.setattr(webbrowser, "open", fails)
    assert not open_page(tmp_path / "p.html")

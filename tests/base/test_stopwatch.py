"""What takes over a second is logged at INFO under "halfphysics"; nobody is written to unasked."""

from __future__ import annotations

import logging
import subprocess
import sys

import pytest

import halfphysics as hp
from halfphysics.base import stopwatch
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.geometry.convex_decomposition import Cut, decompose
from support import small_results as small

HERE = logging.getLogger("halfphysics.here")


def messages(caplog, level):
    return [r.getMessage() for r in caplog.records if r.levelno == level]


def test_what_takes_long_is_worth_knowing(caplog, monkeypatch):
    caplog.set_level(logging.DEBUG, logger="halfphysics")
    now = [10.0]
    monkeypatch.setattr(stopwatch.time, "perf_counter", lambda: now[0])
    for seconds, level in ((0.5, logging.DEBUG), (2.0, logging.INFO)):
        clock = Stopwatch(HERE)
        now[0] += seconds
        clock.done("did %d things", 100, count=100, unit="thing")
        rate = 100 / seconds
        words = f"did 100 things in {seconds:.2f} s ({rate:.3g} things/s)"
        assert messages(caplog, level) == [words]
        assert caplog.records[-1].name == "halfphysics.here"


def test_short_work_costs_no_words(caplog):
    caplog.set_level(logging.INFO, logger="halfphysics")
    Stopwatch(HERE).done("did something")
    assert caplog.records == []


@pytest.fixture
def everything_long(caplog, monkeypatch):
    """As if all took over a second."""
    monkeypatch.setattr(stopwatch, "LONG", 0.0)
    caplog.set_level(logging.INFO, logger="halfphysics")
    return caplog


def test_a_simulation_says_what_it_did(everything_long):
    hp.simulate(small.motions()[0], small.scene())
    *_, built, simulated = messages(everything_long, logging.INFO)
    assert built.startswith("built the world of 1 person and 8 items in ")
    assert simulated.startswith("simulated 23 frames of 1 person in ")
    assert simulated.endswith(" frames/s)")


def test_files_say_what_was_read_and_written(everything_long, tmp_path):
    small.alone()
    everything_long.clear()
    path, motion, scene = (str(tmp_path / n) for n in ("out.npz", "walk.npz", "room.yaml"))
    small.alone().save(path)
    hp.Result.load(path)
    small.motions()[0].save(motion)
    hp.Motion.load(motion)
    small.alone().scene.save(scene)
    hp.Scene.load(scene)
    found = [text.split(" in ")[0] for text in messages(everything_long, logging.INFO)]
    assert found == [
        f"saved {path}, 24 frames",
        f"loaded {path}: {small.motions()[0]!r}",  # which a result holds
        f"loaded {path}: {small.alone()!r}",
        f"saved {motion}, 24 frames",
        f"loaded {motion}: {small.motions()[0]!r}",
        f"loaded {scene}: 2 items",
    ]


def test_long_measures_say_so(everything_long):
    hp.support.estimate(small.motions()[0], small.scene())
    hp.simulate_many([small.motions()[0]], threads=1)
    text = "\n".join(messages(everything_long, logging.INFO))
    assert "estimated the support of 24 frames in " in text
    assert "simulated 1 jobs in 1 threads in " in text


def test_cut_meshes_are_logged(everything_long):
    pytest.importorskip("coacd")
    decompose(_bracket(), Cut(threshold=0.01, max_pieces=2))
    text = "\n".join(messages(everything_long, logging.INFO))
    assert "cut a mesh of 20 triangles into 2 convex pieces, " in text


def _bracket():
    """An L of side 0.2 m and thickness 0.1 m."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    vertices = [(0.1 * x, 0.1 * y, z) for z in (0.0, 0.1) for x, y in outline]
    top = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [tuple(reversed(f)) for f in top] + [tuple(k + 6 for k in f) for f in top]
    faces += [t for k in range(6) for t in _side(k, (k + 1) % 6)]
    return hp.Mesh(vertices, faces)


def _side(a, b):
    return [(a, b, b + 6), (a, b + 6, a + 6)]


def test_details_are_for_debugging(caplog):
    caplog.set_level(logging.DEBUG, logger="halfphysics")
    hp.simulate(small.motions()[0], settings=hp.Settings(tolerance=2e-6))
    assert "Settings(tolerance=2e-06)" in messages(caplog, logging.DEBUG)


def test_no_handler_is_installed():
    """A program that asks for nothing gets nothing on its standard error."""
    code = (
        "import logging, halfphysics as hp, halfphysics.base.stopwatch as s; s.LONG = 0.0\n"
        "hp.Body.default().variant\n"
        "print([n for n, l in logging.root.manager.loggerDict.items()"
        " if n.startswith('halfphysics') and getattr(l, 'handlers', [])])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (found.stdout.strip(), found.stderr) == ("[]", "")

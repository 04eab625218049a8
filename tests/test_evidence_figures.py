"""The paper's figures as evidence: what they claim holds, and what comes out of it is rows."""

from __future__ import annotations

import functools
import importlib
import io
import json

import pytest
from PIL import Image

from halfphysics.bench.paper import evidence, objects, playing, scenes
from halfphysics.bench.paper.evidence import Options

#: A picture of a strip [bytes].
LARGEST_PICTURE = 150_000


@functools.cache
def done(function, arguments):
    """What a task found, its values as they come back from JSON."""
    module, name = function.split(":")
    module = importlib.import_module(f"halfphysics.bench.paper.{module}")
    outcome = getattr(module, name)(**json.loads(arguments))
    return json.loads(json.dumps(evidence.plain(outcome.values, name))), outcome.pictures


def run(task):
    return done(task.function, json.dumps(dict(task.arguments), sort_keys=True))


def played(section, *keys, quick=True):
    """The values of these tasks of a section, by key."""
    tasks = {task.key: task for task in section.tasks(Options(quick=quick))}
    return {key: run(tasks[key])[0] for key in keys}


def figures(row):
    return {figure.name: figure for figure in row.figures}


def check_content(section, values, options=None):
    """What a section makes of these values; of none it makes nothing."""
    options = options or Options(quick=True)
    empty = section.content(options, {})
    assert (empty.rows, empty.plots, empty.pictures) == ((), (), ())
    content = section.content(options, values)
    evidence.to_dict(content)  # all that JSON can say
    tasks = {task.key for task in section.tasks(options)}
    assert {picture.task for picture in content.pictures} <= tasks & set(values)
    return content


SECTIONS = (scenes.SECTION, objects.SECTION)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda s: s.key)
def test_tasks(section):
    for quick, most in ((True, 25.0 / 2), (False, 200.0)):
        tasks = section.tasks(Options(quick=quick))
        assert len({task.key for task in tasks}) == len(tasks)
        assert sum(task.seconds for task in tasks) <= most
        for task in tasks:
            assert json.loads(json.dumps(task.arguments)) == dict(task.arguments)


def test_settings_are_said_as_one_writes_them():
    assert playing.said({}) == "Settings()"
    assert playing.said({"mode": "positions"}) == "Settings(mode='positions')"
    assert playing.said(playing.LIMP) == "Settings.paper()"
    assert playing.said({**playing.FIRM, "mode": "torque"}) == "Settings.paper(1, mode='torque')"


def test_scenes():
    sofa, ball = "sinking-into-a-sofa", "flying-with-a-ball"
    values = played(scenes.SECTION, sofa, ball)
    content = check_content(scenes.SECTION, values)
    rows = {row.data: figures(row) for row in content.rows}
    assert set(rows) == {"sit_on_sofa", "fly_with_ball"}
    asked = rows["sit_on_sofa"]
    assert asked["deepest, asked for"].ours > 60.0
    assert asked["rate, asked for"].ours > 0.5
    for row in rows.values():
        assert all(f.reproduced is not False for f in row.values())
        assert row["deepest"].ours == row["rate"].ours == row["lost time"].ours == 0.0
    assert rows["fly_with_ball"]["the ball slips"].ours < scenes.SLIP
    assert len(content.pictures) == 2


def test_strips_are_pictures_for_a_phone():
    task = scenes.SECTION.tasks(Options(quick=True))[2]
    picture = run(task)[1]["strip"]
    assert len(picture) < LARGEST_PICTURE
    image = Image.open(io.BytesIO(picture))
    assert image.format == "PNG"
    assert 300 < image.width < 600
    assert len(image.getcolors(256)) > 30


def test_what_fails_is_said_to_fail():
    """A scene in which we penetrate, or turn what is free, is not reproduced."""
    sofa = "sinking-into-a-sofa"
    found = played(scenes.SECTION, sofa)[sofa]
    worse = {**found, "ours": {"rate": 0.001, "mean_mm": 0.01, "max_mm": 0.02}, "free_deg": 5.1}
    (row,) = scenes.content(Options(quick=True), {sofa: worse}).rows
    wrong = {f.name for f in row.figures if f.reproduced is False}
    assert wrong == {"rate", "deepest", "joints that are free"}


@pytest.fixture(scope="module")
def handled():
    keys = ("drop", "lift", "door", "kick", "monitor", "fast", "heavy", "stays", "slips")
    return played(objects.SECTION, *keys)


def test_objects(handled):
    content = check_content(objects.SECTION, handled)
    assert [row.name[7:9] for row in content.rows] == [f"5{letter}" for letter in "bcdefghij"]
    for row in content.rows:
        assert all(f.reproduced is not False for f in row.figures), row.name
        assert figures(row)["deepest"].ours == 0.0
    fall = figures(content.rows[0])["acceleration of the fall"]
    assert fall.ours == pytest.approx(9.81, abs=1e-6)  # nothing touches: to rounding
    assert handled["monitor"]["different"] == 0
    (speeds,) = content.plots
    assert max(speeds.series[1].y) == handled["fast"]["speed"]


def test_objects_that_behave_otherwise_are_not_reproduced(handled):
    """Mass and friction without a say: what is heavy flies, what is smooth is lifted."""
    swapped = {**handled, "heavy": handled["kick"], "stays": handled["lift"]}
    swapped["slips"], swapped["lift"] = handled["lift"], handled["slips"]
    swapped["monitor"] = {**handled["monitor"], "different": 1}
    swapped["drop"] = {**handled["drop"], "freed": None, "fall": None}
    rows = objects.content(Options(quick=True), swapped).rows
    wrong = {r.name[7:9] for r in rows if any(f.reproduced is False for f in r.figures)}
    assert wrong == {"5b", "5c", "5f", "5h", "5i", "5j"}

"""The paper's figures as evidence: their claims hold, and their results are rows."""

from __future__ import annotations

import functools
import io
import json
from dataclasses import asdict

import pytest
from PIL import Image

from evidence import model
from evidence.model import Options
from evidence.runner import function_of
from evidence.runs import choices
from evidence.sections import figure5, figure8, figures4and9, figures6and7
from evidence.verdicts import verdict

pytestmark = pytest.mark.slow

#: A picture of a strip [bytes].
LARGEST_PICTURE = 150_000


@functools.cache
def done(function, arguments):
    """The result of a task, its values as they come back from JSON."""
    outcome = function_of(model.Task(key="any", function=function))(**json.loads(arguments))
    return json.loads(json.dumps(model.plain(outcome.values, function))), outcome.pictures


def run(task):
    return done(task.function, json.dumps(dict(task.arguments), sort_keys=True))


def played(section, *keys, quick=True):
    """The values of these tasks of a section, by key."""
    tasks = {task.key: task for task in section.tasks(Options(quick=quick))}
    return {key: run(tasks[key])[0] for key in keys}


def figures(row):
    return {figure.name: figure for figure in row.figures}


def check_content(section, values, options=None):
    """The result of a section for these values; for no values it is empty."""
    options = options or Options(quick=True)
    empty = section.content(options, {})
    assert (empty.rows, empty.plots, empty.pictures) == ((), (), ())
    content = section.content(options, values)
    model.to_dict(content)  # all types of JSON
    tasks = {task.key for task in section.tasks(options)}
    assert {picture.task for picture in content.pictures} <= tasks & set(values)
    return content


SECTIONS = (figures4and9.SECTION, figure5.SECTION, figures6and7.SECTION, figure8.SECTION)


@pytest.mark.parametrize("section", SECTIONS, ids=lambda s: s.key)
def test_tasks(section):
    for quick, most in ((True, 16.0), (False, 200.0)):
        tasks = section.tasks(Options(quick=quick))
        assert len({task.key for task in tasks}) == len(tasks)
        assert sum(task.seconds for task in tasks) <= most
        for task in tasks:
            assert json.loads(json.dumps(task.arguments)) == dict(task.arguments)


def test_settings_are_said_as_one_writes_them():
    assert choices.said({}) == "Settings()"
    assert choices.said(choices.OURS) == "Settings(**AS_IT_IS)"
    assert choices.said({"mode": "positions"}) == "baselines.Positions()"
    assert choices.said(choices.LIMP) == "Settings.paper()"
    assert choices.said({**choices.FIRM, "mode": "torque"}) == "baselines.Torque.paper(1)"


def test_scenes():
    sofa, ball = "sinking-into-a-sofa", "flying-with-a-ball"
    values = played(figures4and9.SECTION, sofa, ball)
    content = check_content(figures4and9.SECTION, values)
    rows = {row.data: figures(row) for row in content.rows}
    assert set(rows) == {"sit_on_sofa", "fly_with_ball"}
    asked = rows["sit_on_sofa"]
    assert asked["deepest, reference"].ours > 60.0
    assert asked["penetration rate, reference"].ours > 0.5
    for row in rows.values():
        assert all(f.reproduced is not False for f in row.values())
        assert row["deepest"].ours == row["penetration rate"].ours == row["lost time"].ours == 0.0
    assert rows["fly_with_ball"]["the ball slips"].ours < figures4and9.SLIP
    assert [picture.task for picture in content.pictures] == [sofa]


def test_strips_are_pictures_for_a_phone():
    task = figures4and9.SECTION.tasks(Options(quick=True))[2]
    picture = run(task)[1]["strip"]
    assert len(picture) < LARGEST_PICTURE
    image = Image.open(io.BytesIO(picture))
    assert image.format == "PNG"
    assert 300 < image.width < 600
    assert len(image.getcolors(256)) > 30


def test_what_fails_is_said_to_fail():
    """A scene in which our bodies penetrate, or turn free objects, is not reproduced."""
    sofa = "sinking-into-a-sofa"
    found = played(figures4and9.SECTION, sofa)[sofa]
    worse = {**found, "ours": {"rate": 0.001, "mean_mm": 0.01, "max_mm": 0.02}, "free_deg": 5.1}
    (row,) = figures4and9.content(Options(quick=True), {sofa: worse}).rows
    wrong = {f.name for f in row.figures if f.reproduced is False}
    assert wrong == {"penetration rate", "deepest", "error of free joints"}
    blind = {**found, "asked": {"rate": 0.0, "mean_mm": 0.0, "max_mm": 0.0}}
    (row,) = figures4and9.content(Options(quick=True), {sofa: blind}).rows
    assert [f.name for f in row.figures if f.reproduced is False] == ["deepest, reference"]


@pytest.fixture(scope="module")
def handled():
    keys = ("drop", "lift", "door", "kick", "monitor", "fast", "heavy", "stays", "slips")
    return played(figure5.SECTION, *keys)


def test_objects(handled):
    content = check_content(figure5.SECTION, handled)
    assert [row.name[7:9] for row in content.rows] == [f"5{letter}" for letter in "bcdefghij"]
    for row in content.rows:
        assert all(f.reproduced is not False for f in row.figures), row.name
        assert figures(row)["deepest"].ours == 0.0
    fall = figures(content.rows[0])["acceleration of the fall"]
    assert fall.ours == pytest.approx(9.81, abs=1e-6)  # no contact: exact to rounding
    assert handled["monitor"]["different"] == 0
    (speeds,) = content.plots
    assert max(speeds.series[1].y) == handled["fast"]["speed"]


def test_objects_that_behave_otherwise_are_not_reproduced(handled):
    """Without the effect of mass and friction, heavy objects fly and smooth ones are lifted."""
    swapped = {**handled, "heavy": handled["kick"], "stays": handled["lift"]}
    swapped["slips"], swapped["lift"] = handled["lift"], handled["slips"]
    swapped["monitor"] = {**handled["monitor"], "different": 1}
    swapped["drop"] = {**handled["drop"], "freed": None, "fall": None}
    rows = figure5.content(Options(quick=True), swapped).rows
    wrong = {r.name[7:9] for r in rows if any(f.reproduced is False for f in r.figures)}
    assert wrong == {"5b", "5c", "5f", "5h", "5i", "5j"}


#: Ways to move a body whose figures must come out as in the paper, and the names to compare.
FORCED = {
    "positions": ("wall", "lift", "kick"),
    "interpolated-1000": ("wall", "kick"),
    "engine-kinematic": ("wall", "lift", "kick"),
}


@pytest.fixture(scope="module")
def forced():
    keys = [f"{what}/{key}" for key, whats in FORCED.items() for what in whats]
    keys += [f"{what}/half-physics" for what in ("wall", "lift", "kick")]
    keys += ["kick/engine-velocity", "wall/kinematic", "lift/kinematic", "ragdoll"]
    return played(figures6and7.SECTION, *keys)


def test_half_physics_is_stopped_holds_and_sees_mass(forced):
    content = check_content(figures6and7.SECTION, forced)
    for row in content.rows:
        if row.name.endswith(": half-physics"):
            assert all(f.reproduced is not False for f in row.figures), row.name
    assert forced["wall/half-physics"]["beyond"] < -0.1
    assert forced["wall/half-physics"]["deepest"] == 0.0
    assert forced["lift/half-physics"]["into_suitcase"] == 0.0
    light, heavy = forced["kick/half-physics"]["speeds"]
    assert light > 10.0 * heavy
    assert forced["kick/half-physics"]["depths"] == [0.0, 0.0]


@pytest.mark.parametrize("key", FORCED)
def test_forced_poses_penetrate_and_are_blind_to_mass(forced, key):
    found = {what: forced[f"{what}/{key}"] for what in FORCED[key]}
    values = {f"{what}/{key}": its for what, its in found.items()}
    rows = figures6and7.content(Options(quick=True), values).rows
    assert len(rows) == len(found)
    for row in rows:
        assert all(f.reproduced is not False for f in row.figures), row.name
    assert found["wall"]["beyond"] > 1.0
    assert found["wall"]["deepest"] > 45.0  # half of a wall 10 cm thick
    if "lift" in found:
        assert found["lift"]["into_suitcase"] > figures6and7.DEEP
        assert abs(found["lift"]["rise"]) < figures6and7.BARELY
        # Squeezed by kinematic bodies it is thrown about; pushed by set poses it hardly moves.
        assert (found["lift"]["fastest"] > 0.1) == (key == "engine-kinematic")
    light, heavy = found["kick"]["speeds"]
    assert light > 0.3  # it was kicked
    assert abs(light - heavy) < figures6and7.BLIND * light
    assert min(found["kick"]["depths"]) > 50.0  # [mm] of a ball of 11 cm radius


def test_poses_that_are_only_set_move_nothing(forced):
    assert forced["wall/kinematic"]["beyond"] > 1.0
    assert forced["lift/kinematic"]["into_suitcase"] > figures6and7.DEEP
    assert abs(forced["lift/kinematic"]["rise"]) < 1e-6
    found = {k: v for k, v in forced.items() if k.endswith("/kinematic")}
    for row in figures6and7.content(Options(quick=True), found).rows:
        assert all(f.reproduced is not False for f in row.figures), row.name


def test_a_ragdoll_falls_and_half_physics_does_not(forced):
    found = forced["ragdoll"]
    assert found["ragdoll"]["drop"] > figures6and7.FALLS
    assert found["ragdoll"]["mpjpe_g"] > 100.0 > 1.0 > found["ours"]["mpjpe_g"]
    ours, doll = figures6and7.content(Options(quick=True), {"ragdoll": found}).rows
    assert figures(ours)["pelvis lower than the reference"].reproduced
    assert figures(doll)["pelvis lower than the reference"].reproduced


def test_balls_that_stay_show_no_blindness(forced):
    """Without a moving ball, or penetrating skin, nothing is reproduced."""
    still = {**forced["kick/positions"], "speeds": [0.0, 0.0], "depths": [0.0, 0.0]}
    clear = {**forced["wall/positions"], "deepest": 0.0}
    values = {"kick/positions": still, "wall/positions": clear}
    wall, kick = map(figures, figures6and7.content(Options(quick=True), values).rows)
    assert verdict({"quoted": False}, asdict(kick["spread of the speeds"])) == "missing"
    assert kick["skin in the ball"].reproduced is False
    assert wall["deepest"].reproduced is False


def test_a_peer_that_sees_mass_is_not_said_to_be_blind(forced):
    light, heavy = forced["kick/engine-velocity"]["speeds"]
    assert light > 10.0 * heavy
    blind = {"kick/engine-kinematic": forced["kick/engine-velocity"]}
    (row,) = figures6and7.content(Options(quick=True), blind).rows
    assert figures(row)["spread of the speeds"].reproduced is False
    seeing = {"kick/half-physics": forced["kick/engine-kinematic"]}
    (row,) = figures6and7.content(Options(quick=True), seeing).rows
    assert [f.reproduced for f in row.figures[-2:]] == [False, False]


@pytest.fixture(scope="module")
def firm():
    return played(figure8.SECTION, "lambda-0", "lambda-1", "lambda-10")


def test_limp_legs_bend_and_firm_bodies_are_displaced(firm):
    content = check_content(figure8.SECTION, firm)
    for row in content.rows:
        assert all(f.reproduced is not False for f in row.figures), row.name
    limp, middle, rigid = (firm[f"lambda-{s}"] for s in (0, 1, 10))
    assert limp["more"] > middle["more"] + figure8.BENDS
    assert rigid["more"] < 1.0
    assert rigid["root"] > middle["root"] > figure8.TIMES * limp["root"]
    assert [picture.task for picture in content.pictures] == ["lambda-0", "lambda-1"]


def test_firmness_the_wrong_way_round_is_not_reproduced(firm):
    swapped = {"lambda-0": firm["lambda-1"], "lambda-1": firm["lambda-0"]}
    rows = figure8.content(Options(quick=True), swapped).rows
    assert all(any(f.reproduced is False for f in row.figures) for row in rows)

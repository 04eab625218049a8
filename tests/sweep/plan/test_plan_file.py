"""Mistakes in sweep files: each message gives the place."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from halfphysics.errors import FileError, InputError
from halfphysics.sweep import Plan
from halfphysics.sweep.plan.choices import SceneChoice
from halfphysics.sweep.plan.inputs import Inputs
from support.sweeps.plan_files import WHOLE, load


def test_a_scene_for_scenarios_is_refused() -> None:
    scenes = (SceneChoice(file="room.yaml"),)
    with pytest.raises(InputError, match=r"scenes: found room\.yaml with the scenario kick_ball"):
        Plan(inputs=Inputs(scenarios="kick_ball"), scenes=scenes)


FIRST = "inputs: {scenarios: kick_ball}\n"

MISTAKES = [
    # (text to replace in the file or "" to add a line, new text, place, message)
    ("version: 1", "version: 2", "line 1, version", "found version 2, expected 1"),
    ("seed: 7", "sed: 7", "line 19, sed", "unknown key 'sed'; did you mean seed"),
    ("seed: 7", "seed: -1", "line 19, seed", "found -1, expected a whole number of at least 0"),
    ("seed: 7", "seed: 1.5", "line 19, seed", "found 1.5, expected a whole number"),
    ("samples: 4", "samples: 0", "line 18, samples", "found 0, expected a whole number"),
    ("grounded: true", "grounded: 1", "line 12, grounded", "found 1, expected true or false"),
    ("fps: 30", "fsp: 30", "line 4, inputs[0].fsp", "for files; did you mean fps"),
    ("fps: 30", "fps: 0", "line 4, inputs[0].fps", "expected a positive number"),
    ("fps: 30", "up: w", "line 4, inputs[0].up", "found 'w', expected y or z or -y"),
    ("fps: 30", "floor: soles", "line 4, inputs[0].floor", "found 'soles', or lowest"),
    ("fps: 30", "adapt: maybe", "line 4, inputs[0].adapt", "expected true or false"),
    ("fps: 30", "objects: held", "line 4, inputs[0].objects", "expected free or replayed or none"),
    ("fps: 30", "clip: 3", "line 4, inputs[0].clip", "found 3, expected text"),
    ("fps: 30", "model: smplz", "line 4, inputs[0].model", "found 'smplz', expected one of smplx"),
    ("frames: 0:90", "frames: 0-90", "line 5, inputs[0].frames", "expected START:STOP"),
    ("assets: meshes", "assets: mesh", "line 6, inputs[0].assets", "there is no folder 'mesh'"),
    ("ground: true", "ground: 0", "line 7, inputs[0].ground", "expected true or false"),
    ("files: takes/*/", "file: x", "line 8, inputs[1].file", "did you mean files"),
    ("files: takes/*/", "files: []", "line 8, inputs[1]", "found neither"),
    ("files: takes/*/", "files: 3", "line 8, inputs[1].files", "expected text or a list of texts"),
    ("files: takes/*/", "files: [a, a]", "line 8, inputs[1].files", "found 'a' twice"),
    ("files: takes/*/", "scenarios: kick_bal", "line 8, inputs[1].scenarios", "found 'kick_bal'"),
    ("files: takes/*/", "scenarios: kick_ball", "line 9, inputs[1].objects", "for scenarios"),
    ("files: takes/*/", "scenarios: []", "line 8, inputs[1].scenarios", "expected the name"),
    ("{stature: 1.6}", "{height: 1.6}", "line 10, bodies[1].height", "unknown key 'height'"),
    ("{stature: 1.6}", "{stature: 16}", "line 10, bodies[1].stature", "at most 2.8"),
    ("{stature: 1.6}", "{model: x.npz}", "line 10, bodies[1].model", "there is no 'x.npz'"),
    ("{stature: 1.6}", "tall", "line 10, bodies[1]", "found 'tall'"),
    ("{stature: 1.6}", "own", "line 10, bodies", "found own twice"),
    (
        "{stature: 1.6}",
        "{stature: 1.6, model: room.yaml}",
        "line 10, bodies[1].stature",
        "or model",
    ),
    ("[own, room.yaml]", "[own, rom.yaml]", "line 11, scenes[1]", "there is no 'rom.yaml'"),
    ("[own, room.yaml]", "[]", "line 11, scenes", "found an empty list"),
    ("objects.mass:", "objects.mas:", "line 14, factors.objects.mas", "found 'mas'; did you mean"),
    ("objects.mass:", "object.mass:", "line 14, factors.object.mass", "objects.mass is of all"),
    ("[1, 2.5]", "[1, -2.5]", "line 14, factors.objects.mass", "found -2.5, expected a number"),
    ("[1, 2.5]", "[1, 1]", "line 14, factors.objects.mass", "found 1 twice"),
    ("to: 0.01", "to: 0.2", "line 15, factors.settings.clearance", "clearance is 0.2; expected"),
    ("count: 3", "count: 1", "line 15, factors.settings.clearance.count", "at least 2"),
    (
        "count: 3",
        "cuont: 3",
        "line 15, factors.settings.clearance",
        "cuont, scale; expected a value",
    ),
    ("[0.2, 1.2]", "[1.2, 0.2]", "line 16, factors.objects.friction.uniform", "smaller number"),
    ("[-2, 2]", "[8, 9]", "line 17, factors.body.betas.0.within", "of the distribution"),
    ("objects.mass < 2", "objects.mas < 2", "line 20, keep", "column 1: unknown name objects.mas;"),
    ("objects.mass < 2", "drops < 2", "line 20, keep", "column 1: unknown name drops"),
    ("drops == 0", "drop == 0", "line 21, keep_after[1]", "did you mean drops"),
    ("drops == 0", "drops = 0", "line 21, keep_after[1]", "column 7: cannot be read"),
    ("[success, drops == 0]", "3", "line 21, keep_after", "expected an expression or a list"),
    ("left_arm", "third_arm", "line 22, settings.stiffness", "there is no joint 'third_arm'"),
    ("{stiffness: {left_arm: 0.5}}", "{stifness: 1}", "line 22, settings.stifness", "did you mean"),
    ("{stiffness: {left_arm: 0.5}}", "{clearance: 0.01}", "line 15", "also in settings"),
    ("{stiffness: {left_arm: 0.5}}", "[1]", "line 22, settings", "found a list of 1"),
    ("threshold: 0.01", "threshold: -1", "line 23, labels.threshold", "a number above 0 [m]"),
    ("[behave]", "[behaved]", "line 23, labels.also", "found 'behaved', expected some of behave"),
    ("folder: out", "folder: 3", "line 24, outputs.folder", "expected the path of a folder"),
    ("[hdf5, webdataset]", "[tar]", "line 24, outputs.formats", "found 'tar'"),
    ("[hdf5, webdataset]", "[]", "line 24, outputs.formats", "found none, expected webdataset"),
    ("batch: 16", "batch: 0", "line 24, outputs.batch", "found 0, expected a whole number"),
    ("batch: 16", "bach: 16", "line 24, outputs.bach", "unknown key 'bach'; did you mean batch"),
    ("results: true", "results: 1", "line 25, outputs.results", "expected true or false"),
]


@pytest.mark.parametrize(("old", "new", "place", "message"), MISTAKES)
def test_every_mistake_has_its_place(
    folder: Path, old: str, new: str, place: str, message: str
) -> None:
    assert old in WHOLE
    with pytest.raises(FileError) as caught:
        load(folder, WHOLE.replace(old, new, 1))
    said = str(caught.value)
    assert said.startswith(f"{folder / 'plan.yaml'}, {place}")
    assert message in said.removeprefix(f"{folder / 'plan.yaml'}, {place}")


#: Texts that are, or look like, numbers, words or signs of YAML.
TEXTS = (
    "1e3", "-.5E-3", "+1.e2", "010", "08", "0o10", "0x1F", "0b11", "1_000", "1:30", "~", "null",
    "yes", "true", ".inf", "2001-01-01", "- a", "a: b", "#", " ", "\U0001f600", "\u3000",
)  # fmt: skip


def test_texts_survive_saving_whatever_they_look_like(folder: Path) -> None:
    plan = Plan(inputs=Inputs(files=TEXTS), base=folder)
    plan.save(folder / "saved.yaml")
    again = Plan.load(folder / "saved.yaml")
    assert again.inputs[0].files == TEXTS
    assert again.identity == plan.identity


@pytest.mark.parametrize("value", ["010", "-010", "00", "0b11", "1_000", "1:30"])
def test_numbers_of_old_yaml_are_refused(folder: Path, value: str) -> None:
    with pytest.raises(FileError, match=rf"line 2, seed: found '{value}', expected a whole number"):
        load(folder, f"{FIRST}seed: {value}\n")


def test_json_may_escape_every_character(folder: Path) -> None:
    names = ["\U0001f600", "a\\ud83d", "\\\U00010000\ufffd", "\u00e9/\u2028"]
    document = {"inputs": [{"files": names}], "outputs": {"folder": "\U0001f600\U0001f600"}}
    for ascii in (True, False):
        plan = load(folder, json.dumps(document, ensure_ascii=ascii), "plan.json")
        assert plan.inputs[0].files == tuple(names)
        assert plan.outputs.folder == "\U0001f600\U0001f600"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty, expected a mapping with inputs"),
        ("factors: {}", "found no inputs"),
        ("[1]", "expected a mapping with version"),
        (FIRST + "factors: {body.stature: [1.6]}\nbodies: {stature: 1.5}", "body stature=1.5"),
        (FIRST + "samples: 2", "samples: found 2 without a distribution|found 2 without"),
        ("inputs: {files: a*}\nfactors: {scenario.mass: [1]}", "inputs are all scenarios"),
        (FIRST + "factors: {scenario.weight: [1]}", "kick_ball has no option 'weight'"),
        (
            "inputs: {scenarios: kick_ball, mass: 2}\nfactors: {scenario.mass: [1]}",
            "line 2, factors.scenario.mass: mass is also said at the inputs",
        ),
        (FIRST + "factors: [1]", "factors: expected a mapping"),
        (
            "inputs: {scenarios: [kick_ball, crawl_under_table], mass: 2}",
            "unknown key 'mass' for scenarios",
        ),
        ("inputs: {scenarios: kick_ball, files: a}", "found both"),
        ("inputs: []", "found an empty list"),
        ("inputs: kick_ball", "expected a mapping .files or scenarios"),
    ],
)
def test_other_mistakes(folder: Path, text: str, message: str) -> None:
    with pytest.raises(FileError, match=message):
        load(folder, text)


#: Any value in a document.
ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.sampled_from([0, 1, -1, 2.5, 10**400, float("inf"), float("nan")]),
    st.sampled_from(["", "own", "x", "objects.mass < 1", "a" * 2000, "\0", "/", "**", "../.."]),
    st.sampled_from([[], [1], [[1]], [None], ["a", "a"], {}, {"a": 1}, {"uniform": [0, 1]}]),
    st.sampled_from([{"from": 0, "to": 1, "count": 3}, {"choice": [1], "weights": None}]),
)


def _places(node: object, path: tuple[object, ...] = ()) -> list[tuple[object, ...]]:
    """Paths of all values below a node of a document."""
    pairs = node.items() if isinstance(node, dict) else enumerate(node)
    inner = [((*path, key), child) for key, child in pairs]
    deeper = [_places(child, at) for at, child in inner if isinstance(child, dict | list)]
    return [at for at, _ in inner] + [at for places in deeper for at in places]


@settings(
    max_examples=150,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.data())
def test_any_document_is_a_plan_or_one_error(folder: Path, data: st.DataObject) -> None:
    document = load(folder, WHOLE).document()
    *path, last = data.draw(st.sampled_from(_places(document)))
    parent = document
    for key in path:
        parent = parent[key]
    parent[last] = data.draw(ANYTHING)
    try:
        plan = Plan.from_document(document, folder)
    except FileError:
        return
    plan.save(folder / "again.yaml")
    again = Plan.load(folder / "again.yaml")
    assert (again, again.identity) == (plan, plan.identity)


def test_files_that_are_no_plan(folder: Path) -> None:
    with pytest.raises(FileError, match="there is no such file, expected a sweep"):
        Plan.load(folder / "none.yaml")
    with pytest.raises(FileError, match=r"found suffix '.txt', expected a sweep file"):
        Plan.load(folder / "clips" / "notes.txt")

"""Sweep files: what they say, every mistake with its place, and the way back."""

from __future__ import annotations

import ast
import json
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from halfphysics.errors import FileError, InputError
from halfphysics.formats.loading import MotionOptions
from halfphysics.sweep import Plan, Variants
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from halfphysics.sweep.plan.inputs import Inputs, resolve
from halfphysics.sweep.plan.plan import OF_RESULT, OF_VARIANT, Labels, Outputs, resolve_inputs
from halfphysics.sweep.plan.plan_file import _BODY_KEYS, _KEYS, _LABEL_KEYS, _OUTPUT_KEYS
from halfphysics.sweep.plan.values import FORMS, Normal, Uniform
from support.paths import DOCS

DOCUMENT = DOCS / "sweeps.md"

WHOLE = """\
version: 1
inputs:
  - files: ["clips/**/*.npz"]
    fps: 30
    frames: 0:90
    assets: meshes
    ground: true
  - files: takes/*/
    objects: replayed
bodies: [own, {stature: 1.6}]
scenes: [own, room.yaml]
grounded: true
factors:
  objects.mass: [1, 2.5]
  settings.clearance: {from: 1e-3, to: 0.01, count: 3, scale: log}
  objects.friction: {uniform: [0.2, 1.2]}
  body.betas.0: {normal: [0, 1], within: [-2, 2]}
samples: 4
seed: 7
keep: objects.mass < 2 or scene == 'own'
keep_after: [success, drops == 0]
settings: {stiffness: {left_arm: 0.5}}
labels: {threshold: 0.01, also: [behave]}
outputs: {folder: out, formats: [hdf5, webdataset], variants_per_shard: 100, batch: 16,
  results: true}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with what the plan names."""
    for name in ("clips/b.npz", "clips/ä/a.npz", "clips/a.npz", "clips/notes.txt", "takes/1/x"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "takes" / "2").mkdir()
    (tmp_path / "meshes").mkdir()
    (tmp_path / "room.yaml").write_text("statics: {floor: {shape: plane}}\n")
    return tmp_path


def load(folder: Path, text: str, name: str = "plan.yaml") -> Plan:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return Plan.load(path)


def test_a_scene_for_scenarios_is_refused() -> None:
    scenes = (SceneChoice(file="room.yaml"),)
    with pytest.raises(InputError, match=r"scenes: found room\.yaml with the scenario kick_ball"):
        Plan(inputs=Inputs(scenarios="kick_ball"), scenes=scenes)


def test_a_whole_file(folder: Path) -> None:
    plan = load(folder, WHOLE)
    made = Plan(
        inputs=(
            Inputs(
                files=("clips/**/*.npz",),
                options={"fps": 30, "frames": "0:90", "assets": "meshes"},
                ground=True,
            ),
            Inputs(files="takes/*/", options={"objects": "replayed"}),
        ),
        bodies=(BodyChoice(), BodyChoice(stature=1.6)),
        scenes=(SceneChoice(), SceneChoice(file="room.yaml")),
        grounded=True,
        factors={
            "objects.mass": [1, 2.5],
            "settings.clearance": {"from": 0.001, "to": 0.01, "count": 3, "scale": "log"},
            "objects.friction": Uniform(low=0.2, high=1.2),
            "body.betas.0": Normal(mean=0, sd=1, within=(-2, 2)),
        },
        samples=4,
        seed=7,
        keep="objects.mass < 2 or scene == 'own'",
        keep_after=("success", "drops == 0"),
        settings={"stiffness": {"left_arm": 0.5}},
        labels=Labels(threshold=0.01, also=("behave",)),
        outputs=Outputs(
            folder="out",
            formats=("webdataset", "hdf5"),
            variants_per_shard=100,
            batch=16,
            results=True,
        ),
    )
    assert plan == made
    assert plan.identity == made.identity
    assert plan.folder == folder / "out"
    assert pickle.loads(pickle.dumps(plan)) == plan


def test_the_smallest_file(folder: Path) -> None:
    plan = load(folder, "inputs: {scenarios: kick_ball}\n")
    assert plan == Plan(inputs=(Inputs(scenarios=("kick_ball",)),))
    assert resolve_inputs(plan) == ["scenario\tkick_ball\t0"]
    variant = Variants(plan, resolve_inputs(plan))[0]
    assert (variant.input.kind, variant.input.name, variant.input.path) == (
        "scenario",
        "kick_ball",
        None,
    )
    assert (variant.body.name, variant.scene.name, variant.factors) == ("own", "own", {})


def test_inputs_are_files_in_order(folder: Path) -> None:
    plan = load(folder, WHOLE)
    assert resolve_inputs(plan) == [
        "file\tclips/a.npz\t0",
        "file\tclips/b.npz\t0",
        "file\tclips/ä/a.npz\t0",
        "file\ttakes/1\t1",
        "file\ttakes/2\t1",
    ]
    variants = Variants(plan, resolve_inputs(plan))
    first, last = variants[0].input, variants[-1].input
    assert first.path == folder / "clips" / "a.npz"
    assert first.ground
    assert first.motion_options == MotionOptions(fps=30, frames="0:90", assets=(folder / "meshes",))
    assert not last.ground
    assert last.motion_options == MotionOptions(objects="replayed")
    # Two patterns that meet the same file mean it once.
    twice = Inputs(files=("clips/*.npz", "clips/a*"))
    assert resolve([twice], folder, "out") == ["file\tclips/a.npz\t0", "file\tclips/b.npz\t0"]
    assert resolve([Inputs(files=str(folder / "clips" / "a.npz"))], Path("/"), "out") == [
        f"file\t{folder}/clips/a.npz\t0"
    ]
    # What a sweep has written is no input of it.
    assert resolve([Inputs(files="**/*.npz")], folder, "./clips/ä") == resolve([twice], folder, ".")
    with pytest.raises(FileError, match=r"inputs\[0\].files\[1\]: no file matches 'none\*'"):
        resolve([Inputs(files=("clips/*.npz", "none*"))], folder, "out")
    with pytest.raises(FileError, match="no folder matches"):
        resolve([Inputs(files=("clips/*.npz/",))], folder, "out")
    (folder / "clips" / "a\tb.npz").touch()
    with pytest.raises(FileError, match="rename it"):
        resolve_inputs(plan)


def test_scenarios_have_their_own_options(folder: Path) -> None:
    plan = load(
        folder,
        "inputs:\n  - {scenarios: [kick_ball, lift_suitcase], mass: 3, ground: true}\n"
        "factors: {scenario.fps: [30, 60]}\n",
    )
    variants = Variants(plan, resolve_inputs(plan))
    assert [(v.input.name, v.factors["scenario.fps"]) for v in variants] == [
        ("kick_ball", 30),
        ("kick_ball", 60),
        ("lift_suitcase", 30),
        ("lift_suitcase", 60),
    ]
    assert variants[0].input.options == {"mass": 3}
    assert variants[0].input.ground


def test_a_plan_survives_its_document_and_its_files(folder: Path) -> None:
    plan = load(folder, WHOLE)
    document = json.loads(json.dumps(plan.document()))
    again = Plan.from_document(document, folder)
    assert (again, again.identity, again.document()) == (plan, plan.identity, plan.document())
    away = folder / "out" / "deep"
    away.mkdir(parents=True)
    plan.save(away / "plan.yaml")
    there = Plan.load(away / "plan.yaml")
    assert (there, there.identity) == (plan, plan.identity)
    assert resolve_inputs(there) == resolve_inputs(plan)
    assert there.base.resolve() == folder.resolve()
    assert there.folder.resolve() == plan.folder.resolve()
    # JSON with the same keys.
    assert load(folder, json.dumps(document), "plan.json") == plan


def test_results_can_go_elsewhere(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = load(folder, WHOLE)
    moved = replace(plan, outputs=replace(plan.outputs, folder=str(folder / "clips" / "ä")))
    assert moved.folder == folder / "clips" / "ä"
    assert moved.identity == plan.identity
    assert "file\tclips/ä/a.npz\t0" in resolve_inputs(plan)
    assert "file\tclips/ä/a.npz\t0" not in resolve_inputs(moved)
    monkeypatch.chdir(folder)
    assert resolve_inputs(replace(moved, base=Path())) == resolve_inputs(moved)


def test_the_identity_is_of_what_is_made(folder: Path) -> None:
    plan = load(folder, WHOLE)
    elsewhere = load(folder, WHOLE.replace("folder: out", "folder: other"), "moved.yaml")
    assert elsewhere.identity == plan.identity
    assert re.fullmatch("[0-9a-f]{64}", plan.identity)
    ordered = WHOLE.replace("fps: 30\n    frames: 0:90", "frames: 0:90\n    fps: 30")
    assert load(folder, ordered).identity == plan.identity
    identities = {plan.identity}
    for old, new in CHANGES:
        assert old in WHOLE
        identities.add(load(folder, WHOLE.replace(old, new)).identity)
    assert len(identities) == len(CHANGES) + 1


CHANGES = [
    ("fps: 30", "fps: 60"),
    ("ground: true", "ground: false"),
    ("1.6", "1.7"),
    ("scenes: [own, room.yaml]", "scenes: room.yaml"),
    ("grounded: true", "grounded: false"),
    ("[1, 2.5]", "[1, 2]"),
    ("uniform", "log_uniform"),
    ("samples: 4", "samples: 3"),
    ("seed: 7", "seed: 8"),
    ("mass < 2", "mass < 3"),
    ("drops == 0", "drops == 1"),
    ("left_arm: 0.5", "left_arm: 0.6"),
    ("threshold: 0.01", "threshold: 0.02"),
    ("[behave]", "[arctic]"),
    ("[hdf5, webdataset]", "hdf5"),
    ("batch: 16", "batch: 4"),
    ("results: true", "results: false"),
]

FIRST = "inputs: {scenarios: kick_ball}\n"

MISTAKES = [
    # (what is replaced in the file or "" to add a line, what stands there, place, message)
    ("version: 1", "version: 2", "line 1, version", "found version 2, expected 1"),
    ("seed: 7", "sed: 7", "line 19, sed", "unknown key 'sed'; did you mean seed"),
    ("seed: 7", "seed: -1", "line 19, seed", "found -1, expected a whole number of at least 0"),
    ("seed: 7", "seed: 1.5", "line 19, seed", "found 1.5, expected a whole number"),
    ("samples: 4", "samples: 0", "line 18, samples", "found 0, expected a whole number"),
    ("grounded: true", "grounded: 1", "line 12, grounded", "found 1, expected true or false"),
    ("fps: 30", "fsp: 30", "line 4, inputs[0].fsp", "for files; did you mean fps"),
    ("fps: 30", "fps: 0", "line 4, inputs[0].fps", "expected a positive number"),
    ("fps: 30", "up: x", "line 4, inputs[0].up", "found 'x', expected y or z"),
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


#: What may stand anywhere in a document.
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


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"inputs": ()}, "inputs: found .*, expected one Inputs or more"),
        ({"inputs": "clips/*.npz"}, "expected one Inputs"),
        ({"bodies": [1.6]}, "bodies: found 1.6, expected BodyChoice"),
        ({"labels": {}}, "labels: found {}"),
        ({"factors": [1]}, "factors: found"),
        ({"factors": {"objects.mass": {"unifrom": [0, 1]}}}, "objects.mass: found a mapping"),
        ({"keep": [3]}, "keep: found"),
        ({"seed": True}, "seed: found True"),
    ],
)
def test_mistakes_in_python(changes: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Plan(**{"inputs": Inputs(scenarios="kick_ball"), **changes})


def test_expressions_know_factors_and_results(folder: Path) -> None:
    plan = load(folder, WHOLE)
    (keep,) = plan.expressions("keep")
    assert keep.names == ("objects.mass", "scene")
    assert [e.names for e in plan.expressions("keep_after")] == [("success",), ("drops",)]
    assert not set(OF_VARIANT) & set(OF_RESULT)


def test_the_explained_lines_of_python_run(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    load(folder, WHOLE)
    monkeypatch.chdir(folder)
    lines = DOCUMENT.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    names: dict[str, Any] = {}
    exec(lines, names)
    said = lines.rsplit("# ", 1)[1].replace("...", "").strip()
    expected = ast.literal_eval(said)
    factors = names["variants"][17].factors
    assert factors == pytest.approx(expected, abs=0.01)
    assert "variants  60" in capsys.readouterr().out


#: The mistakes whose messages the document shows.
DOCUMENTED = [("to: 0.004", "to: 0.2"), ("objects.mass_factor < 2", "objects.mas < 2")]


def test_the_explained_example_is_a_plan(tmp_path: Path) -> None:
    """docs/sweeps.md explains a whole file, and every key, in words that are still true."""
    text = DOCUMENT.read_text(encoding="utf-8")
    example = text.split("```yaml\n")[1].split("```")[0]
    (tmp_path / "clips").mkdir()
    (tmp_path / "clips" / "a.npz").touch()
    (tmp_path / "rooms").mkdir()
    for room in ("kitchen", "office"):
        (tmp_path / "rooms" / f"{room}.yaml").write_text("statics: {floor: {shape: plane}}\n")
    plan = load(tmp_path, example)
    variants = Variants(plan, resolve_inputs(plan))
    assert f"{len(variants):,} variants" in text
    messages = text.split("```\n")[2].splitlines()
    for (old, new), message in zip(DOCUMENTED, messages, strict=True):
        with pytest.raises(FileError) as caught:
            load(tmp_path, example.replace(old, new))
        said = message.removesuffix("...").rstrip()
        assert str(caught.value).startswith(f"{tmp_path}/{said}")
    given = yaml.safe_load(example)
    assert set(given) == set(_KEYS) - {"base"}
    assert set(given["labels"]) == set(_LABEL_KEYS)
    assert set(given["outputs"]) == set(_OUTPUT_KEYS)
    forms = {key for value in given["factors"].values() if isinstance(value, dict) for key in value}
    assert forms == {key for keys in FORMS.values() for key in keys}
    for word in (*_KEYS, *_BODY_KEYS, *OF_VARIANT, *OF_RESULT):
        assert f"`{word}`" in text
    for option in ("fps", "up", "hands", "model", "gender", "frames", "clip", "assets", "objects"):
        assert f"`{option}`" in text

"""Sweep files: their meaning, and the way back."""

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

from halfphysics.errors import FileError, InputError
from halfphysics.sweep import Plan, Variants
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from halfphysics.sweep.plan.inputs import Inputs, file_options
from halfphysics.sweep.plan.plan import OF_RESULT, OF_VARIANT, Labels, Outputs, resolve_inputs
from halfphysics.sweep.plan.plan_file import _BODY_KEYS, _KEYS, _LABEL_KEYS, _OUTPUT_KEYS
from halfphysics.sweep.plan.values import FORMS, Normal, Uniform
from support.paths import DOCS
from support.sweeps.plan_files import WHOLE, load

DOCUMENT = DOCS / "sweeps.md"


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


def test_expressions_know_support_where_it_is_an_output() -> None:
    inputs = Inputs(scenarios="kick_ball")
    keep_after = ("unsupported_percent < 5",)
    plan = Plan(inputs=inputs, keep_after=keep_after, outputs=Outputs(support=True))
    assert plan.expressions("keep_after")[0].names == ("unsupported_percent",)
    with pytest.raises(InputError, match=r"unsupported_percent needs outputs: \{support: true\}"):
        Plan(inputs=inputs, keep_after=keep_after)


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
    messages = text.split("```text\n")[1].split("```")[0].splitlines()
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
    for option in file_options():
        assert f"`{option}`" in text

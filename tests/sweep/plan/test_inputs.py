"""Inputs of a sweep: files in order, scenarios with options of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from halfphysics.errors import FileError
from halfphysics.formats.loading import MotionOptions
from halfphysics.sweep import Plan, Variants
from halfphysics.sweep.plan.inputs import Inputs, resolve
from halfphysics.sweep.plan.plan import resolve_inputs

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
    """A folder with the files of the plan."""
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
    # Two patterns that match the same file select it once.
    twice = Inputs(files=("clips/*.npz", "clips/a*"))
    assert resolve([twice], folder, "out") == ["file\tclips/a.npz\t0", "file\tclips/b.npz\t0"]
    assert resolve([Inputs(files=str(folder / "clips" / "a.npz"))], Path("/"), "out") == [
        f"file\t{folder}/clips/a.npz\t0"
    ]
    # Output of a sweep is not an input of it.
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

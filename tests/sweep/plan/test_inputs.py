"""Inputs of a sweep: files in order, scenarios with options of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from halfphysics.errors import FileError
from halfphysics.formats.loading import MotionOptions
from halfphysics.sweep import Variants
from halfphysics.sweep.plan.inputs import Inputs, resolve
from halfphysics.sweep.plan.plan import resolve_inputs
from support.sweeps.plan_files import WHOLE, load


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

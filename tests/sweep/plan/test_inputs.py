"""Inputs of a sweep: files in order, scenarios with options of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from halfphysics.errors import FileError, InputError
from halfphysics.formats.loading import MotionOptions
from halfphysics.sweep import Variants
from halfphysics.sweep.plan.inputs import InputList, Inputs, resolve
from halfphysics.sweep.plan.plan import resolve_inputs
from halfphysics.sweep.store.fixed_inputs import check_inputs
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
    assert resolve([Inputs(files="**/*.npz")], folder, "out", folder / "clips/ä") == resolve(
        [twice], folder, "."
    )
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


def test_the_folder_of_results_is_no_input(folder: Path) -> None:
    every = [Inputs(files="**/")]
    lines = [f"file\t{name}\t0" for name in ("clips", "clips/ä", "meshes", "takes", "takes/1")]
    assert resolve(every, folder, "takes/2") == lines
    assert resolve(every, folder, "./takes/../takes/2/", "clips/none") == lines
    (folder / "link").symlink_to(folder / "takes")
    (folder.parent / "base").symlink_to(folder)
    few = [Inputs(files=("clips/", "takes/*/"))]
    lines = ["file\tclips\t0", "file\ttakes/1\t0"]
    for base in (folder, folder.parent / "base"):
        for out in ("takes/2", "link/2", folder / "takes/2", folder.parent / "base/takes/2"):
            assert resolve(few, base, out) == lines


def test_a_name_is_refused_only_for_what_a_line_cannot_hold(folder: Path) -> None:
    ideographic, narrow, joined = "\u3000", "\u202f", "\U0001f469\u200d\U0001f680"
    names = sorted(f"takes/a{s}b.npz" for s in (" ", "\u00a0", ideographic, narrow, joined))
    for name in names:
        (folder / name).touch()
    entries = [Inputs(files="takes/*.npz")]
    lines = resolve(entries, folder, "out")
    assert lines == [f"file\t{name}\t0" for name in names]
    check_inputs(folder / "inputs.txt", lines)
    check_inputs(folder / "inputs.txt", lines)
    assert list(InputList(folder / "inputs.txt")) == lines
    with pytest.raises(InputError, match=r": 1 gone \(file takes/a b\.npz 0\)\."):
        check_inputs(folder / "inputs.txt", lines[1:])
    for sign in ("\n", "\r", "\x0b", "\x1c", "\x7f", "\x85", "\u2028", "\u2029", "\udcff"):
        path = folder / f"takes/a{sign}b.npz"
        path.touch()
        with pytest.raises(FileError, match="rename it"):
            resolve(entries, folder, "out")
        path.unlink()

"""Counts of instructions: what is run under valgrind, and what is read from it."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from halfphysics.bench import instructions
from halfphysics.bench.clips import body
from halfphysics.bench.free import core_loop
from halfphysics.bench.record import Options
from halfphysics.cli import main
from halfphysics.errors import HalfPhysicsError
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator

#: Instructions of a start, and of a pass, that the program in valgrind's place says it counted.
START, PASS = 10_000_000, 3_000_000


@pytest.fixture
def valgrind(tmp_path, monkeypatch):
    """A program in valgrind's place: it runs what it is given and counts by the passes."""
    program = tmp_path / "valgrind"
    program.write_text(
        f"#!{sys.executable}\n"
        "import subprocess, sys\n"
        "command = sys.argv[1:]\n"
        "while command[0].startswith('--'): command.pop(0)\n"
        "done = subprocess.run(command)\n"
        f"count = {START} + {PASS} * int(command[-2])\n"
        "print(f'==1== I   refs:      {count:,}', file=sys.stderr)\n"
        "sys.exit(done.returncode)\n"
    )
    program.chmod(0o755)
    monkeypatch.setattr(instructions.shutil, "which", lambda name: str(program))
    return str(program)


def test_a_pass_is_what_two_passes_have_more_than_one(valgrind):
    (record,) = instructions.instructions(Options(quick=True))
    contact = record.checks["substeps with contact"][0]
    # In 30 frames of 8 substeps the wall is met in frame 15, and who is met by it is thrown off.
    assert 15 < contact <= 29 * 8
    assert record.ours == pytest.approx((1e-6 * PASS / contact,))
    assert record.unit == "M instructions"


def test_a_count_that_is_not_there_is_an_error(tmp_path):
    broken = tmp_path / "valgrind"
    broken.write_text("#!/bin/sh\necho killed >&2\nexit 1\n")
    broken.chmod(0o755)
    with pytest.raises(HalfPhysicsError, match="killed"):
        instructions.counted(str(broken), "wall", 1.0, 1, quick=True)


def test_without_valgrind_the_case_is_left_out(monkeypatch, capsys):
    monkeypatch.setattr(instructions.shutil, "which", lambda name: None)
    assert main(["bench", "--case", "instructions"]) == 0
    assert "left out: valgrind is not installed" in capsys.readouterr().out


def test_every_setting_has_a_clip():
    for clip, _ in instructions.SETTINGS.values():
        assert len(instructions.played(clip, quick=True).motion) == 30


def test_the_clip_is_played_at_its_stiffness():
    """A core that is reset keeps its firmness: the loop has to set it."""
    play = instructions.played("wall", quick=True)
    for stiffness in (0.0, 1.0):
        settings = Settings(stiffness=stiffness)
        simulator = Simulator(play.scene, body=body(), settings=settings, fps=play.motion.fps)
        core_loop(simulator, play.motion)
        joints = np.asarray(simulator.world.stepper.stiffness())[1:]  # the root has none
        assert np.all(joints == stiffness)

"""The end of the kick by examples/c/walk.c, and by `Simulator`."""

from __future__ import annotations

import runpy
import shutil
import subprocess
import sys

import numpy as np
import pytest

import halfphysics as hp
from support import c_library
from support.paths import ROOT

EXAMPLE = ROOT / "examples" / "c" / "walk.c"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")


def compiler():
    found = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    return found or pytest.skip("no C compiler")


def numbers(line):
    return np.array(
        [float.fromhex(word) for word in line.split() if word.startswith(("0x", "-0x"))]
    )


def python_end(frames):
    """Pose and ball after so many frames of the kick, played again and again, by `Simulator`."""
    sequence = hp.scenarios.load("kick_ball")
    motion = sequence.motion
    sim = hp.Simulator(sequence.scene, settings=sequence.settings, fps=motion.fps)
    sim.reset(motion[0])
    for i in range(1, frames + 1):
        frame = sim.step(motion[i % len(motion)])
    pose = np.concatenate([frame.pose.translation, frame.pose.rotations.ravel()])
    return pose, frame.objects["ball"][0]


def c_end(tmp_path, monkeypatch, frames):
    """The same by examples/c/walk.c."""
    build = c_library.folder()
    program, world, poses = (tmp_path / name for name in ("walk", "kick.hpw", "kick.poses"))
    link = (f"-L{build}", "-lhalfphysics", f"-Wl,-rpath,{build}")
    command = [compiler(), *STRICT, f"-I{c_library.HEADER.parent}", EXAMPLE, *link, "-o", program]
    subprocess.run(command, check=True)
    monkeypatch.setattr(sys, "argv", ["write_world.py", str(world), str(poses)])
    runpy.run_path(str(EXAMPLE.with_name("write_world.py")), run_name="__main__")
    command = [program, world, poses, str(frames)]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    *_, pose, ball = output.splitlines()
    return numbers(pose), numbers(ball)

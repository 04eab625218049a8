"""The core for browsers, run by node, beside the native one."""

from __future__ import annotations

import json
import shutil
import subprocess
import time

import numpy as np
import pytest

import halfphysics as hp
from support.c_library import CWorld
from support.paths import ROOT, TESTS

CORE = ROOT / "src" / "halfphysics" / "assets" / "core"


def by_wasm(tmp_path, name, part):
    """Frames of a scenario by node and natively: bodies (T, n, 7) each, and what node said."""
    node = shutil.which("node") or pytest.skip("no node")
    sequence = hp.scenarios.load(name)
    motion = sequence.motion[part]
    sim = hp.Simulator(sequence.scene, settings=sequence.settings, fps=motion.fps)
    sim.reset(motion[0])
    world, poses, out = (tmp_path / end for end in ("world.hpw", "poses", "bodies"))
    sim.save_world(world)
    rows = np.column_stack([motion.translation, motion.rotations.reshape(len(motion), -1)])
    poses.write_bytes(np.append(motion.fps, rows).tobytes())
    command = [node, TESTS / "tools" / "core_frames.mjs", CORE, world, poses, out]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    native = CWorld(world.read_bytes())
    native.reset(motion[0])
    expected, begin = [], time.process_time()
    for i in range(1, len(motion)):
        native.step(motion[i], dt=1 / motion.fps)
        expected.append(native.bodies())
    seconds = time.process_time() - begin
    found = np.frombuffer(out.read_bytes()).reshape(len(motion) - 1, -1, 7)
    return found, np.array(expected), json.loads(said) | {"native": (len(motion) - 1) / seconds}

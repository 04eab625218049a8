"""The core for browsers: of the sources that are here, small, with the bits of the native one."""

from __future__ import annotations

import gzip
import re
import subprocess
import sys

import numpy as np
import pytest

import halfphysics as hp
from support.c_library import functions
from support.paths import ROOT
from support.wasm_core import CORE, by_wasm

WASM = CORE / "halfphysics.wasm"


def sources(option):
    command = [sys.executable, ROOT / "tools" / "wasm_sources.py", option]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_it_is_made_of_the_sources_that_are_here():
    assert sources("--hash") == WASM.with_suffix(".wasm.sources").read_text(encoding="utf-8"), (
        "src/native has changed since halfphysics.wasm was built: run tools/build_wasm.sh (needs "
        "em++: apt install emscripten) and commit src/halfphysics/assets/core"
    )


def test_all_sources_are_listed():
    listed = sources("--list").split()
    assert "src/native/capi/library.cpp" in listed
    assert "src/native/stepping/baselines/prescribed_poses.cpp" in listed
    assert not [path for path in listed if "bindings" in path]


def test_it_is_small():
    assert len(gzip.compress(WASM.read_bytes(), 9)) < 1_000_000


def test_the_class_calls_functions_that_are_there():
    script = (CORE / "halfphysics.js").read_text(encoding="utf-8")
    called = set(re.findall(r"\bhp_\w+", script)) - {"hp_status", "hp_contact"}
    assert called <= set(functions())
    assert set(functions()) - called == {"hp_find", "hp_world_open"}


def test_its_types_have_what_the_class_has():
    script = (CORE / "halfphysics.js").read_text(encoding="utf-8")
    types = (CORE / "halfphysics.d.ts").read_text(encoding="utf-8")
    methods = set(re.findall(r"^  (?:static async )?([a-z]\w*)\(", script, re.MULTILINE))
    assert methods - {"constructor"} == set(
        re.findall(r"^  (?:static )?([a-z]\w*)\(", types, re.MULTILINE)
    ) - {"constructor"}


@pytest.mark.parametrize(
    ("name", "part"), [("kick_ball", slice(70, 130)), ("lift_suitcase", slice(50, 80))]
)
def test_its_bits_are_those_of_the_native_core(tmp_path, name, part):
    found, expected, said = by_wasm(tmp_path, name, part)
    assert np.array_equal(found, expected)
    assert said["again"]  # from a saved state
    assert said["contacts"] > 0
    assert said["version"] == hp.__version__
    assert said["jointNames"] == list(hp.JOINT_NAMES)
    assert said["names"][-1] == "person"
    assert said["kinds"][-1] == "person"
    assert len(said["bodyNames"]) == found.shape[1]
    statuses = [mistake.split()[0] for mistake in said["mistakes"]]
    assert statuses == ["2", "3", "1", "1"]

"""The core built for AVX2, for SSE2 and for plain loops, beside this checkout's Python files.

How wide the vectors are is chosen when the core is compiled (HALFPHYSICS_VECTORS in
CMakeLists.txt), so there is a build for each; AVX2 is what every build takes where the processor has
it. A processor without AVX2 runs SSE2 in both.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

MODES = ("avx2", "sse2", "plain")
ROOT = Path(__file__).resolve().parents[2]


def run_in_modes(options: argparse.Namespace) -> int:
    """Do what the command line says with each build; the highest exit code."""
    modes = MODES if options.vector == "all" else (options.vector,)
    command = [sys.executable, sys.argv[0], options.what, str(options.file)]
    command += ["--jobs", str(options.jobs), *(["--quick"] if options.quick else [])]
    for pattern in options.only:
        command += ["--only", pattern]
    codes = {}
    for mode in modes:
        path = build(mode, options.jobs)
        print(f"\n== {mode} ==", flush=True)
        codes[mode] = subprocess.call(command, env={**os.environ, "PYTHONPATH": str(path)})
    print("\n" + ", ".join(f"{mode}: {'differs' if c else 'equal'}" for mode, c in codes.items()))
    return max(codes.values())


def build(mode: str, jobs: int) -> Path:
    """Build the core for a mode; the folder to import `halfphysics` from.

    Raises:
        subprocess.CalledProcessError: cmake failed; what it said is on stderr.
    """
    folder = ROOT / "build" / f"vector-{mode}"
    site = folder / "site"
    configure = ["cmake", "-S", str(ROOT), "-B", str(folder), f"-DHALFPHYSICS_VECTORS={mode}"]
    steps = (
        [*configure, f"-DPython_EXECUTABLE={sys.executable}"],
        ["cmake", "--build", str(folder), "-j", str(jobs)],
        ["cmake", "--install", str(folder), "--prefix", str(site)],
    )
    shutil.rmtree(site, ignore_errors=True)
    for step in steps:
        subprocess.run(step, check=True, stdout=subprocess.DEVNULL)
    unwanted = shutil.ignore_patterns("*.so", "*.pyd", "__pycache__")
    shutil.copytree(
        ROOT / "src/halfphysics", site / "halfphysics", ignore=unwanted, dirs_exist_ok=True
    )
    return site

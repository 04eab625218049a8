"""Compile the native core for the systems that wheels are made for, from any one of them.

    pip install ziglang cmake ninja
    python tools/cross_compile.py                        # all targets; says which compile
    python tools/cross_compile.py windows-x86_64 --run wine      # and run its native tests
    python tools/cross_compile.py linux-aarch64 --run qemu-aarch64

ziglang is a clang with the C libraries of all of these systems. What is compiled is what CMakeLists.txt
names without Python: the libraries and the native tests (tests/native), which `--run` has ctest
start through an emulator. Builds stay in build/cross/TARGET. The Windows target is that of mingw:
what only Microsoft's compiler refuses is not found here.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Target:
    """A system as zig and as CMake name it."""

    triple: str
    system: str
    processor: str


#: glibc 2.17 is that of manylinux2014, older than of any wheel we make.
TARGETS = {
    "linux-x86_64": Target("x86_64-linux-gnu.2.17", "Linux", "x86_64"),
    "linux-aarch64": Target("aarch64-linux-gnu.2.17", "Linux", "aarch64"),
    "macos-x86_64": Target("x86_64-macos", "Darwin", "x86_64"),
    "macos-arm64": Target("aarch64-macos", "Darwin", "arm64"),
    "windows-x86_64": Target("x86_64-windows-gnu", "Windows", "AMD64"),
}


def main() -> int:
    """Compile for each target that is asked for; 1 if one fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--run", metavar="PROGRAM", help="emulator that the native tests run in")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="compilers at a time")
    options = parser.parse_args()
    unknown = sorted(set(options.targets) - set(TARGETS))
    if unknown:
        parser.error(f"unknown target {unknown[0]}. Expected one of {', '.join(TARGETS)}")
    if options.run and len(options.targets) != 1:
        parser.error("--run takes one TARGET, the one that PROGRAM emulates")
    failed = [
        name for name in options.targets or TARGETS if not build(name, options.run, options.jobs)
    ]
    print(f"cross_compile: {', '.join(failed) + ' failed' if failed else 'all compiled'}")
    return 1 if failed else 0


def build(name: str, emulator: str | None, jobs: int) -> bool:
    """Configure and build one target, and run its native tests; whether all went well."""
    folder = ROOT / "build" / "cross" / name
    folder.mkdir(parents=True, exist_ok=True)
    configure = ["cmake", "-G", "Ninja", "-S", str(ROOT), "-B", str(folder)]
    configure += [f"-D{key}={value}" for key, value in settings(TARGETS[name], folder).items()]
    if emulator:
        configure.append(f"-DCMAKE_CROSSCOMPILING_EMULATOR={emulator}")
    # -k 0: all that does not compile is told at once.
    steps = [configure, ["cmake", "--build", str(folder), "-j", str(jobs), "--", "-k", "0"]]
    if emulator:
        steps.append(["ctest", "--test-dir", str(folder), "--output-on-failure"])
    for step in steps:
        print(f"cross_compile: {name}: {' '.join(step[:2])}", flush=True)
        if subprocess.run(step, check=False).returncode:
            return False
    return True


def settings(target: Target, folder: Path) -> dict[str, str]:
    """What CMake has to know of a target."""
    return {
        "CMAKE_SYSTEM_NAME": target.system,
        "CMAKE_SYSTEM_PROCESSOR": target.processor,
        "CMAKE_CXX_COMPILER": program(folder, "c++", f"c++ -target {target.triple}"),
        "CMAKE_AR": program(folder, "ar", "ar"),
        "CMAKE_RANLIB": program(folder, "ranlib", "ranlib"),
        "CMAKE_RC_COMPILER": program(folder, "rc", "rc"),
        "HALFPHYSICS_PYTHON": "OFF",
        "HALFPHYSICS_BUILD_TESTS": "ON",
    }


def program(folder: Path, name: str, arguments: str) -> str:
    """A script that calls one of zig's tools: CMake wants a path without arguments."""
    windows = os.name == "nt"
    path = folder / (f"zig-{name}.cmd" if windows else f"zig-{name}")
    call = f'"{sys.executable}" -m ziglang {arguments}'
    path.write_text(f"@{call} %*\n" if windows else f'#!/bin/sh\nexec {call} "$@"\n', "utf-8")
    path.chmod(0o755)
    return path.as_posix()


if __name__ == "__main__":
    sys.exit(main())

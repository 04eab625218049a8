"""tools/cross_compile.py: one target for each wheel of the release."""

from __future__ import annotations

import importlib.util
import subprocess
import sys

import pytest

from support.paths import ROOT

TOOL = ROOT / "tools" / "cross_compile.py"


@pytest.fixture(scope="module")
def tool():
    spec = importlib.util.spec_from_file_location("cross_compile", TOOL)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def test_each_wheel_of_the_release_has_a_target(tool):
    """The runners of the release, as GitHub names them, are of the systems compiled for here."""
    text = (ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    runners = {
        "ubuntu-24.04,": "linux-x86_64",
        "ubuntu-24.04-arm,": "linux-aarch64",
        "macos-15-intel,": "macos-x86_64",
        "macos-15,": "macos-arm64",
        "windows-2025,": "windows-x86_64",
    }
    built = text[text.index("  wheels:") : text.index("  sdist:")]
    named = {target for runner, target in runners.items() if runner in built}
    assert named == set(tool.TARGETS)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["solaris"], "unknown target solaris. Expected one of linux-x86_64, "),
        (["--run", "wine"], "--run takes one TARGET"),
    ],
)
def test_what_cannot_be_compiled_is_told_first(arguments, said):
    done = subprocess.run(
        [sys.executable, TOOL, *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert said in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script")
def test_arguments_reach_the_compiler(tool, tmp_path, monkeypatch):
    """The script passes what CMake gives it, spaces included, behind the target."""
    monkeypatch.setattr(tool.sys, "executable", "/bin/echo")
    path = tool.settings(tool.TARGETS["windows-x86_64"], tmp_path)["CMAKE_CXX_COMPILER"]
    said = subprocess.run([path, "-c", "a b.cpp"], capture_output=True, text=True, check=True)
    assert said.stdout == "-m ziglang c++ -target x86_64-windows-gnu -c a b.cpp\n"

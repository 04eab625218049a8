"""Standard output without a reader or without room, as a shell gives it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="pipes and devices of POSIX")

PROGRAM = f"{sys.executable} -m halfphysics"


def shell(line):
    return subprocess.run(
        ["bash", "-c", line], capture_output=True, text=True, timeout=60, check=False
    )


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_no_room():
    done = shell(f"{PROGRAM} formats > /dev/full")
    assert done.returncode == 2
    assert done.stderr == (
        "halfphysics: error: standard output: cannot write: No space left on device\n"
    )


def test_the_reader_has_gone():
    """As of a program that SIGPIPE ends. The reader ends before the first byte."""
    done = shell(f"{PROGRAM} formats | true; exit ${{PIPESTATUS[0]}}")
    assert (done.returncode, done.stderr) == (141, "")


def test_closed_streams():
    done = shell(f"{PROGRAM} formats >&-")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    done = shell(f"{PROGRAM} simulate no.npz 2>&-")
    assert (done.returncode, done.stdout) == (2, "")


def test_a_message_that_cannot_be_written_changes_no_exit_code():
    assert shell(f"{PROGRAM} simulate no.npz 2>/dev/full").returncode == 2

"""Standard output without a reader or without room, as a shell gives it."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from halfphysics.cli.streams import streams_that_take_any_text
from support.people import along_x

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


@pytest.mark.parametrize("encoding", ["cp1252", "ascii", "ascii:surrogateescape", "utf-8"])
def test_what_an_encoding_does_not_have_is_escaped(encoding, tmp_path):
    clip = tmp_path / "\u28ff\u0411.npz"
    along_x(0.3, 6, 0.0, z=1.2).save(clip)
    done = subprocess.run(
        [sys.executable, "-m", "halfphysics", "inspect", str(clip)],
        env={**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"},
        capture_output=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    name = str(clip) if encoding == "utf-8" else f"{tmp_path}/\\u28ff\\u0411.npz"
    assert name.encode() in done.stdout


def test_streams_are_left_as_they_were(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii", errors="strict")
    monkeypatch.setattr(sys, "stdout", stream)
    with streams_that_take_any_text():
        print("\u0411", file=stream, flush=True)
        assert stream.errors == "backslashreplace"
    assert stream.errors == "strict"
    assert stream.buffer.getvalue() == b"\\u0411\n"

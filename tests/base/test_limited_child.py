"""A script in a process of its own: its answer, or why there is none."""

from __future__ import annotations

import os

import pytest

from halfphysics.base.limited_child import can_start, run

ECHO = "import os, sys; sys.stdout.write(sys.stdin.read() + ' '.join(sys.argv[1:]))"
#: As a child limits itself, then works for ever.
BUSY = """
import resource, sys
resource.setrlimit(resource.RLIMIT_CPU, (int(sys.argv[2]), int(sys.argv[2]) + 2))
while True: pass
"""


@pytest.fixture
def script(tmp_path):
    def written(text):
        path = tmp_path / "child.py"
        path.write_text(text)
        return path

    return written


def test_it_reads_the_request_and_its_limits(script):
    assert can_start()
    assert run(script(ECHO), b"hello ", seconds=29.5, memory=5).output == b"hello 5 30"


@pytest.mark.parametrize(
    ("text", "failure"),
    [
        ("import time; time.sleep(60)", "took more than 1 s"),  # it waits
        ("raise SystemExit(3)", "ended the program"),
    ],
)
def test_why_there_is_no_answer(script, text, failure):
    answer = run(script(text), b"", seconds=0.1 if "sleep" in text else 30.0, memory=1)
    assert failure in answer.failure
    assert answer.output == b""


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_work_without_end_is_ended_by_its_processor_time(script):
    answer = run(script(BUSY), b"", seconds=1.0, memory=1)
    assert answer.failure == "took more than 1 s of a processor"


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_crash_is_told(script):
    text = "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"
    assert "crashed" in run(script(text), b"", seconds=30.0, memory=1).failure


def test_what_is_preloaded_here_is_not_there(script, monkeypatch):
    """A sanitizer reserves more than any limit of memory."""
    monkeypatch.setenv("LD_PRELOAD", "")
    monkeypatch.setenv("DYLD_INSERT_LIBRARIES", "")
    text = (
        "import os; print([n for n in os.environ if n.startswith(('LD_PRE', 'DYLD_INS'))], end='')"
    )
    assert run(script(text), b"", seconds=30.0, memory=1).output == b"[]"

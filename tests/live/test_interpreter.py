"""Python set for short answers, and set back."""

from __future__ import annotations

import gc
import platform
import subprocess
import sys

import pytest

from halfphysics.live.interpreter import SWITCH, quick_answers


@pytest.fixture(params=["nothing frozen", "the host's objects frozen"])
def frozen(request):
    """Whether the host has frozen objects; afterwards all are, as at the start of the tests."""
    gc.unfreeze()
    if request.param != "nothing frozen":
        gc.freeze()
    yield request.param != "nothing frozen"
    gc.freeze()


def test_it_is_set_back(frozen):
    before = sys.getswitchinterval(), gc.get_threshold()
    count = gc.get_freeze_count()
    with quick_answers():
        assert sys.getswitchinterval() == pytest.approx(SWITCH)
        assert gc.get_freeze_count() > count
    assert (sys.getswitchinterval(), gc.get_threshold()) == before
    assert gc.get_freeze_count() >= count if frozen else gc.get_freeze_count() == count


def test_the_allocator_gives_memory_back():
    """In a process of its own: it goes on with what it holds."""
    script = (
        "from halfphysics.live.interpreter import steady_memory\n"
        "held = [bytes([7]) * 2**k for k in range(22)]\n"
        "print(steady_memory())\n"
        "assert all(block == bytes([7]) * 2**k for k, block in enumerate(held))\n"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    glibc = platform.libc_ver()[0] == "glibc"
    assert ran.stdout.strip() == str(glibc)

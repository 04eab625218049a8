"""Python set for short answers, and set back."""

from __future__ import annotations

import gc
import platform
import subprocess
import sys

import pytest

from halfphysics.live.interpreter import SWITCH, quick_answers


def test_it_is_set_back():
    before = sys.getswitchinterval(), gc.get_threshold(), gc.get_freeze_count()
    with quick_answers():
        assert sys.getswitchinterval() == pytest.approx(SWITCH)
        assert gc.get_freeze_count() > before[2]
    assert (sys.getswitchinterval(), gc.get_threshold(), gc.get_freeze_count()) == before


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

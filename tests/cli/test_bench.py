"""halfphysics bench: numpy's threads, and cases that a machine cannot measure."""

from __future__ import annotations

import json
import os
import subprocess
import sys

from halfphysics import bench
from halfphysics.base.workers import THREADS
from support.command_line import run


def test_numpy_has_one_thread(tmp_path):
    """In a process of its own: here numpy is imported."""
    path = tmp_path / "bench.json"
    environment = {name: value for name, value in os.environ.items() if name not in THREADS}
    words = ["bench", "--case", "tree", "--quick", "--repeats", "1", "--json", str(path)]
    subprocess.run(
        [sys.executable, "-m", "halfphysics", *words],
        env=environment,
        check=True,
        timeout=300,
        capture_output=True,
    )
    machine = json.loads(path.read_text())["machine"]
    assert machine["threads"] == dict.fromkeys(THREADS, "1")


def test_memory_is_left_out_where_it_cannot_be_read(monkeypatch, capsys):
    monkeypatch.setattr("halfphysics.bench.sweep.sys.platform", "darwin")
    assert run("bench", "--case", "sweep-memory", "--quick") == 0
    assert "left out: what other processes hold is read on Linux only" in capsys.readouterr().out
    assert set(bench.LEFT_OUT) <= set(bench.CASES)

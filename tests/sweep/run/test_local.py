"""Processes of this machine at work on a sweep: the same bytes, also after deaths."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from halfphysics.base import machine
from halfphysics.base.workers import DIED, FULL
from halfphysics.errors import InputError
from halfphysics.sweep.run.driver import run
from halfphysics.sweep.run.local import GIB, LocalEngine, shares
from halfphysics.sweep.store.store import Store
from support.paths import DOCS
from support.sweeps.sweep_case import PLAN, Here, Told, data, deadly, planned


def swept(folder, plan, engine):
    told = Told()
    try:
        with Store(folder, plan) as store:
            return run(store, engine, told), told
    finally:
        engine.close()


def test_one_process_two_and_none_leave_the_same_bytes(tmp_path):
    plan = planned(tmp_path)
    none, one, two = (tmp_path / name for name in ("none", "one", "two"))
    report, _ = swept(none, plan, Here(none))
    assert (report.samples, report.skipped, report.failures, report.shards) == (11, 1, 0, 2)
    swept(one, plan, LocalEngine(one, 1))
    swept(two, plan, LocalEngine(two, 2))
    assert data(none) == data(one) == data(two)
    engine = Here(two)
    engine.submit = None
    swept(two, plan, engine)  # no work is left for an engine
    assert data(two) == data(one)


@pytest.mark.skipif(sys.platform != "linux", reason="limits what a process may have")
def test_variants_that_kill_their_process_or_eat_the_memory(tmp_path):
    plan = planned(tmp_path, PLAN.replace("batch: 2", "batch: 1"))
    out, whole = tmp_path / "out", tmp_path / "whole"
    report, told = swept(out, plan, LocalEngine(out, 2, 2.0, function=deadly))
    assert (report.samples, report.skipped, report.failures) == (9, 1, 2)
    lines = (out / "failures.jsonl").read_text().splitlines()
    assert [(f["number"], f["cause"]) for f in map(json.loads, lines)] == [(5, DIED), (9, FULL)]
    # Twice in a batch and twice alone, and the other variants of its task once.
    assert told.deaths == 8
    with Store(out, plan) as store:
        assert store.drop_failed() == 2
    report, _ = swept(out, plan, Here(out))
    assert (report.samples, report.skipped, report.failures) == (11, 1, 0)
    swept(whole, plan, Here(whole))
    assert data(out) == data(whole)


def test_the_document_s_script_runs(tmp_path):
    document = (DOCS / "sweeps.md").read_text(encoding="utf-8")
    section = document.split("## Running")[1].split("\n## ")[0]
    planned(tmp_path, PLAN.replace("[0.5, 1, 2]", "[1]"))
    (tmp_path / "script.py").write_text(section.split("```python\n")[1].split("```")[0])
    done = subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stdout) == (0, "4 samples, 0 failures\n"), done.stderr
    assert "leaked" not in done.stderr


def test_how_many_processes_and_what_each_may_have(monkeypatch):
    monkeypatch.setattr(machine, "cores", lambda: 16)
    monkeypatch.setattr(machine, "memory", lambda: 64 * GIB)
    assert shares() == (16, int(0.8 * 64 * GIB) // 16)
    assert shares(4) == (4, int(0.8 * 64 * GIB) // 4)
    assert shares(4, 8.0) == (4, 2 * GIB)
    monkeypatch.setattr(machine, "memory", lambda: 4 * GIB)
    assert shares()[0] == 3, "fewer where memory is short"
    assert shares(6)[0] == 6, "or what was asked for, if they can live on it"
    monkeypatch.setattr(machine, "memory", lambda: 1 * GIB)
    assert shares()[0] == 1


def test_more_memory_than_there_is(monkeypatch):
    monkeypatch.setattr(machine, "memory", lambda: 4 * GIB)
    assert shares(2, 4.0) == (2, 2 * GIB)
    for gib in (4.001, 99999.0, float("inf")):
        with pytest.raises(InputError, match=rf"memory: found {gib:g} GiB, .* at most the 4 GiB"):
            shares(2, gib)


@pytest.mark.parametrize(
    ("jobs", "gib", "said"),
    [
        (0, None, "at least 1"),
        (None, 0.1, "at least 0.5"),
        (None, -1.0, "at least 0.5"),
        (None, float("nan"), "at least 0.5"),
        (16, 2.0, "at most 4 processes"),
    ],
)
def test_impossible_numbers(jobs, gib, said):
    with pytest.raises(InputError, match=said):
        shares(jobs, gib)

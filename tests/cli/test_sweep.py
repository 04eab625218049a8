"""halfphysics sweep: its output, and its messages for mistakes, failures and interruptions."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from halfphysics.cli import INTERRUPTED, MISTAKE, main
from halfphysics.cli import sweep as command
from halfphysics.sweep.run.engines import Death
from halfphysics.sweep.run.work import Done
from halfphysics.sweep.store import store as stores
from support.processes import group_ends, needs_proc
from support.sweeps.sweep_case import PLAN, Here, data

BAD = PLAN.replace("inputs:", "inputs:\n  - files: bad.npz").split("factors:")[0]
BAD += "factors:\n  objects.friction: [0.5]\noutputs: {folder: data, batch: 1}\n"


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.yaml"
    path.write_text(PLAN)
    return str(path)


@pytest.fixture
def here(monkeypatch):
    """Run the workers' tasks in this process."""
    monkeypatch.setattr(command.Command, "_engine", lambda self, folder: Here(folder))


def test_a_dry_run_only_shows(plan, tmp_path, capsys):
    assert main(["sweep", plan, "--dry-run"]) == 0
    out, err = capsys.readouterr()
    assert "kick_ball" in out
    assert re.search(r"variants +12", out)
    assert err == ""
    assert [path.name for path in tmp_path.iterdir()] == ["plan.yaml"]


def test_out_is_where_it_goes(plan, tmp_path, capsys):
    assert main(["sweep", plan, "--out", str(tmp_path / "there"), "--dry-run"]) == 0
    assert str(tmp_path / "there") in capsys.readouterr().out


def test_out_is_no_input(tmp_path, capsys, here):
    (tmp_path / "plan.yaml").write_text(BAD.replace("files: bad.npz", "files: '**/*.npz'"))
    for name in ("bad.npz", "there/bad.npz"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"no clip")
    out = ["--out", str(tmp_path / "there")]
    assert main(["sweep", str(tmp_path / "plan.yaml"), *out, "--dry-run"]) == 0
    assert re.search(r"^inputs +2: bad\.npz, kick_ball$", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--jobs", "0"], "--jobs: found 0, expected at least 1"),
        (["--verify", "0"], "--verify: found 0, expected at least 1"),
        (["--address", "auto"], "--address: is for --engine ray"),
        (["--dry-run", "--retry-failed"], "expected one of these at a time"),
        (["--engine", "slurm"], "slurm"),
        (["--memory", "0.01"], "memory: found 0.01 GiB, expected at least 0.5"),
        (["--memory", "inf"], "memory: found inf GiB, expected at most the "),
        (["--memory", "nan"], "--memory: found nan GiB, expected at least 0.5"),
        (["--memory", "-1"], "--memory: found -1 GiB, expected at least 0.5"),
        (["--memory", "nan", "--dry-run"], "--memory: expected a number above 0 [GiB], found nan"),
        (["--memory", "-1", "--engine", "ray"], "--memory: expected a number above 0 [GiB]"),
        (["--out", "plan.yaml"], "this is a file"),
    ],
)
def test_mistakes_are_one_message(plan, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    assert main(["sweep", plan, *arguments]) == MISTAKE
    out, error = capsys.readouterr()
    assert said in error
    assert error.count("\n") == 1
    assert out == "" or "--out" in arguments  # what the plan is may be said first
    assert sorted(tmp_path.rglob("*")) == before


def test_no_such_plan(tmp_path, capsys):
    assert main(["sweep", str(tmp_path / "no.yaml")]) == MISTAKE
    assert "no.yaml" in capsys.readouterr().err


def test_verify_may_stand_without_a_number():
    for arguments, count in (
        (["--verify"], command.VERIFIED),
        (["--verify", "--out", "o"], command.VERIFIED),
        (["--verify", "3"], 3),
        (["--verify=4"], 4),
        ([], None),
    ):
        assert command.read("halfphysics sweep", ["plan.yaml", *arguments]).verify == count


def test_a_poisoned_clip_costs_its_variants_and_is_said(tmp_path, capsys, here):
    (tmp_path / "plan.yaml").write_text(BAD)
    (tmp_path / "bad.npz").write_bytes(b"no clip")
    arguments = ["sweep", str(tmp_path / "plan.yaml")]
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert "2 variants: 1 samples, 1 of them a success, 1 failed" in out
    assert "1 x " in out
    assert "failures.jsonl" in out
    assert "2 variants to make: the first took" in err
    (failure,) = map(json.loads, (tmp_path / "data/failures.jsonl").read_text().splitlines())
    assert (failure["number"], failure["input"]) == (0, "bad.npz")
    before = data(tmp_path / "data")

    assert main(arguments) == 0, "nothing is left to do"
    assert capsys.readouterr().out == out
    assert main([*arguments, "--retry-failed"]) == 0
    assert "1 variants failed and are tried again" in capsys.readouterr().out
    assert data(tmp_path / "data") == before
    assert main([*arguments, "--verify"]) == 0
    assert "1 sample" in capsys.readouterr().out


def test_what_is_verified_is_the_plan_that_is_given(plan, tmp_path, capsys, here):
    out = str(tmp_path / "out")
    assert main(["sweep", plan, "--out", out]) == 0
    Path(plan).write_text(PLAN.replace("0.8]", "0.9]"))
    capsys.readouterr()
    assert main(["sweep", plan, "--out", out, "--verify", "1"]) == MISTAKE
    err = capsys.readouterr().err
    assert "holds another plan: factors.objects.friction" in err
    # The fix that the message suggests works.
    (command,) = re.findall(r"\(halfphysics (.*?)\)", err)
    assert main([*command.split(), "--verify", "1"]) == 0
    assert main(command.split()) == 0
    assert "12 variants: 11 samples" in capsys.readouterr().out


def test_a_sweep_of_nothing_but_failures_is_no_success(tmp_path, capsys, here):
    text = BAD.replace("  - scenarios: [kick_ball]\n", "")
    (tmp_path / "plan.yaml").write_text(text)
    (tmp_path / "bad.npz").write_bytes(b"no clip")
    assert main(["sweep", str(tmp_path / "plan.yaml")]) == MISTAKE
    out, err = capsys.readouterr()
    assert "1 variants: 0 samples, 1 failed" in out
    assert re.search(r"no sample came of it, 1 variants failed\. .*failures\.jsonl", err)


def test_a_full_disk_is_one_message_that_says_how_to_go_on(
    plan, tmp_path, monkeypatch, capsys, here
):
    monkeypatch.setattr(Here, "wait", _full(Here.wait))
    arguments = ["sweep", plan, "--out", str(tmp_path / "out")]
    assert main(arguments) == MISTAKE
    err = capsys.readouterr().err
    assert "no room" in err
    (done,) = re.findall(r"(\d+) of 12 variants are done\.", err)
    assert 6 <= int(done) < 12
    assert f"To go on: halfphysics {' '.join(arguments)}" in err
    monkeypatch.undo()
    monkeypatch.setattr(command.Command, "_engine", lambda self, folder: Here(folder))
    assert main(arguments) == 0
    assert "12 variants: 11 samples, 1 left out" in capsys.readouterr().out


def _full(wait):
    """Disk space for three tasks."""
    room = [None] * 3

    def waiting(engine):
        if room:
            room.pop()
            return wait(engine)
        return [(engine.tasks.pop(0), Done(0.1, stop="no room"))]

    return waiting


def test_deaths_are_said(plan, tmp_path, monkeypatch, capsys, here):
    wait, once = Here.wait, []

    def dying(engine):
        if once:
            return wait(engine)
        once.append(engine.tasks.pop(0))
        return [(once[0], Death())]

    monkeypatch.setattr(Here, "wait", dying)
    assert main(["sweep", plan, "--out", str(tmp_path / "out")]) == 0
    assert "at batch 0: its process died" in capsys.readouterr().err


def test_another_sweep_in_the_folder_is_refused(plan, tmp_path, capsys, here):
    with stores.Store(tmp_path / "out", stores_plan(plan)):
        assert main(["sweep", plan, "--out", str(tmp_path / "out")]) == MISTAKE
    assert "another sweep works in this folder" in capsys.readouterr().err


def stores_plan(path):
    from halfphysics.sweep import Plan

    return Plan.load(path)


@pytest.mark.slow
@needs_proc
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_stopped_it_says_how_to_go_on_and_leaves_nobody_behind(plan, tmp_path, sign):
    out = tmp_path / "out"
    arguments = ["sweep", plan, "--out", str(out), "--jobs", "2"]
    process = subprocess.Popen(
        [sys.executable, "-m", "halfphysics", *arguments],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    deadline = time.monotonic() + 120.0
    while not list(out.glob("work/0*/*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    begin = time.monotonic()
    if sign == signal.SIGINT:
        os.killpg(process.pid, sign)  # as a terminal sends it
    else:
        process.send_signal(sign)
    err = process.communicate(timeout=60.0)[1].decode()
    assert process.returncode == INTERRUPTED
    assert time.monotonic() - begin < 20.0  # seconds, on a machine that may be busy
    assert f"of 12 variants are done. To go on: halfphysics {' '.join(arguments)}" in err
    assert "Traceback" not in err
    assert "leaked" not in err, "nothing stays behind in the system"
    # Helper processes of multiprocessing end a little later.
    assert group_ends(process.pid, 10.0)

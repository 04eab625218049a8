"""The evidence's framework: results are stored and correct, the rest survives a failure."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from evidence_case import tasks as case

import evidence
from evidence import document, runner
from evidence.command import main
from evidence.model import (
    Content,
    Figure,
    Options,
    Outcome,
    Row,
    Section,
    Task,
    at_least,
    at_most,
    plain,
)
from evidence.runner import Job
from evidence.store import Store
from halfphysics.cli import MISTAKE
from halfphysics.errors import FileError, InputError
from support.processes import of_group

SQUARE = "evidence_case.tasks:square"


def squares(folder, count=6, **arguments):
    """A section of this many tasks that log their work."""
    log = str(folder / "log.txt")

    def tasks(options):
        arguments_of = [{"value": i, "log": log, **arguments} for i in range(count)]
        return [
            Task(key=f"a/{a['value']}", function=SQUARE, arguments=a, seconds=1 + a["value"])
            for a in arguments_of
        ]

    def content(options, values):
        rows = [
            Row(name=key, figures=(at_most(100.0, found["square"], name="square"),))
            for key, found in values.items()
        ]
        return Content(rows=tuple(rows))

    return Section(key="squares", title="Squares", about="", tasks=tasks, content=content)


@pytest.fixture
def with_sections(monkeypatch):
    """Make the report consist of these sections."""

    def use(*sections):
        monkeypatch.setattr(evidence, "listed", lambda only=(): list(sections))

    return use


def done_in(folder):
    log = folder / "log.txt"
    return sorted(map(int, log.read_text().split())) if log.exists() else []


# -- values --------------------------------------------------------------------------------------


def test_plain_values_survive_json_bit_for_bit():
    import numpy as np

    given = {"a": np.float64(0.1), "b": (1, np.int32(2)), "c": np.array([[1.5, 2.0]]), "d": None}
    found = plain(given, "x")
    assert found == {"a": 0.1, "b": [1, 2], "c": [[1.5, 2.0]], "d": None}
    assert json.loads(json.dumps(found)) == found


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), {"a": {1, 2}}, [b"bytes"]])
def test_what_json_cannot_say_is_an_error_that_names_its_place(bad):
    with pytest.raises(InputError, match="table/x"):
        plain({"x": bad}, "table")


@pytest.mark.parametrize(
    "given", [{"seed": -1}, {"seed": 0.5}, {"seed": True}, {"data": {"other": Path("/")}}]
)
def test_impossible_options(given):
    with pytest.raises(InputError, match="expected"):
        Options(**given)


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        Options(data={"aist": tmp_path / "nothing"})


@pytest.mark.parametrize(
    ("make", "limit", "ours", "good"),
    [
        (at_most, 1.0, 1.0, True),
        (at_most, 1.0, 1.1, False),
        (at_least, 1.0, 1.0, True),
        (at_least, 1.0, 0.9, False),
        (at_most, 1.0, None, None),
    ],
)
def test_expectations(make, limit, ours, good):
    figure = make(limit, ours, name="x")
    assert figure.reproduced is good
    assert f"{limit:g}" in figure.expected


def test_the_verdict_counts_every_figure_once():
    rows = [
        {"quoted": False, "figures": [vars(at_most(1.0, x, name="x")) for x in (0.5, 2.0, None)]},
        {"quoted": False, "figures": [vars(Figure(name="y", ours=1.0))]},
        # 39.7 mm where the paper has 145.5: its direction, not its number.
        {"quoted": False, "figures": [vars(at_least(10.0, 39.7, name="z", paper=145.5))]},
        {"quoted": True, "figures": [vars(Figure(name="y", ours=None, paper=1.0))]},
    ]
    counted = document.verdict([{"rows": rows, "failed": [{"task": "t", "cause": "c"}]}])
    assert counted == {
        "reproduced": 1,
        "direction": 1,
        "not_reproduced": 1,
        "shown": 1,
        "missing": 2,
    }


# -- the store -----------------------------------------------------------------------------------


def test_what_is_kept_is_found_again(tmp_path):
    store, task = Store(tmp_path), Task(key="a/b", function=SQUARE, arguments={"value": 3})
    assert store.load("s", task) is None
    store.keep("s", task, case.square(3))
    assert store.load("s", task) == {"square": 9}
    assert store.picture("s", "a/b", "dot") == case.PNG + b"3"


def test_other_arguments_files_or_functions_are_other_work(tmp_path):
    file = tmp_path / "clip.npz"
    file.write_bytes(b"one")
    store = Store(tmp_path / "work")
    task = Task(key="a", function=SQUARE, arguments={"value": 3}, inputs=(str(file),))
    store.keep("s", task, case.square(3))
    assert store.load("s", task) is not None
    others = [
        Task(key="a", function=SQUARE, arguments={"value": 4}, inputs=(str(file),)),
        Task(key="a", function="evidence_case.tasks:bug", arguments={"value": 3}),
        Task(key="b", function=SQUARE, arguments={"value": 3}, inputs=(str(file),)),
    ]
    assert [store.load("s", other) for other in others] == [None] * 3
    file.write_bytes(b"two")
    assert store.load("s", task) is None


def test_another_program_is_other_work(tmp_path, monkeypatch):
    store, task = Store(tmp_path), Task(key="a", function=SQUARE, arguments={"value": 3})
    store.keep("s", task, case.square(3))
    monkeypatch.setattr("evidence.store.program", lambda: "another")
    assert store.load("s", task) is None


@pytest.mark.parametrize("damage", ["cut", "empty", "edited", "picture", "no picture", "list"])
def test_what_is_damaged_counts_as_not_there(tmp_path, damage):
    store, task = Store(tmp_path), Task(key="a", function=SQUARE, arguments={"value": 3})
    store.keep("s", task, case.square(3))
    path, picture = tmp_path / "s" / "a.json", tmp_path / "s" / "a.dot.png"
    whole = path.read_bytes()
    if damage == "cut":
        path.write_bytes(whole[:-20])
    elif damage == "empty":
        path.write_bytes(b"")
    elif damage == "edited":
        path.write_bytes(whole.replace(b'"square": 9', b'"square": 8'))
    elif damage == "picture":
        picture.write_bytes(b"other")
    elif damage == "no picture":
        picture.unlink()
    else:
        path.write_bytes(b"[]")
    assert store.load("s", task) is None
    store.keep("s", task, case.square(3))
    assert store.load("s", task) == {"square": 9}
    assert path.read_bytes() == whole


@pytest.mark.parametrize("key", ["../x", "a//b", "", ".hidden", "a\nb", "a\\b"])
def test_a_key_is_no_way_out_of_the_folder(tmp_path, key):
    with pytest.raises(InputError, match="expected letters"):
        Store(tmp_path).keep("s", Task(key=key, function=SQUARE), Outcome(values={}))
    assert list(tmp_path.iterdir()) == []


def test_values_that_are_no_numbers_are_not_kept(tmp_path):
    task = Task(key="a", function="evidence_case.tasks:endless")
    done = runner.work(tmp_path, Job("s", task))
    assert "expected a finite number" in done.cause
    assert Store(tmp_path).load("s", task) is None


# -- the runner ----------------------------------------------------------------------------------


@pytest.mark.parametrize("workers", [1, 2])
def test_one_failure_costs_one_task(tmp_path, workers, capfd):
    jobs = [
        *(Job("s", t) for t in squares(tmp_path).tasks(None)),
        Job("s", Task(key="w", function="evidence_case.tasks:wrong", arguments={"cause": "bad"})),
        Job("s", Task(key="b", function="evidence_case.tasks:bug")),
    ]
    done = {d.job.task.key: d.cause for d in runner.run(tmp_path / "work", jobs, workers)}
    assert len(done) == len(jobs)
    assert done.pop("w") == "bad"
    assert "KeyError" in done.pop("b")
    assert "Traceback" in capfd.readouterr().err
    assert set(done.values()) == {""}
    assert done_in(tmp_path) == list(range(6))


def test_a_process_that_dies_costs_what_it_was_doing_and_that_is_tried_again(tmp_path):
    once = {"once": str(tmp_path / "died")}
    jobs = [Job("s", t) for t in squares(tmp_path).tasks(None)]
    jobs += [
        Job("s", Task(key="x", function="evidence_case.tasks:dies", seconds=3.0)),
        Job("s", Task(key="y", function="evidence_case.tasks:dies", arguments=once, seconds=4.5)),
    ]
    done = {d.job.task.key: d.cause for d in runner.run(tmp_path / "work", jobs, 2)}
    assert "its process died" in done.pop("x")
    assert set(done.values()) == {""}
    assert len(done) == 7
    assert set(done_in(tmp_path)) == set(range(6))


# -- the whole report ----------------------------------------------------------------------------


def test_a_report_is_the_same_whoever_makes_it_and_however_often(tmp_path, with_sections):
    with_sections(squares(tmp_path))
    one, two = tmp_path / "one", tmp_path / "two"
    evidence.make(one, workers=1)
    evidence.make(two, workers=2)
    assert (one / evidence.JSON).read_bytes() == (two / evidence.JSON).read_bytes()
    assert done_in(tmp_path) == sorted(2 * list(range(6)))
    evidence.make(one, workers=2)
    assert len(done_in(tmp_path)) == 12, "nothing is computed twice"
    assert (one / evidence.JSON).read_bytes() == (two / evidence.JSON).read_bytes()


@pytest.mark.parametrize("seed", range(3))
def test_half_of_the_work_deleted_is_done_again_to_the_same_bytes(tmp_path, with_sections, seed):
    with_sections(squares(tmp_path, 9))
    evidence.make(tmp_path / "out", workers=1)
    files = sorted(p for p in (tmp_path / "out" / evidence.WORK).rglob("*") if p.is_file())
    before = {p: p.read_bytes() for p in files}
    written = (tmp_path / "out" / evidence.JSON).read_bytes()
    for path in random.Random(seed).sample(files, len(files) // 2):
        path.unlink()
    (tmp_path / "out" / evidence.JSON).unlink()
    evidence.make(tmp_path / "out", workers=2)
    assert (tmp_path / "out" / evidence.JSON).read_bytes() == written
    assert {p: p.read_bytes() for p in files} == before


def test_what_failed_is_in_the_report_and_is_tried_again(tmp_path, with_sections):
    good = squares(tmp_path, 2)
    bad = Task(key="w", function="evidence_case.tasks:wrong", arguments={"cause": "clip: broken"})
    with_sections(
        Section(
            key="s",
            title="",
            about="",
            tasks=lambda options: [*good.tasks(options), bad],
            content=good.content,
        )
    )
    report = evidence.make(tmp_path / "out")
    (entry,) = report.content["sections"]
    assert entry["failed"] == [{"task": "w", "cause": "clip: broken"}]
    assert [row["name"] for row in entry["rows"]] == ["a/0", "a/1"]
    assert report.content["verdict"]["missing"] == 1
    assert evidence.make(tmp_path / "out").content == report.content


def test_what_changes_under_it_is_said(tmp_path, with_sections):
    """A user's file that disappears, and one that is written to, during the work."""
    gone, changed, good = (tmp_path / name for name in ("gone", "changed", "good"))
    for file in (gone, changed, good):
        file.write_text("before")
    ends = {gone: "removes", changed: "writes", good: "leaves"}
    tasks = [
        Task(
            key=file.name,
            function="evidence_case.tasks:meddles",
            arguments={"path": str(file), "how": how},
            inputs=(str(file),),
        )
        for file, how in ends.items()
    ]
    rows = squares(tmp_path).content
    section = Section(key="s", title="", about="", tasks=lambda options: tasks, content=rows)
    with_sections(section)
    (entry,) = evidence.make(tmp_path / "out").content["sections"]
    assert [row["name"] for row in entry["rows"]] == ["good"]
    assert [f["task"] for f in entry["failed"]] == ["changed", "gone"]
    assert all("changed while" in f["cause"] for f in entry["failed"])


def test_folders_are_known_by_what_is_in_them(tmp_path):
    folder, store = tmp_path / "release", Store(tmp_path / "work")
    (folder / "below").mkdir(parents=True)
    (folder / "loop").symlink_to(folder)
    (folder / "nowhere").symlink_to("nothing")
    task = Task(key="a", function=SQUARE, arguments={"value": 3}, inputs=(str(folder),))
    store.keep("s", task, case.square(3))
    assert store.load("s", task) == {"square": 9}
    (folder / "below" / "more").write_text("")
    assert store.load("s", task) is None


def test_what_is_timed_is_in_a_file_of_its_own(tmp_path, with_sections):
    stable = squares(tmp_path, 2)
    timed = evidence.Section(
        key="t", title="", about="", tasks=stable.tasks, content=stable.content, timing=True
    )
    with_sections(stable, timed)
    report = evidence.make(tmp_path / "out")
    assert [s["key"] for s in report.content["sections"]] == ["squares"]
    assert [s["key"] for s in report.speed["sections"]] == ["t"]
    assert "machine" in report.speed
    assert "machine" not in report.content


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="cannot make this folder"):
        evidence.make(tmp_path / "file" / "out")


_KILLED = """
import sys
from pathlib import Path
sys.path[:0] = {places!r}
import evidence
from test_evidence import squares
if __name__ == "__main__":
    folder = Path({folder!r})
    evidence.listed = lambda only=(): [squares(folder, 9, nap=0.25)]
    evidence.make(folder / "out", workers=2)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGINT])
def test_killed_in_the_middle_it_goes_on_where_it_was(tmp_path, with_sections, sign):
    script = tmp_path / "make.py"
    script.write_text(_KILLED.format(places=sys.path, folder=str(tmp_path)))
    process = subprocess.Popen(
        [sys.executable, str(script)], start_new_session=True, stderr=subprocess.DEVNULL
    )
    deadline = time.monotonic() + 60.0
    while len(done_in(tmp_path)) < 3 and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(sign)
    process.wait(30.0)
    time.sleep(1.0)  # a process that is left would go on
    early = done_in(tmp_path)
    assert 3 <= len(early) < 9
    time.sleep(1.0)
    assert done_in(tmp_path) == early, "the workers have ended with their parent"
    if sign == signal.SIGKILL:
        assert not of_group(process.pid)
    with_sections(squares(tmp_path, 9, nap=0.25))
    evidence.make(tmp_path / "out", workers=1)
    again = done_in(tmp_path)
    # Of the logged tasks, only those under way at the end may have been lost.
    assert len(again) - len(early) <= 9 - len(early) + 2
    evidence.make(tmp_path / "whole", workers=1)
    name = evidence.JSON
    assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


# -- the command ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--only", "table9"], "unknown section 'table9'"),
        (["--data", "aist"], "expected KIND=FOLDER"),
        (["--data", "other=/"], "expected one of aist, clips, scenes"),
        (["--data", "clips=/nothing/here"], "there is no such folder"),
        (["--data", "clips=.", "--data", "clips=."], "found clips twice"),
        (["--jobs", "0"], "expected at least 1"),
        (["--seed", "-1"], "whole number"),
    ],
)
def test_mistakes_are_one_message(tmp_path, capsys, arguments, said):
    assert main(["--out", str(tmp_path / "out"), *arguments]) == MISTAKE
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_the_help_names_every_section(capsys):
    main(["--help"])
    words = capsys.readouterr().out.replace(",", " ").replace(";", " ").split()
    assert set(evidence.KEYS) <= set(words)


def test_every_section_has_tasks_of_its_own_names(tmp_path):
    assert tuple(section.key for section in evidence.listed()) == evidence.KEYS
    for quick in (True, False):
        options = Options(quick=quick)
        for section in evidence.listed():
            keys = [task.key for task in section.tasks(options)]
            assert keys, section.key
            assert len(set(keys)) == len(keys), section.key
            for task in section.tasks(options):
                assert callable(runner.function_of(task))
                assert Store(tmp_path).load(section.key, task) is None
    assert os.listdir(tmp_path) == []

"""Progress messages of a sweep."""

from __future__ import annotations

import pytest

from halfphysics.sweep.run import progress as told
from halfphysics.sweep.run.engines import Death
from halfphysics.sweep.run.progress import Progress, bytes_text, time_text
from halfphysics.sweep.run.work import Done, Task

TASK = Task("batches", 0, 3)


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set by hand."""
    now = [100.0]
    monkeypatch.setattr(told.time, "monotonic", lambda: now[0])
    return now


def test_lines_now_and_then(clock):
    said = []
    progress = Progress(bar=False, say=said.append)
    progress.begin(1000)
    progress.found(500)
    clock[0] += 1.0
    progress.ended(TASK, Done(4.0, kept=6, skipped=1, causes=("bad",), size=8000))
    assert said.pop() == (
        "500 variants to make: the first took 0.5 s each, so that is 4 min of work, 500 kB"
    )
    clock[0] += 1.0
    progress.ended(TASK, Done(4.0, kept=8))
    progress.ended(Task("seal", 0), Done(1.0))
    assert said == [], "not every task has a line"
    clock[0] += 6.0
    progress.ended(TASK, Done(4.0, kept=4))
    assert said.pop() == "520/1000 variants, 2.5/s, 3 min left, 1 failed"
    assert (progress.done, progress.failed, progress.size) == (520, 1, 8000)


def test_deaths_are_said_with_their_place():
    said = []
    progress = Progress(bar=False, say=said.append)
    for kind in ("batches", "variants", "seal"):
        progress.died(Task(kind, 7, 3), Death("it died"))
    assert said == ["at batch 3: it died", "at variant 3: it died", "at shard 7: it died"]
    assert progress.deaths == 3


def test_a_bar(capsys):
    progress = Progress(bar=True)
    progress.begin(20)
    progress.found(10)
    progress.ended(TASK, Done(1.0, kept=4, causes=("bad",)))
    assert "15/20" in str(progress._bar)
    assert "1 failed" in str(progress._bar)
    progress.close()
    progress.close()
    assert "10 variants to make" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("seconds", "said"),
    [(0.4, "0 s"), (89, "89 s"), (600, "10 min"), (7200, "2.0 h"), (864000, "10.0 days")],
)
def test_times(seconds, said):
    assert time_text(seconds) == said


@pytest.mark.parametrize(
    ("size", "said"), [(12, "12 B"), (1500, "1.5 kB"), (2.5e9, "2.5 GB"), (4e13, "40 TB")]
)
def test_sizes(size, said):
    assert bytes_text(size) == said

"""Failures of the fuzzer are printed, and unfinished cases are not lost."""

from __future__ import annotations

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from support import fuzzing


@pytest.fixture
def folder(monkeypatch, tmp_path):
    """Random runs, of one batch; their cases are in this folder."""
    monkeypatch.setattr(fuzzing, "SECONDS", 1e-9)
    monkeypatch.setattr(fuzzing, "UNDER_WAY", tmp_path)
    return tmp_path


def test_a_failing_case_is_said_as_it_was_found(folder, capfd):
    tried = []

    @fuzzing.drawn(1)
    @given(x=st.integers(100, 999), y=st.just("y"))
    def check(x, y):
        tried.append(x)
        assert x < 0, "not negative"

    with pytest.raises(AssertionError):
        check()
    case = f"@example(x={tried[0]}, y='y')"
    # No shrinking was tried, even though every case fails.
    assert set(tried) == {tried[0]}
    assert len(tried) <= 3
    said = capfd.readouterr().err
    assert case in said
    assert "not negative" in said
    (file,) = folder.iterdir()
    assert file.read_text().strip() == case


def test_a_case_that_was_stopped_is_still_there(folder):
    class Stopped(BaseException):
        pass

    @fuzzing.drawn(1)
    @given(x=st.integers(100, 999))
    def check(x):
        raise Stopped

    with pytest.raises(Stopped):
        check()
    (file,) = folder.iterdir()
    assert file.read_text().startswith("@example(x=")


def test_what_passes_or_does_not_count_leaves_nothing(folder):
    seen = []

    @fuzzing.drawn(1)
    @given(x=st.integers(0, 9))
    def check(x):
        (file,) = folder.iterdir()
        assert f"(x={x})" in file.read_text()
        seen.append(x)
        assume(x % 2)

    check()
    assert seen
    assert not list(folder.iterdir())


def test_few_cases_are_the_same_every_time(monkeypatch, tmp_path):
    monkeypatch.setattr(fuzzing, "SECONDS", 0.0)
    monkeypatch.setattr(fuzzing, "UNDER_WAY", tmp_path / "none")
    runs = []

    @fuzzing.drawn(5)
    @given(x=st.integers(0, 10**9))
    def check(x):
        runs[-1].append(x)

    for _ in range(2):
        runs.append([])
        check()
    assert len(runs[0]) == 5
    assert runs[0] == runs[1]
    assert not (tmp_path / "none").exists()

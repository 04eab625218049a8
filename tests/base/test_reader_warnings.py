"""What readers warn of is said at the caller's line, and once a file."""

from __future__ import annotations

import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from halfphysics.base.reader_warnings import one_warning, warn
from halfphysics.errors import HalfPhysicsWarning

FILE = Path("clips.p")


def said(*messages, path=FILE):
    """The warnings that come of several in a block, as (text, file)."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with one_warning(path):
            for message in messages:
                warn(message)
    return [(str(each.message), each.filename) for each in caught]


def test_several_are_one():
    ((text, file),) = said(f"{FILE}, clip 'a b': no mass.", f"{FILE}: a floor", "elsewhere: odd")
    assert text == f"{FILE}, clip 'a b': no mass; a floor; elsewhere: odd"
    assert file == __file__


def test_one_stays_as_it_is_and_none_is_none():
    assert said(f"{FILE}: a floor")[0][0] == f"{FILE}: a floor"
    assert said("another.p: a floor")[0][0] == "another.p: a floor"
    assert said() == []


def test_the_same_is_said_once():
    assert said(f"{FILE}: a floor", f"{FILE}: a floor")[0][0] == f"{FILE}: a floor"


def nested():
    with one_warning(FILE):
        with one_warning(FILE):
            warn(f'{FILE}, clip "it\'s": no mass')
            warn(f"{FILE}: a floor")
        warn(f"{FILE}: hands")


def test_a_block_in_a_block():
    with pytest.warns(HalfPhysicsWarning) as caught:
        nested()
    assert [str(each.message) for each in caught] == [
        f'{FILE}, clip "it\'s": no mass; a floor; hands'
    ]


def fails():
    with one_warning(FILE):
        warn(f"{FILE}: no mass")
        raise ValueError("mine")


def test_what_was_said_before_an_error_is_said():
    with pytest.warns(HalfPhysicsWarning, match="no mass"), pytest.raises(ValueError, match="mine"):
        fails()


def test_threads_read_for_themselves():
    """Two files at the same time: each is warned of by itself."""
    both = threading.Barrier(2)

    def read(path):
        with one_warning(path):
            warn(f"{path}: no mass")
            both.wait(timeout=10)
            warn(f"{path}: a floor")

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with ThreadPoolExecutor(2) as threads:
            list(threads.map(read, (Path("a.p"), Path("b.p"))))
    assert sorted(str(each.message) for each in caught) == [
        "a.p: no mass; a floor", "b.p: no mass; a floor",
    ]  # fmt: skip


def test_a_warning_may_be_an_error():
    with warnings.catch_warnings():
        warnings.simplefilter("error", HalfPhysicsWarning)
        with pytest.raises(HalfPhysicsWarning, match="no mass; a floor; hands"):
            nested()

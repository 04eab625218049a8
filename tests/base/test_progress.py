"""Progress bars: for whom they are, where they are shown, and that short work says nothing."""

from __future__ import annotations

import sys
import threading
import time
import types

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import progress as module
from halfphysics.base.progress import NoBar, bar, over
from support import small_results as small
from support.terminals import terminal


def at_once(monkeypatch):
    """What a terminal shows; bars begin at once.

    No fixture: pytest has a standard error of its own for each phase of a test.
    """
    monkeypatch.setattr(module, "DELAY", 0.0)
    monkeypatch.setattr(module, "_EVERY", 0.0)
    return terminal(monkeypatch)


def test_nothing_is_shown_unless_somebody_asks(monkeypatch):
    shown = at_once(monkeypatch)
    assert list(over([1, 2, 3], "counting", "thing")) == [1, 2, 3]
    assert shown.getvalue() == ""


def test_what_is_asked_for_is_shown(monkeypatch):
    shown = at_once(monkeypatch)
    with hp.progress():
        assert list(over([1, 2, 3], "counting", "thing", size=4)) == [1, 2, 3]
    assert "counting: 100%" in shown.getvalue()
    assert "12/12" in shown.getvalue()
    assert list(over([1], "later", "thing")) == [1]
    assert "later" not in shown.getvalue()


def test_what_is_shown_unasked_can_be_kept_quiet(monkeypatch):
    shown = at_once(monkeypatch)
    with hp.progress(False), bar(3, "cutting", "piece", unasked=True) as quiet:
        quiet.update(3)
    assert shown.getvalue() == ""
    with bar(3, "cutting", "piece", unasked=True) as drawn:
        drawn.update(3)
    assert "cutting: 100%" in shown.getvalue()


def test_inner_steps_are_shown_with_the_outer_ones(monkeypatch):
    """`progress=True` of a function counts for all that it does; False leaves it to the caller."""
    shown = at_once(monkeypatch)
    with module.asked(True), module.asked(False):
        list(over(range(2), "inner", "thing"))
    assert "inner: 100%" in shown.getvalue()


def test_short_work_says_nothing(monkeypatch):
    text = terminal(monkeypatch)
    with hp.progress():
        list(over(range(100), "quick", "thing"))
    assert text.getvalue() == ""


def test_a_long_call_is_shown_while_it_runs(monkeypatch):
    """Though nothing reports to the bar."""
    monkeypatch.setattr(module, "DELAY", 0.02)
    monkeypatch.setattr(module, "_TICK", 0.02)
    text = terminal(monkeypatch)
    with hp.progress(), bar(7, "one long call", "piece"):
        end = time.monotonic() + 10.0
        while "one long call:   0%" not in text.getvalue() and time.monotonic() < end:
            time.sleep(0.01)
    assert "one long call:   0%" in text.getvalue()
    assert not [t for t in threading.enumerate() if t.name == "halfphysics-bar"]


def test_nothing_in_a_file(monkeypatch, capsys):
    monkeypatch.setattr(module, "DELAY", 0.0)
    with hp.progress():
        assert isinstance(bar(3, "counting", "thing"), NoBar)
        list(over([1, 2], "counting", "thing"))
    assert capsys.readouterr() == ("", "")


def test_nothing_without_standard_error(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)  # as under pythonw
    with hp.progress():
        assert isinstance(bar(3, "counting", "thing"), NoBar)


def test_notebooks_without_widgets_get_no_lines(monkeypatch):
    shown = at_once(monkeypatch)
    monkeypatch.setitem(sys.modules, "ipykernel", types.ModuleType("ipykernel"))
    with hp.progress():
        assert isinstance(bar(3, "counting", "thing"), NoBar)
    assert shown.getvalue() == ""


def test_notebooks_with_widgets_get_them(monkeypatch):
    class Widget:
        def __init__(self, **options):
            self.options, self.done = options, 0

        def update(self, count):
            self.done += count

        def refresh(self):
            pass

        def close(self):
            self.closed = True

    monkeypatch.setitem(sys.modules, "ipykernel", types.ModuleType("ipykernel"))
    monkeypatch.setattr(module, "_of_notebook", lambda: Widget)
    with hp.progress(), bar(3, "counting", "thing") as made:
        made.update(2)
    widget = made._drawn
    assert (widget.options["total"], widget.options["desc"], widget.done) == (3, "counting", 2)
    assert widget.closed


#: Steps that may take longer than two seconds, and their words.
STEPS = {
    "simulating:   0%": lambda: hp.simulate(small.motions()[0], small.scene(), progress=True),
    "simulating:  50%": lambda: hp.simulate_many(
        [small.motions()[0]] * 2, threads=1, progress=True
    ),
    "penetration: 100%": lambda: hp.metrics.penetration(
        small.motions()[0], hp.Body.default(), small.scene(), progress=True
    ),
    "penetrating volume: 100%": lambda: _all(
        lambda: hp.metrics.penetrating_volume(
            small.motions()[0], hp.Body.default(), small.scene(), pitch=0.05
        )
    ),
    "distances to surfaces: 100%": lambda: _all(
        lambda: hp.metrics.floating(small.motions()[0], hp.Body.default(), small.scene())
    ),
    "heights: 100%": lambda: _all(lambda: small.motions()[0].grounded(hp.Body.default())),
    "labels of contact: ": lambda: _all(lambda: _labels(small.alone())),
    "supporting surfaces: 100%": lambda: _all(
        lambda: hp.support.estimate(small.motions()[0], small.scene())
    ),
}


def _all(work):
    with hp.progress():
        return work()


def _labels(result):
    from halfphysics.labels import contact_labels

    return contact_labels(result)


@pytest.mark.parametrize("words", STEPS)
def test_every_long_step_shows_one(monkeypatch, words):
    shown = at_once(monkeypatch)
    STEPS[words]()
    assert words in shown.getvalue()


def test_numbers_do_not_depend_on_it(monkeypatch):
    at_once(monkeypatch)
    with hp.progress():
        loud = hp.simulate(small.motions()[0], small.scene())
    quiet = hp.simulate(small.motions()[0], small.scene())
    assert np.array_equal(loud.motion.rotations, quiet.motion.rotations)

"""Charts of a result: the lines are the numbers, the axes have units, no display is needed."""

from __future__ import annotations

import os
import subprocess
import sys

import matplotlib

matplotlib.use("agg")

import numpy as np
import pytest
from matplotlib import pyplot

import halfphysics as hp
from support import small_results as small


@pytest.fixture(autouse=True)
def closed():
    yield
    pyplot.close("all")


def lines(axes):
    return {line.get_label(): np.asarray(line.get_ydata()) for line in axes.get_lines()}


def test_by_default_clearance_forces_and_offsets():
    figure = small.result().plot()
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["clearance [mm]", "contact force [N]", "offset [mm]"]
    assert [axes.get_xlabel() for axes in figure.axes] == ["", "", "time [s]"]
    for axes in figure.axes:
        assert axes.get_lines()[0].get_xdata()[-1] == pytest.approx(23 / 30.0, abs=1e-12)


def test_the_lines_are_the_numbers():
    result = small.result()
    clearance, forces, offsets = (lines(axes) for axes in result.plot().axes)
    assert np.array_equal(clearance["to statics"], 1000.0 * result.clearance)
    wall = np.zeros((len(result), 3))
    for k, frame in enumerate(result.contacts.frame):
        if result.contacts.person[k] == 0 and result.names[result.contacts.other[k]] == "wall":
            wall[frame] += 30.0 * result.contacts.impulse[k]
    sizes = np.sqrt((wall**2).sum(axis=1))
    assert np.abs(forces["person0: wall"] - sizes).max() < 1e-9 * sizes.max()
    body = result.people[1].body
    gap = body.joints(result.people[1].motion) - body.joints(result.people[1].recorded)
    distance = 1000.0 * np.sqrt((gap**2).sum(axis=2))
    assert np.abs(offsets["person1: mean of joints"] - distance.mean(axis=1)).max() < 1e-9
    assert np.abs(offsets["person1: largest"] - distance.max(axis=1)).max() < 1e-9


def test_a_pair_of_people_is_drawn_once():
    labels = set(lines(small.result().plot("forces").axes[0]))
    assert "person0: person1" in labels
    assert "person1: person0" not in labels


def test_one_person_is_not_named():
    labels = lines(small.alone().plot(["forces", "offsets"]).axes[1])
    assert set(labels) == {"mean of joints", "largest"}


def test_support_when_asked_for():
    result = small.alone()
    figure = result.plot("support")
    assert figure.axes[0].get_ylabel() == "support [% of weight]"
    drawn = lines(figure.axes[0])["supports"]
    assert np.array_equal(drawn, result.people[0].support.weight_percent)


def test_far_from_everything():
    """Where the clearance is beyond what is measured nothing is drawn, and it is said."""
    scene = hp.Scene()
    result = hp.simulate(small.motions()[0], scene, settings=hp.Settings(weight=False))
    axes = result.plot("clearance").axes[0]
    assert [text.get_text() for text in axes.texts] == ["farther than 50 mm in all frames"]


def test_into_axes_of_the_caller():
    figure, axes = pyplot.subplots(1, 2)
    found = small.alone().plot(("clearance", "offsets"), ax=axes)
    assert found is figure
    assert [one.get_ylabel() for one in axes] == ["clearance [mm]", "offset [mm]"]
    one = pyplot.figure().add_subplot()
    assert small.alone().plot("forces", ax=one) is one.figure


def test_wrong_arguments():
    result = small.alone()
    with pytest.raises(hp.errors.InputError, match=r"plot: found 'speed', expected some of clear"):
        result.plot("speed")
    for wrong in (None, 3, [["forces"]]):
        with pytest.raises(hp.errors.InputError, match=r"plot: found .*, expected some of clear"):
            result.plot(wrong)
    with pytest.raises(hp.errors.InputError, match=r"plot: found \(\), expected some of"):
        result.plot(())
    with pytest.raises(
        hp.errors.InputError, match=r"found 1 axis for 3 charts .*expected one each"
    ):
        result.plot(ax=pyplot.figure().add_subplot())
    with pytest.raises(hp.errors.InputError, match=r"plot: ax: found 3, expected axes"):
        result.plot("forces", ax=3)


def test_matplotlib_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot")
    with pytest.raises(hp.errors.MissingDependencyError, match=r"plots need matplotlib: pip inst"):
        small.alone().plot()


def test_nothing_is_imported_before():
    late = "matplotlib", "pandas", "xarray"
    code = f"import sys, halfphysics as hp; hp.Result; print(*{{*{late}}} & {{*sys.modules}})"
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ
    )
    assert found.stdout.split() == []


def test_a_notebook_shows_a_figure_once(monkeypatch):
    """What a cell returns is shown: it is closed for the notebook's own list of figures."""
    monkeypatch.setattr(pyplot, "get_backend", lambda: "module://matplotlib_inline.backend_inline")
    figure = small.alone().plot("clearance")
    assert not pyplot.fignum_exists(getattr(figure, "number", -1))
    figure.canvas.draw()

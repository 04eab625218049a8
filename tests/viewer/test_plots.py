"""Plots and numbers of the viewer: they agree with the result."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.viewer import plots
from halfphysics.viewer.contacts import NO_PERSON, OBJECT, SCENE
from halfphysics.viewer.numbers import Numbers, NumbersPanel
from halfphysics.viewer.plots import Line, Plots, aligned, clearance, force, items, speed
from support.results.small_result import FPS, FRAMES, small_result
from support.standing import ARMS_DOWN, raised, still

RESULT = small_result()
DURATION = (FRAMES - 1) / FPS


def test_clearance_is_in_millimetres_and_missing_where_unknown():
    (line,) = clearance([RESULT], ["a"])
    np.testing.assert_allclose(line.value[:-2], np.arange(FRAMES - 2))
    assert np.isnan(line.value[-2:]).all()
    np.testing.assert_allclose(line.time, np.arange(FRAMES) / FPS)


def test_force_adds_up_what_acts_on_people():
    (line,) = force([RESULT], ["a"])
    expected = np.full(FRAMES, 20.0 * FPS)
    expected[[6, 7, 10]] += np.array([3.0, 2.0, 1.0]) * FPS  # frame 12: contact of the ball only
    np.testing.assert_allclose(line.value, expected)


def test_speeds_of_body_ghost_and_objects():
    body, asked = speed([RESULT], ["a"], "pelvis")
    assert (body.dashed, asked.dashed) == (False, True)
    np.testing.assert_allclose(asked.value, 1.5, atol=1e-9)
    np.testing.assert_allclose(body.value[:4], 1.5, atol=1e-9)
    # 12 cm aside between two frames: half of it in each central difference.
    np.testing.assert_allclose(body.value[[5, 6]], np.hypot(1.5, 0.06 * FPS), atol=1e-9)
    (ball,) = speed([RESULT], ["a"], "ball")
    np.testing.assert_allclose(ball.value[-1], 4.0)
    assert ball.value[3] == 0.0
    assert items([RESULT]) == ["pelvis", "left hand", "right hand", "ball"]


@pytest.fixture(scope="module")
def held():
    """Who stands on a floor, and who is 0.3 m above it, held by nothing."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    standing = still(hp.Body.default(), ARMS_DOWN)
    settings = hp.Settings(weight=False)
    return [hp.simulate(raised(standing, up), scene, settings=settings) for up in (0.0, 0.3)]


def test_support_is_a_share_of_the_weight_and_a_warning_where_it_is_missing(held):
    carried, missing, not_carried, all_missing = plots.support(held, ["a", "b"])
    assert [line.warning for line in (carried, missing, not_carried, all_missing)] == [
        False, True, False, True,
    ]  # fmt: skip
    assert carried.value == pytest.approx(100.0, abs=1.0)
    assert np.isnan(missing.value).all()
    assert not_carried.value == pytest.approx(0.0, abs=1e-9)
    assert all_missing.value == pytest.approx(100.0, abs=1.0)
    # In the legend a warning occurs once, and only if there is one.
    assert plots._head("", [carried, all_missing, all_missing]).count("by nothing") == 1
    assert plots._head("", [carried, missing]).count("by nothing") == 0


def test_the_plot_and_the_numbers_of_support_come_when_asked(server, held):
    shown = Plots(server.gui, held, ["a", "b"], 19 / 60)
    assert not shown.has_support
    shown.add_support()
    assert shown.has_support
    shown.show(0.1)
    assert len(shown._cursors) == len(shown.charts) == 4
    assert all("0.3158" in cursor.content for cursor in shown._cursors)
    numbers = NumbersPanel(server.gui, held, ["a", "b"])
    numbers.show([3, 3])
    assert not any("Held up" in text.content for text in numbers.texts)
    numbers.add_support()
    numbers.show([3, 3])
    stands, hovers = (re.sub(r"<[^>]+>", " ", text.content) for text in numbers.texts)
    assert re.search(r"Held up +(99|100|101) % of 604 N +by floor +60\d N", stands)
    assert "by nothing" not in stands
    assert re.search(r"Held up +0 % of 604 N +by nothing, though needed +60\d N", hovers)


def test_several_results_are_several_lines_with_one_ghost():
    lines = speed([RESULT, RESULT], ["soft", "stiff"], "left hand")
    assert [line.label for line in lines] == ["soft", "reference", "stiff"]
    assert [line.dashed for line in lines] == [False, True, False]
    assert len(set(plots._colors(lines))) == 3
    other = SimpleNamespace(**{**vars(RESULT), "objects": {}})
    assert len(speed([RESULT, other], ["a", "b"], "ball")) == 1


def test_frames_are_plotted_as_they_are():
    line = Line(label="", time=np.arange(FRAMES) / FPS, value=np.arange(FRAMES) ** 2.0)
    time, value = aligned([line], DURATION)
    np.testing.assert_allclose(time, line.time)
    np.testing.assert_allclose(value, line.value)


def test_no_peak_is_lost_in_a_long_result():
    value = np.zeros(5000)
    value[1234] = 7.0
    line = Line(label="", time=np.arange(5000) / 120.0, value=value)
    time, shown = aligned([line], 4999 / 120.0)
    assert len(time) <= 600
    assert np.nanmax(shown) == 7.0
    assert time[np.nanargmax(shown)] == pytest.approx(1234 / 120.0, abs=0.05)


def test_lines_of_other_rates_share_the_axis_and_end_where_they_end():
    slow = Line(label="", time=np.arange(6) / 10.0, value=np.arange(6) * 2.0)
    gap = np.arange(61.0)
    gap[20:40] = np.nan
    quick = Line(label="", time=np.arange(61) / 60.0, value=gap)
    time, a, b = aligned([slow, quick], 1.0)
    inside = time <= 0.5
    np.testing.assert_allclose(a[inside], 20.0 * time[inside])
    assert np.isnan(a[time > 0.56]).all()
    np.testing.assert_allclose(b[:20], np.arange(20))
    assert np.isnan(b[20:40]).all()
    assert np.isfinite(b[40:]).all()


@pytest.fixture
def server():
    pytest.importorskip("viser")
    from halfphysics.viewer.server import close_server, open_server

    server = open_server("127.0.0.1", 0)
    yield server
    close_server(server)


def test_the_line_moves_and_the_plots_are_not_sent_again(server):
    shown = Plots(server.gui, [RESULT], ["a"], DURATION)
    data = {name: chart.data for name, chart in shown.charts.items()}
    assert list(data) == ["clearance", "force", "speed"]
    for time in (0.0, 0.2, DURATION, 9.0):
        shown.show(time)
        shares = {re.search(r"px \+ ([\d.]+)\*", c.content)[1] for c in shown._cursors}
        assert [float(s) for s in shares] == [pytest.approx(min(time / DURATION, 1.0), abs=1e-4)]
        assert all(len(c.content) < 320 for c in shown._cursors)
    assert all(chart.data is data[name] for name, chart in shown.charts.items())


def test_another_speed_is_chosen(server):
    shown = Plots(server.gui, [RESULT], ["a"], DURATION)
    assert "reference" in shown.heads["speed"].content
    shown._choose("ball")
    chart = shown.charts["speed"]
    assert len(chart.data) == len(chart.series) == 2
    assert chart.data[1][-1] == pytest.approx(4.0)
    assert chart.scales["y"]["range"][1] >= 4.0
    assert "Speed of ball [m/s]" in shown.heads["speed"].content


def test_numbers_name_contacts_with_their_forces_strongest_first():
    numbers = Numbers(RESULT)
    assert numbers.contacts(10) == [
        ("right foot", "floor", pytest.approx(20.0 * FPS), SCENE),
        ("right foot", "ball", pytest.approx(1.0 * FPS), OBJECT),
    ]
    assert numbers.contacts(12)[1] == ("ball", "bench", pytest.approx(0.5 * FPS), NO_PERSON)
    ((name, mean, _, most),) = numbers.deviation(8)
    assert (name, mean, most) == ("person", pytest.approx(120.0), pytest.approx(120.0))
    text = re.sub(r"<[^>]+>", " ", numbers.html(10))
    for part in ("frame 10 of 15, 0.33 s", "10.0 mm", "Contacts: 2", "630 N", "120 mm"):
        assert part in text
    assert "over 50 mm" in numbers.html(FRAMES - 1)


def test_numbers_do_not_run_what_names_say():
    result = SimpleNamespace(**{**vars(RESULT), "names": ("<img src=x>", *RESULT.names[1:])})
    assert "<img" not in Numbers(result, "<b>x").html(0)
    assert "&lt;img" in Numbers(result).html(0)

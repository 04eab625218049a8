"""The playground in a real browser: it loads, plays, obeys its controls, a ball is dragged."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import OWN, Catalog, Choice
from halfphysics.viewer.framing import free_part
from halfphysics.viewer.playground import Playground
from support.browser import CHROMIUM, SIZES, artefacts, tab

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]

BUTTON = "button:has-text('Pause'), button:has-text('Play')"
# A fast kick: the ball is met soon after the start.
KICK = Choice("kick_ball", OWN, {"speed": 9.0})
ROWS = (
    "Scenario",
    "Motion",
    "Also",
    "Play at [×]",
    "Loop",
    "Hold the pose",
    "Mass [kg]",
    "Friction",
)


@pytest.fixture(scope="module")
def playground():
    with Playground(Catalog(), KICK, port=0) as running:
        running.post(do.Change("loop", False))
        yield running
        assert running._failure is None


@pytest.fixture(scope="module", params=["desktop", "phone"])
def page(request, playground, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    stand(playground)
    with tab(folder, SIZES[request.param]) as one:
        one.name = request.param
        one.kept = artefacts(folder)
        one.open(playground.url)
        one.page.wait_for_selector(BUTTON, timeout=60_000)
        # A message that it draws in software, only in tests.
        one.page.wait_for_timeout(1000)
        if one.page.locator("[role=alert] button").count():
            one.page.locator("[role=alert] button").first.click()
        see_everything(playground)
        one.until(lambda: len(ball(scene(one))) > 3)
        if request.param == "phone":  # the panel is a sheet that is folded at first
            one.page.click("text='halfphysics play'")
            one.until(lambda: one.box("text='halfphysics play'")[1] < 0.5 * SIZES["phone"][1])
        yield one
        # The browser's message about a wheel over viser's own dropdowns, not ours.
        assert [e for e in one.errors if "passive event listener" not in e] == []


def see_everything(playground):
    """The ball is too far away for the first view, which has the person at half of the height."""

    def everything():
        for client in playground.server.get_clients().values():
            playground.cameras.everything(client)

    playground.do(everything)


def stand(playground):
    """At the start, as in the scenario, paused."""
    for command in (do.Untouched(), do.Change("frozen", False), do.Play(False), do.Restart()):
        playground.post(command)


def scene(page):
    """The part of the picture that the panel does not cover."""
    page.page.wait_for_timeout(200)
    width, height = map(int, free_part(*SIZES[page.name]))
    bar, sheet = int(page.box("#hp-bar")[1]), int(page.box("text='halfphysics play'")[1]) - 20
    return page.picture()[: min(height, bar, sheet if page.name == "phone" else bar), :width]


def ball(picture):
    """Pixels (n, 2) of the orange ball, x before y."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    # Skin has less orange.
    return np.argwhere((red > 130) & (red - blue > 110) & (red - green > 40))[:, ::-1]


def number(page, label):
    """The number box of a slider."""
    row = page.page.locator(f"div:has(> div label:text-is('{label}'))").last
    return row.locator("input[inputmode=decimal]")


def once(page):
    """Features that do not depend on the window's shape are tested once."""
    if page.name == "phone":
        pytest.skip("seen at a desk")


def played(page, playground, frames):
    """Let the page play so many frames."""
    page.page.click(BUTTON)
    page.until(lambda: playground.session.made >= frames)
    page.page.click(BUTTON)
    page.until(lambda: not playground.session.playing)


def test_it_says_what_it_does_and_nothing_overlaps(page, playground):
    page.screenshot(page.kept / f"play-{page.name}.png", whole=False)
    assert page.picture().std() > 5.0
    text = page.page.inner_text("body")
    for words in ("halfphysics play", "0.00 s", "ms a frame: physics", "sending", "Paused"):
        assert words in text
    width, height = SIZES[page.name]
    spans = []
    for row in ROWS:
        left, top, right, bottom = page.box(f"label:text-is('{row}'), p:text-is('{row}')")
        assert 0 <= left < right <= width
        assert 0 <= top < bottom <= height
        spans.append((top, bottom))
    for (_, bottom), (top, _) in pairwise(spans):
        assert top >= bottom - 1.0
    left, top, _, _ = page.box("text='halfphysics play'")
    free = free_part(width, height)
    # The sheet of a phone is unfolded here, and leaves two fifths of the scene.
    assert left >= free[0] - 45 if page.name == "desktop" else top >= 0.3 * height


def test_everybody_is_in_the_free_part_of_the_window(page, playground):
    picture = scene(page)
    red, _, blue = np.moveaxis(picture, -1, 0)
    person = np.argwhere((red - blue > 25) & (red - blue < 120))  # bare skin
    assert len(person) > 40
    assert person[:, 1].min() > 2
    if page.name == "desktop":  # the unfolded sheet of a phone covers the ball
        assert len(ball(picture)) > 3


def test_play_moves_the_body_and_pause_stops_it(page, playground):
    once(page)
    before = scene(page)
    played(page, playground, 30)
    after = scene(page)
    assert (np.abs(after - before).max(axis=-1) > 25).sum() > 60
    text = page.page.inner_text("body")
    assert "Paused" in text
    assert f"{playground.session.index / playground.session.fps:.2f} s" in text
    still = playground.session.made
    page.page.wait_for_timeout(500)
    assert playground.session.made == still
    page.page.click("button:has-text('One frame')")
    page.until(lambda: playground.session.made == still + 1)
    page.page.click("button:has-text('Start again')")
    page.until(lambda: playground.session.made == 0)


def test_a_slider_changes_the_outcome(page, playground):
    once(page)
    session = playground.session
    playground.post(do.Change("speed", 4.0))
    far = {}
    for mass in ("0.43", "200"):
        stand(playground)
        page.until(lambda: session.made == 0 and not session.playing)
        start = session.frame.objects["ball"][0]
        number(page, "Mass [kg]").fill(mass)
        number(page, "Mass [kg]").press("Enter")
        page.until(
            lambda mass=mass: session.simulator.world.scene.objects["ball"].mass == float(mass)
        )
        played(page, playground, session.frames - 1)
        far[mass] = np.linalg.norm(session.frame.objects["ball"][0] - start)
        page.screenshot(page.kept / f"play-{page.name}-{mass}.png", whole=False)
    assert far["0.43"] > 3.0
    assert far["200"] < 0.1 * far["0.43"]
    playground.post(do.Change("speed", 1.0))


def test_the_ball_is_dragged_with_the_mouse_and_keeps_going(page, playground):
    once(page)
    session, mouse = playground.session, page.page.mouse
    stand(playground)
    playground.post(do.Change("frozen", True))
    playground.post(do.Play())
    page.until(lambda: session.made > 3)
    page.page.wait_for_timeout(1000)
    start = session.frame.objects["ball"][0]
    x, y = np.median(ball(scene(page)), axis=0)
    mouse.move(x, y)
    page.page.wait_for_timeout(700)
    mouse.down()
    for step in range(1, 9):
        mouse.move(x - 4 * step, y - 6 * step)
        page.page.wait_for_timeout(150)
    page.until(lambda: session.drags)
    page.until(lambda: session.frame.objects["ball"][0][2] > start[2] + 0.15)
    page.page.wait_for_timeout(1500)
    page.screenshot(page.kept / f"play-{page.name}-drag.png", whole=False)
    mouse.up()
    page.until(lambda: not session.drags)
    page.until(lambda: session.frame.objects["ball"][0][2] < start[2] + 0.02)
    assert np.linalg.norm(session.frame.objects["ball"][0] - start) > 0.1
    playground.post(do.Change("frozen", False))


def test_another_scenario_from_the_page_and_a_second_browser_that_leaves(
    page, playground, tmp_path_factory
):
    once(page)
    stand(playground)
    page.page.get_by_role("combobox", name="Scenario").click()
    page.page.locator("[role=option]:visible:has-text('doorway')").first.click()
    page.until(lambda: playground.session.choice == Choice("doorway"))
    page.until(lambda: "Right jamb" in page.page.inner_text("body"))
    page.page.wait_for_timeout(3000)
    page.screenshot(page.kept / f"play-{page.name}-doorway.png", whole=False)
    other = page.page.context.new_page()
    other.goto(playground.url)
    other.wait_for_selector(BUTTON, timeout=60_000)
    page.until(lambda: len(playground.server.get_clients()) == 2)
    other.close()
    page.until(lambda: len(playground.server.get_clients()) == 1)
    played(page, playground, 10)
    playground.post(do.Choose(KICK))
    page.until(lambda: playground.session.choice == KICK)

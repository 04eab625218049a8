"""The page with physics in a real browser, from its file: the core's own numbers, drags, knobs."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.viewer.play_page import save_play_page
from support.browser import CHROMIUM, SIZES, Tab, artefacts, tab

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]

#: Frames of the kick: the ball has been kicked by then.
FRAMES = 110
#: Largest difference of any joint or object from `hp.simulate` [m], and of quaternions. The state
#: of the core is the same to the bit; joints are compared here, which are made of rotation vectors.
SAME = 1e-12
#: Of the simulation on one core, also beside other work.
LEAST_RATE = 30.0


@pytest.fixture(scope="module")
def story():
    found = scenarios.load("kick_ball")
    return dataclasses.replace(found, motion=found.motion[:FRAMES])


@pytest.fixture(scope="module", params=["desktop", "phone"])
def page(request, story, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    path = save_play_page(story, folder / "kick.html", title="A kick")
    size = {"desktop": (840, 560), "phone": SIZES["phone"]}[request.param]
    with tab(folder, size) as one:
        one.page.set_default_timeout(60_000)
        one.open(path)
        one.until(lambda: one.evaluate("Boolean(window.halfphysics?.physics.made > 2)"))
        one.quiet()
        one.name, one.kept = request.param, artefacts(folder)
        yield one
        assert one.errors == []
        outside = [r for r in one.requests if not r.startswith(("file:", "data:", "blob:"))]
        assert outside == []


def ask(page, script):
    return page.evaluate(f"(() => {{ const {{ physics, pointer }} = halfphysics; {script} }})()")


def once(page):
    if page.name == "phone":
        pytest.skip("seen at a desk")


def settled(page):
    page.evaluate(
        "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => "
        "requestAnimationFrame(done))))"
    )


def simulated(page, frames):
    """Places and turns of all bodies, made by the page from the start (frames - 1, bodies, 7)."""
    made = ask(
        page,
        "physics.playing = false; physics.loop = false; physics.own(); physics.restart();"
        "const all = []; while (physics.index < physics.frames - 1) { physics.make();"
        "all.push([...physics.bodies]); } return all;",
    )
    return np.array(made).reshape(frames - 1, -1, 7)


def assert_as_simulate(found, story, name):
    result = hp.simulate(story.motion, story.scene, body=story.body, settings=story.settings)
    places, turns = story.body.joint_frames(result.motion)
    thing = result.objects[name]
    np.testing.assert_allclose(found[:, :55, :3], places[1:], rtol=0, atol=SAME)
    np.testing.assert_allclose(found[:, 55, :3], thing.position[1:], rtol=0, atol=SAME)
    # A quaternion and its negative are one rotation.
    along = np.abs(np.einsum("tjk,tjk->tj", found[:, :55, 3:], turns[1:]))
    np.testing.assert_allclose(along, 1.0, rtol=0, atol=SAME)
    assert np.linalg.norm(thing.position[-1] - thing.position[0]) > 0.3  # it was moved


def test_the_numbers_are_those_of_simulate(page, story):
    once(page)
    assert_as_simulate(simulated(page, FRAMES), story, "ball")


def test_the_lift_has_the_numbers_of_simulate_at_thirty_frames_a_second(page, tmp_path):
    """Both hands press on the suitcase all the time: the smallest difference would grow."""
    once(page)
    story = scenarios.load("lift_suitcase")
    story = dataclasses.replace(story, motion=story.motion[:FRAMES])
    path = save_play_page(story, tmp_path / "lift.html")
    other = Tab(page.page.context.new_page())
    try:
        other.open(path)
        other.until(lambda: other.evaluate("Boolean(window.halfphysics?.physics.made > 2)"))
        assert_as_simulate(simulated(other, FRAMES), story, "suitcase")
        assert rate_of(other) > LEAST_RATE
        assert other.errors == []
    finally:
        other.page.close()


def rate_of(page):
    """Frames per second of the simulation alone; drawn are few of them."""
    rate = ask(
        page,
        "physics.playing = false; physics.restart(); const start = performance.now();"
        "while (physics.index < physics.frames - 1) physics.make();"
        "return 1000 * (physics.frames - 1) / (performance.now() - start);",
    )
    print(f"{rate:.0f} frames/s")
    return rate


def test_it_simulates_thirty_frames_a_second(page):
    once(page)
    assert rate_of(page) > LEAST_RATE


def test_the_bones_follow_the_core(page):
    once(page)
    ask(page, "physics.playing = false; physics.restart();")
    ask(page, "for (let k = 0; k < 30; k++) physics.make();")
    settled(page)
    wanted = ask(page, "return physics.place(physics.play.objects[0])[0];")
    shown = page.evaluate("__viserMutable.nodeRefFromName['/object/ball'].position.toArray()")
    np.testing.assert_allclose(shown, wanted, atol=1e-6)


def test_the_ball_is_dragged_by_the_pointer(page):
    ask(page, "physics.loop = false; physics.restart(); physics.hold = physics.playing = true;")
    # The camera looks at the ball.
    page.evaluate(
        "(() => { const { physics, cameras } = halfphysics; const [p] = "
        "physics.place(physics.play.objects[0]); cameras.following = false;"
        "cameras.look([[p[0] + 2, p[1] + 2, 1.2], p], 1); })()"
    )
    settled(page)
    x, y = page.evaluate(
        "(() => { const box = __viserMutable.canvas.getBoundingClientRect();"
        "return [box.left + box.width / 2, box.top + box.height / 2]; })()"
    )
    start = ask(page, "return physics.place(physics.play.objects[0])[0];")
    mouse = page.page.mouse
    mouse.move(x, y)
    mouse.down()
    assert ask(page, "return pointer.drag && pointer.drag.object.name;") == "ball"
    mouse.move(x, y - 160, steps=4)
    page.until(
        lambda: ask(page, "return physics.place(physics.play.objects[0])[0];")[2] > start[2] + 0.2
    )
    if page.name == "desktop":
        page.page.screenshot(path=page.kept / "play-drag.png")
    mouse.up()
    assert ask(page, "return pointer.drag;") is None
    page.until(
        lambda: ask(page, "return physics.place(physics.play.objects[0])[0];")[2] < start[2] + 0.05
    )
    ask(page, "physics.hold = false; physics.loop = true;")


def test_knobs_change_the_core_and_are_taken_back(page):
    if page.name == "phone":
        page.page.locator("#hp-handle").click()
    page.page.locator("[aria-label='Mass']").evaluate(
        "(input) => { input.value = Math.log(20); input.dispatchEvent(new Event('input')); }"
    )
    assert ask(page, "return physics.world.mass('ball');") == pytest.approx(20.0, rel=1e-3)
    page.page.locator("[aria-label^='Stiffness']").evaluate(
        "(input) => { input.value = 0.2; input.dispatchEvent(new Event('input')); }"
    )
    assert ask(page, "return physics.turned.stiffness;") == 0.2
    page.page.screenshot(path=page.kept / f"play-knobs-{page.name}.png")
    page.page.get_by_text("As it was").click()
    assert ask(page, "return physics.world.mass('ball');") == pytest.approx(0.43, rel=1e-12)
    assert ask(page, "return physics.turned.stiffness;") is None
    ask(page, "physics.playing = false;")
    page.page.get_by_text("Start again").click()
    assert ask(page, "return physics.index;") < 10


def test_a_heavy_ball_stays(page):
    """Twenty kilograms: the foot gives way, and the ball rolls a fraction as far."""
    once(page)
    run = (
        "physics.playing = false; physics.loop = false; physics.restart();"
        "while (physics.index < physics.frames - 1) physics.make();"
        "return physics.place(physics.play.objects[0])[0];"
    )
    light = ask(page, run)
    heavy = ask(page, f"physics.turn('mass', 200, physics.play.objects[0]); {run}")
    start = scenarios.load("kick_ball").scene.objects["ball"].position
    again = ask(page, f"physics.own(); {run}")
    assert np.linalg.norm(np.array(heavy) - start) < 0.5 * np.linalg.norm(np.array(light) - start)
    np.testing.assert_array_equal(again, light)


def test_keys(page):
    once(page)
    press = page.page.keyboard.press
    ask(page, "physics.playing = true;")
    press(" ")
    assert not ask(page, "return physics.playing;")
    press("Home")
    assert ask(page, "return physics.index;") == 0
    press("ArrowRight")
    assert ask(page, "return physics.index;") == 1
    press("ArrowLeft")
    assert "cannot go back" in page.page.text_content("#hp-said")


def test_the_loop_waits_for_the_pointer(page):
    """A world that starts anew would pull what is held across the scene."""
    once(page)
    ask(
        page,
        "physics.loop = true; physics.hold = false; physics.playing = false; physics.restart();",
    )
    ask(page, "while (physics.index < physics.frames - 1) physics.make();")
    held = (
        "const [ball] = physics.play.objects; const [place] = physics.place(ball);"
        "pointer.drag = { id: 9, object: ball, grip: place, pointer: place, offset: [0, 0, 0],"
        "normal: [1, 0, 0] };"
    )
    ask(page, held)
    made = ask(page, "const before = physics.made; physics.make(); return physics.made - before;")
    assert made == 1
    assert ask(page, "return physics.index;") == FRAMES - 1
    ask(page, "pointer.drag = null; physics.make();")
    assert ask(page, "return physics.index;") == 0


def test_time_that_a_hidden_tab_missed_is_not_caught_up(page):
    once(page)
    ask(page, "physics.playing = false; physics.restart(); physics.tick();")
    made = ask(
        page,
        "physics.playing = true; physics.tick(); const before = physics.made;"
        "physics.ended -= 60000; physics.due -= 60000; physics.tick();"
        "physics.playing = false; return physics.made - before;",
    )
    assert made == 1


def test_keys_after_the_speed_and_a_slider_were_used(page):
    once(page)
    press = page.page.keyboard.press
    page.page.select_option("#hp-speed", "0.5")
    assert ask(page, "return physics.speed;") == 0.5
    playing = ask(page, "return physics.playing;")
    press(" ")
    assert ask(page, "return physics.playing;") is not playing
    slider = page.page.locator("[aria-label^='Stiffness']")
    slider.focus()
    press(" ")
    assert ask(page, "return physics.playing;") is playing
    before = ask(page, "return physics.turned.stiffness;")
    press("ArrowRight")  # the slider's own
    assert ask(page, "return physics.turned.stiffness;") != before
    # A key that is held repeats itself; it is one press.
    page.page.locator("#hp-bar").click(position={"x": 2, "y": 2})
    page.page.keyboard.down(" ")
    page.page.keyboard.down(" ")
    page.page.keyboard.down(" ")
    page.page.keyboard.up(" ")
    assert ask(page, "return physics.playing;") is not playing
    page.page.select_option("#hp-speed", "1")
    ask(page, "physics.own();")


def test_a_light_thing_is_shown_with_its_mass(page, tmp_path, story):
    once(page)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.02), mass=0.0027, position=(1.0, 0.0, 0.02))
    path = save_play_page(dataclasses.replace(story, scene=scene), tmp_path / "light.html")
    other = Tab(page.page.context.new_page())
    try:
        other.open(path)
        other.until(lambda: other.evaluate("Boolean(window.halfphysics?.physics.made > 2)"))
        knob = other.page.locator(".hp-knob", has=other.page.locator("[aria-label='Mass']"))
        assert knob.locator("output").inner_text() == "0.0027 kg"
        assert ask(other, "return halfphysics.knobs.mass.value;") == pytest.approx(0.0027)
    finally:
        other.page.close()


def test_the_pointer_takes_a_thing_where_it_is_seen(page):
    once(page)
    ask(page, "physics.playing = false; physics.restart();")
    page.evaluate(
        "(() => { const { physics, cameras } = halfphysics; const [p] = "
        "physics.place(physics.play.objects[0]); cameras.following = false;"
        "cameras.look([[p[0] + 0.6, p[1], p[2] + 0.1], p], 1); })()"
    )
    settled(page)
    grips = ask(
        page,
        "const box = __viserMutable.canvas.getBoundingClientRect();"
        "const [place] = physics.place(physics.play.objects[0]);"
        "return [[0, 0], [60, 0], [0, -60], [-50, 40], [380, 0], [0, 250]].map(([x, y]) => {"
        "const found = pointer.under({ clientX: box.left + box.width / 2 + x,"
        "clientY: box.top + box.height / 2 + y });"
        "return found && Math.hypot(...found.grip.map((one, k) => one - place[k])); });",
    )
    # On the ball's skin, which is drawn as a mesh; beside it nothing is.
    np.testing.assert_allclose(np.array(grips[:4], dtype=float), 0.11, rtol=0.03)
    assert grips[4:] == [None, None]

"""The one-file page in a real browser, from its file: keys, marks, layers, comparison, drops."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.viewer.page import save_page
from support.browser import CHROMIUM, SIZES, artefacts, tab
from support.people import along_x
from support.results.small_result import FPS, FRAMES, touched_result

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]

# Small: a browser that draws in software is slow.
WINDOWS = {"desktop": (840, 560), "phone": SIZES["phone"]}
END = (FRAMES - 1) / FPS


@pytest.fixture(scope="module")
def story(tmp_path_factory):
    result = touched_result()
    return save_page(result, tmp_path_factory.mktemp("page") / "story.html", title="A walk")


@pytest.fixture(scope="module", params=["desktop", "phone"])
def page(request, story, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    with tab(folder, WINDOWS[request.param]) as one:
        one.page.set_default_timeout(60_000)  # a browser that draws in software is slow
        one.open(story)
        one.until(
            lambda: one.evaluate("Boolean(window.halfphysics && halfphysics.reel.shown >= 0)")
        )
        one.quiet()
        one.name, one.width, one.height = request.param, *WINDOWS[request.param]
        one.kept = artefacts(folder)
        yield one
        assert one.errors == []
        # Only the page itself was requested.
        outside = [r for r in one.requests if not r.startswith(("file:", "data:", "blob:"))]
        assert outside == []
        assert {r.split("?")[0] for r in one.requests if r.startswith("file:")} == {story.as_uri()}


def at(page, time):
    """Pause at a time [s], and wait until the scene is drawn so."""
    page.evaluate(f"halfphysics.clock.playing = false; halfphysics.clock.seek({time})")
    settled(page)


def settled(page):
    """Wait until the last change is drawn: two frames after it."""
    page.evaluate(
        "new Promise((done) => { __viserMutable.requestRender(); requestAnimationFrame(() => "
        "requestAnimationFrame(() => requestAnimationFrame(done))); })"
    )


def clock(page, what="shown"):
    return page.evaluate(f"halfphysics.clock.{what}")


def frame(page):
    return page.evaluate("halfphysics.reel.shown")


def layer(page, name, on):
    """Show or hide a layer as its checkbox does."""
    page.evaluate(
        f"const box = document.querySelector('[data-layer={name}]'); "
        f"if (box.checked !== {str(on).lower()}) box.click()"
    )
    settled(page)


def drawn(page, name):
    """The pixels of the scene that a layer changes (height, width)."""
    shown = page.picture()
    layer(page, name, False)
    hidden = page.picture()
    layer(page, name, True)
    changed = np.abs(shown - hidden).max(axis=-1) > 12
    if page.name == "desktop":
        changed[:, : int(page.box("#hp-panel")[2])] = False  # the checkbox itself
    return changed[: int(page.box("#hp-bar")[1])]


def once(page):
    if page.name == "phone":
        pytest.skip("seen at a desk")


def test_the_figure_fills_half_of_the_first_picture(page):
    at(page, 0.0)
    page.page.keyboard.press("0")
    height = page.height - (page.height - page.box("#hp-bar")[1])
    for _ in range(20):  # the camera glides; a busy machine draws few pictures of it
        settled(page)
        rows, columns = np.nonzero(drawn(page, "body"))
        share = np.ptp(np.quantile(rows, [0.002, 0.998])) / height
        if share < 0.8:
            break
    page.page.screenshot(path=page.kept / f"page-{page.name}.png")
    least = 0.46 if page.name == "desktop" else 0.4  # on a phone the width may decide
    assert least < share < 0.8
    middle = np.median(columns) / page.width
    assert 0.35 < middle < 0.65


def test_the_parts_of_the_page_do_not_overlap(page):
    boxes = [page.box(s) for s in ("#hp-buttons", "#hp-time", "#hp-right")]
    track = page.box("#hp-track")
    for left, top, right, bottom in [*boxes, track]:
        assert 0 <= left < right <= page.width
        assert 0 <= top < bottom <= page.height
    for one, other in itertools.pairwise(boxes):
        assert one[2] <= other[0]
    panel, bar = page.box("#hp-panel"), page.box("#hp-bar")
    assert panel[3] <= bar[1] + 1
    assert bar[3] == page.height


def test_the_sheet_of_a_phone_unfolds_and_folds(page):
    handle, inside = page.page.locator("#hp-handle"), page.page.locator("#hp-folded")
    narrow = page.name == "phone"
    assert inside.is_visible() is not narrow
    handle.click()
    assert inside.is_visible() is narrow
    if narrow:
        page.page.screenshot(path=page.kept / "page-phone-sheet.png")
        top = page.box("#hp-panel")[1]
        assert top > 0.4 * page.height  # it leaves the figure's head free
    handle.click()
    assert inside.is_visible() is not narrow


def test_keys_of_the_clock(page):
    once(page)
    press = page.page.keyboard.press
    at(page, 0.0)
    press(" ")
    page.until(lambda: clock(page, "playing"))
    page.until(lambda: clock(page) > 0.0)
    press(" ")
    assert not clock(page, "playing")
    for key, shown in (
        ("Home", 0), ("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("Home", 0),
        ("End", FRAMES - 1), ("ArrowRight", 0),  # around
    ):  # fmt: skip
        press(key)
        page.until(lambda shown=shown: frame(page) == shown)
    now = page.page.locator("#hp-track").get_attribute("aria-valuenow")
    assert float(now) == pytest.approx(0.0, abs=1e-3)


def test_keys_of_cameras_follow_and_help(page):
    once(page)
    press = page.page.keyboard.press
    at(page, 0.2)

    def seen():
        """The direction from the people to the camera, in viser's world."""
        return page.evaluate(
            "(() => { const c = __viserMutable.cameraControl, v = __viserMutable.camera.position; "
            "const root = __viserMutable.nodeRefFromName['']; "
            "const p = root.worldToLocal(c.getPosition(v.clone())).toArray(); "
            "const t = root.worldToLocal(c.getTarget(v.clone())).toArray(); "
            "return p.map((x, k) => x - t[k]); })()"
        )

    # The person walks along x: front is +x, their left +y.
    for key, axis in (("1", 0), ("2", 1), ("3", 2)):
        press(key)
        settled(page)
        way = np.array(seen())
        assert way[axis] / np.linalg.norm(way) > 0.95, key
    whole = np.linalg.norm(seen())
    press("4")
    settled(page)
    assert np.linalg.norm(seen()) < 0.8 * whole  # hands are smaller
    before = page.evaluate("halfphysics.cameras.following")
    press("f")
    assert page.evaluate("halfphysics.cameras.following") is not before
    press("f")
    press("?")
    assert "Play or pause" in page.page.inner_text("#hp-help")
    press("Escape")
    assert not page.page.locator("#hp-help").is_visible()
    press("0")
    settled(page)


def test_marks_are_hovered_and_clicked(page):
    at(page, 0.0)
    rows = page.page.locator(".hp-row")
    assert [rows.nth(k).get_attribute("aria-label") for k in range(rows.count())] == [
        "contact with the scene", "contact with an object", "contact of objects",
    ]  # fmt: skip
    left, top, right, bottom = page.box(".hp-row:nth-child(2) .hp-mark")
    track = page.box("#hp-track")
    share = (0.5 * (left + right) - track[0]) / (track[2] - track[0])
    assert share == pytest.approx(9.5 / (FRAMES - 1), abs=0.02)
    page.page.mouse.move(0.5 * (left + right), 0.5 * (top + bottom))
    assert "right foot – ball 30 N" in page.page.inner_text("#hp-tip")
    page.page.mouse.click(track[0] + 0.6 * (track[2] - track[0]), 0.5 * (track[1] + track[3]))
    page.until(lambda: clock(page) == pytest.approx(0.6 * END, abs=0.01))
    page.page.mouse.move(10, 300)
    assert not page.page.locator("#hp-tip").is_visible()


def test_each_layer_is_hidden_by_its_box(page):
    once(page)
    at(page, 12 / FPS)  # body and ghost are apart, the ball is in contact
    for name, least in (("body", 1500), ("ghost", 500), ("objects", 100), ("scene", 1500)):
        assert drawn(page, name).sum() > least, name
    visible = "__viserMutable.nodeRefFromName['/contact/{}'].visible"
    for name, node in (("arrows", "arrow"), ("points", "point")):
        layer(page, name, False)
        assert not page.evaluate(visible.format(node))
        layer(page, name, True)
        assert page.evaluate(visible.format(node))


def test_the_skin_is_coloured_by_force(page):
    once(page)
    at(page, 6 / FPS)
    lit = """(() => {
      let most = 0;
      __viserMutable.nodeRefFromName["/person/0"].traverse((part) => {
        const color = part.isSkinnedMesh && part.geometry.getAttribute("color");
        if (!color) return;
        for (let k = 0; k < color.array.length; k += 3) {
          most += Math.abs(color.array[k + 2] - 1) > 0.05;
        }
      });
      return most;
    })()"""
    page.until(lambda: page.evaluate(lit) > 20)
    count = page.evaluate(lit)
    assert count < 2000  # some skin, not the person
    assert drawn(page, "skin").sum() > 10
    layer(page, "skin", False)
    page.until(lambda: page.evaluate(lit) == 0)
    layer(page, "skin", True)
    page.until(lambda: page.evaluate(lit) == count)


def test_the_slider_parts_reference_and_simulated(page):
    at(page, END)
    layer(page, "ghost", False)
    page.page.keyboard.press("c")
    assert page.page.locator("#hp-line").is_visible()
    labels = page.page.locator("#hp-line span")
    assert labels.all_inner_texts() == ["reference", "simulated"]
    pictures = {}
    for name, share in (("simulated", 0.03), ("reference", 0.97)):
        left, top, right, bottom = page.box("#hp-line")
        y = top + 0.7 * (bottom - top)
        page.page.mouse.move(0.5 * (left + right), y)
        page.page.mouse.down()
        page.page.mouse.move(share * page.width, y, steps=3)
        page.page.mouse.up()
        settled(page)
        pictures[name] = page.picture()
    assert page.evaluate("halfphysics.compare.share") == pytest.approx(0.97, abs=0.01)
    # They are 12 cm apart: what is drawn in one half is not in the other.
    changed = np.abs(pictures["simulated"] - pictures["reference"]).max(axis=-1) > 25
    assert changed.sum() > 500
    page.page.keyboard.press("c")
    settled(page)
    assert not page.page.locator("#hp-line").is_visible()
    layer(page, "ghost", True)


def test_dropped_files_are_shown_or_refused_in_a_sentence(page, tmp_path):
    once(page)
    said = page.page.locator("#hp-said")
    (tmp_path / "notes.txt").write_text("nothing")
    (tmp_path / "broken.npz").write_bytes(b"PK nothing")
    (tmp_path / "page.html").write_text("<script>__VISER_EMBED_DATA__</script>")
    address = page.page.url
    for name, why in (
        ("notes.txt", "it is no .npz"),
        ("broken.npz", "it is cut off"),
        ("page.html", "a page is opened in a tab of its own"),
    ):
        page.drop(tmp_path / name)
        page.until(lambda name=name: said.inner_text().startswith(f"{name} is not shown"))
        assert why in said.inner_text()
    assert page.page.url == address  # its scripts did not run
    at(page, 0.0)
    before = page.picture()
    walk = along_x(1.0, 31, -0.5, z=1.0)
    walk.save(tmp_path / "walk.npz")
    page.drop(tmp_path / "walk.npz")
    page.until(lambda: "a person more" in said.inner_text())
    page.until(lambda: page.evaluate("Boolean(__viserMutable.nodeRefFromName['/dropped/0'])"))
    page.until(lambda: (np.abs(page.picture() - before).max(axis=-1) > 25).sum() > 700)
    # The page lasts as long as the longest, and the dropped person is where the motion says.
    page.until(lambda: clock(page, "duration") == pytest.approx(1.0))
    at(page, 1.0)
    bones = page.evaluate(
        "__viserMutable.skinnedMeshState[Object.keys(__viserMutable.skinnedMeshState)"
        ".find((key) => key.includes('/dropped/0'))].poses.map((pose) => pose.position)"
    )
    aside = page.evaluate("halfphysics.drops.people[0].offset")
    joints = touched_result().people[0].body.joints(walk)[-1]
    np.testing.assert_allclose(np.array(bones) - aside, joints, atol=1e-4)
    page.page.screenshot(path=page.kept / "page-dropped.png")


def test_a_dropped_result_of_a_y_up_file_stands_where_it_says(page, tmp_path):
    once(page)
    place = np.linspace([0.0, 1.35, 0.0], [0.3, 1.35, 0.5], 16)
    motion = hp.Motion.from_smplx(
        fps=30, global_orient=np.zeros((16, 3)), transl=place, body_pose=np.zeros((16, 63)), up="y"
    )
    result = hp.simulate(motion, settings=hp.Settings.paper())
    result.save(tmp_path / "turned.npz")
    count = page.evaluate("halfphysics.drops.people.length")
    page.drop(tmp_path / "turned.npz")
    page.until(lambda: page.evaluate("halfphysics.drops.people.length") == count + 1)
    found = page.evaluate(f"halfphysics.drops.people[{count}].pelvis(15)")
    aside = page.evaluate(f"halfphysics.drops.people[{count}].offset")
    wanted = result.people[0].body.joints(result.people[0].motion)[15, 0]
    np.testing.assert_allclose(np.array(found) - aside, wanted, atol=1e-4)


def test_a_page_opens_in_the_systems_colours(page):
    once(page)
    page.size(page.width, page.height, dark=True)
    page.page.reload()
    page.until(lambda: page.evaluate("Boolean(window.halfphysics && halfphysics.reel.shown >= 0)"))
    assert page.page.title() == "A walk"
    assert page.picture()[-3:].mean() < 60.0  # the bar

"""Cameras of the viewer: presets see their subjects, following keeps angle and distance."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.render.rasterizer import Camera
from halfphysics.render.viewpoint import FOV
from halfphysics.viewer.camera import PRESETS, Cameras, Follower
from halfphysics.viewer.framing import on_people
from support.results.small_result import small_result

DESKTOP, PHONE = (1280, 800), (390, 844)
STEP = 1.0 / 30.0


def on_screen(camera, points, size):
    """Pixels (n, 2) of world points in a window."""
    right, down, forward = camera.axes()
    local = points - camera.position
    depth = local @ forward
    assert depth.min() > 0.0
    scale = 0.5 * size[1] / np.tan(np.radians(FOV) / 2)
    x = 0.5 * size[0] + scale * (local @ right) / depth
    y = 0.5 * size[1] + scale * (local @ down) / depth
    return np.stack([x, y], axis=1)


class Client:
    """A browser that follows commands, and sometimes acts by itself."""

    def __init__(self, index, size=DESKTOP):
        self.client_id = index
        self.camera = SimpleNamespace(
            position=np.array([4.0, -3.0, 2.0]),
            look_at=np.array([0.0, 0.0, 1.0]),
            image_width=size[0],
            image_height=size[1],
        )

    def atomic(self):
        import contextlib

        return contextlib.nullcontext()


def stage():
    """A stub of `Stage`, with people whose joints the test moves."""
    result = small_result()
    joints = result.people[0].body.joints(result.motion)[0]
    shown = SimpleNamespace(
        visible=True, offset=np.zeros(3), frame=0, drawing=SimpleNamespace(result=result)
    )
    shown.at = joints
    shown.joints = lambda: [shown.at]
    return shown


def cameras(*stages, clients=()):
    server = SimpleNamespace(get_clients=lambda: {c.client_id: c for c in clients})
    return Cameras(server, stages, lambda size: None)


@pytest.mark.parametrize("window", [DESKTOP, PHONE])
@pytest.mark.parametrize("name", PRESETS)
def test_presets_have_people_in_the_part_that_the_panel_leaves_free(name, window):
    shown = stage()
    camera = cameras(shown).look(name, window)
    points = shown.at
    if name == "Hands":
        points = points[[JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"]]]
    pixels = on_screen(camera, points, window)
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    if window == DESKTOP:
        assert low.min() > 0
        assert high[0] < 945
        assert high[1] < 800
    else:
        assert low.min() > 0
        assert high[0] < 390
        assert high[1] < 0.91 * 844  # the sheet is folded
    # And the subjects fill it: no smaller than a third of one side.
    assert max((high - low) / window) > 0.12


def test_presets_look_from_where_they_say():
    shown = stage()  # walks along x
    seen = cameras(shown)

    def toward(name):
        camera = seen.look(name, DESKTOP)
        way = camera.position - camera.target
        return way / np.linalg.norm(way)

    assert toward("Front")[0] > 0.95
    assert toward("Side")[1] > 0.95  # the left side
    assert toward("Top")[2] > 0.99
    hands = toward("Hands")
    assert hands[0] > 0.6
    assert hands[2] > 0.3


def test_hands_that_touch_are_looked_at():
    from halfphysics.motion.skeleton import RIGHT_HAND_JOINTS

    shown = stage()
    both = cameras(shown).look("Hands", DESKTOP)
    contacts = SimpleNamespace(**vars(shown.drawing.result.contacts))
    contacts.part = np.where(contacts.frame == 0, RIGHT_HAND_JOINTS[4], contacts.part)
    shown.drawing.result = SimpleNamespace(contacts=contacts)
    right = cameras(shown).look("Hands", DESKTOP)
    wrist = shown.at[JOINT_INDEX["right_wrist"]]
    assert np.linalg.norm(right.target - wrist) < 0.2
    assert np.linalg.norm(both.target - wrist) > 0.3


def walk(client, seen, shown, seconds, velocity=1.2, act=lambda k: None):
    """Advance time at 30 updates a second; returns the camera's offsets from the pelvis."""
    out = []
    for k in range(round(seconds / STEP)):
        shown.at = shown.at + np.array([velocity * STEP, 0.0, 0.0])
        seen.clock += STEP
        act(k)
        seen.follow()
        out.append(client.camera.look_at - shown.at[0])
    return np.array(out)


@pytest.fixture
def scene(monkeypatch):
    shown, client = stage(), Client(7)
    seen = cameras(shown, clients=[client])
    seen.clock = 100.0
    monkeypatch.setattr(
        "halfphysics.viewer.camera.time", SimpleNamespace(monotonic=lambda: seen.clock)
    )
    seen._last = seen.clock
    return seen, shown, client


def test_following_keeps_angle_and_distance(scene):
    seen, shown, client = scene
    orbit = client.camera.position - client.camera.look_at
    before = client.camera.position.copy()
    walk(client, seen, shown, 1.0)
    np.testing.assert_array_equal(client.camera.position, before)  # following is off
    seen.following = True
    beside = walk(client, seen, shown, 3.0)
    np.testing.assert_allclose(client.camera.position - client.camera.look_at, orbit, atol=1e-9)
    # At a walk it is a quarter of a second late, and settles there.
    assert np.linalg.norm(beside[-1]) == pytest.approx(0.25 * 1.2, rel=0.15)
    assert np.ptp(beside[-15:], axis=0).max() < 0.01


def test_who_turns_the_camera_keeps_it(scene):
    seen, shown, client = scene
    seen.following = True
    walk(client, seen, shown, 2.0)
    turned = np.array([0.5, 2.5, 0.7])
    held = []

    def turn(k):
        if k < 10:  # a drag of a third of a second
            share = (k + 1) / 10
            start = np.array([4.0, -3.0, 1.0])
            client.camera.position = client.camera.look_at + (1 - share) * start + share * turned
            held.append(client.camera.position.copy())
        elif k == 10:
            # No message was sent meanwhile that interrupts the drag.
            np.testing.assert_array_equal(client.camera.position, held[-1])

    walk(client, seen, shown, 3.0, act=turn)
    np.testing.assert_allclose(client.camera.position - client.camera.look_at, turned, atol=1e-9)
    assert np.linalg.norm(client.camera.look_at - shown.at[0]) < 0.4


def test_who_moves_it_aside_keeps_it_there(scene):
    seen, shown, client = scene
    seen.following = True
    walk(client, seen, shown, 2.0)
    aside = np.array([0.0, 0.8, 0.3])

    def pan(k):
        if k == 0:
            client.camera.position = client.camera.position + aside
            client.camera.look_at = client.camera.look_at + aside

    settled = walk(client, seen, shown, 4.0, act=pan)[-1]
    np.testing.assert_allclose(settled, aside - [0.25 * 1.2, 0.0, 0.0], atol=0.06)


def test_a_late_report_is_no_hand(scene):
    _, _, client = scene
    follower = Follower(client.camera.position, client.camera.look_at)
    reports = [(client.camera.position, client.camera.look_at)] * 3
    subject = np.array([0.0, 0.0, 1.0])
    for k in range(90):
        subject = subject + np.array([0.04, 0.0, 0.0])
        moved = follower.move(*reports[-3], subject, k * STEP, STEP)
        assert moved is not None
        reports.append(moved)
    assert np.linalg.norm(reports[-1][1] - subject) < 0.4


def test_two_browsers_follow_each_in_their_own_way(scene):
    seen, shown, one = scene
    two = Client(8, PHONE)
    two.camera.position = np.array([-1.0, 0.0, 6.0])
    seen._server.get_clients = lambda: {7: one, 8: two}
    seen.following = True
    walk(one, seen, shown, 2.0)
    np.testing.assert_allclose(one.camera.look_at, two.camera.look_at, atol=0.02)
    np.testing.assert_allclose(two.camera.position - two.camera.look_at, [-1.0, 0.0, 5.0])
    seen.preset(one, "Top")
    above = one.camera.position - one.camera.look_at
    walk(one, seen, shown, 1.0)
    np.testing.assert_allclose(one.camera.position - one.camera.look_at, above, atol=1e-9)
    np.testing.assert_allclose(two.camera.position - two.camera.look_at, [-1.0, 0.0, 5.0])


@pytest.fixture
def visited():
    """Cameras whose home depends on the window, and a newly connected browser on a phone."""
    client = Client(3, PHONE)
    first = SimpleNamespace(position=np.full(3, 9.0), look_at=np.zeros(3))
    server = SimpleNamespace(get_clients=lambda: {3: client}, initial_camera=first)

    def home(window):
        return Camera(position=np.array([0.0, *window]), target=np.array([1.0, *window]))

    return Cameras(server, [stage()], home), client, first


def at_home(client):
    camera = client.camera
    place = [0.0, camera.image_width, camera.image_height]
    return camera.position.tolist() == place and camera.look_at[0] == 1.0


def test_who_comes_goes_home_and_again_if_the_page_begins_late(visited):
    seen, client, first = visited
    seen.watch()
    assert at_home(client)
    client.camera.position, client.camera.look_at = first.position + 1e-5, first.look_at
    seen.watch()
    assert at_home(client)


def test_a_window_of_another_shape_is_framed_anew_unless_somebody_has_turned(visited):
    seen, client, _ = visited
    seen.watch()
    before = client.camera.position
    client.camera.image_width, client.camera.image_height = 195, 422  # drawn with fewer pixels
    seen.watch()
    assert client.camera.position is before
    client.camera.image_width, client.camera.image_height = PHONE[::-1]
    seen.watch()
    assert at_home(client)
    turned = client.camera.position + np.array([0.0, 0.1, 0.0])
    client.camera.position = turned
    client.camera.image_width, client.camera.image_height = PHONE
    seen.watch()
    assert client.camera.position is turned
    seen.home(client)
    assert at_home(client)


def test_people_fill_half_of_the_height_at_first_and_are_followed(scene):
    seen, shown, client = scene
    direction = np.array([0.6, -1.0, 0.4])
    first = SimpleNamespace(position=np.full(3, 9.0), look_at=np.zeros(3))
    seen._server.initial_camera = first
    seen._home = lambda window: on_people(seen.people(), direction, window)
    seen.following = True
    seen.watch()
    assert client.camera.look_at is not first.look_at

    def place():
        camera = Camera(position=client.camera.position, target=client.camera.look_at, fov=FOV)
        return on_screen(camera, skin + shown.at[0], DESKTOP)

    person = small_result().people[0]
    skin = person.body.vertices(person.motion, frames=[0])[0] - shown.at[0]
    before = place()
    assert np.ptp(before[:, 1]) / DESKTOP[1] == pytest.approx(0.5, abs=0.06)
    walk(client, seen, shown, 3.0)
    # A quarter of a second late, and as large as before.
    assert np.ptp(place()[:, 1]) == pytest.approx(np.ptp(before[:, 1]), rel=0.1)
    assert np.abs(place().mean(axis=0) - before.mean(axis=0)).max() < 120


def test_reports_of_an_older_camera_are_no_hand(scene):
    """A browser that has just come reports an older camera until it has the home view."""
    seen, shown, client = scene
    seen._server.initial_camera = SimpleNamespace(position=np.full(3, 9.0), look_at=np.zeros(3))
    home = Camera(position=np.array([3.0, -4.0, 1.5]), target=shown.at[0] + [0.2, 0.0, 0.0])
    seen._home = lambda window: home
    seen.following = True
    old = client.camera.position, client.camera.look_at
    seen.watch()
    client.camera.position, client.camera.look_at = old
    walk(client, seen, shown, 0.5)
    np.testing.assert_array_equal(client.camera.look_at, old[1])
    client.camera.position, client.camera.look_at = home.position, home.target
    walk(client, seen, shown, 2.0)
    np.testing.assert_allclose(
        client.camera.position - client.camera.look_at, home.position - home.target, atol=1e-9
    )
    aside = client.camera.look_at - shown.at[0]
    np.testing.assert_allclose(aside, [0.2 - 0.25 * 1.2, 0.0, 0.0], atol=0.05)


def test_who_sees_everything_follows_nobody_until_another_view(scene):
    seen, shown, client = scene
    far = Camera(position=np.array([9.0, -9.0, 5.0]), target=np.zeros(3))
    seen._everything = lambda window: far
    seen.following = True
    seen.everything(client)
    walk(client, seen, shown, 1.0)
    np.testing.assert_array_equal(client.camera.position, far.position)
    seen.preset(client, "Front")
    walk(client, seen, shown, 1.0)
    assert np.linalg.norm(client.camera.look_at - shown.at[0]) < 1.0


@pytest.mark.parametrize(
    "broken", [np.zeros(2), np.array([0.0, np.nan, 0.0]), [[0.0], [1.0, 2.0], 3.0], "abc", None]
)
def test_a_browser_that_reports_no_camera_is_passed_over(broken):
    shown, strange, sound = stage(), Client(1), Client(2)
    strange.camera.position = broken
    seen = cameras(shown, clients=[strange, sound])
    seen._server.initial_camera = SimpleNamespace(position=np.ones(3), look_at=np.zeros(3))
    first = Camera(position=np.array([3.0, 3.0, 3.0]), target=np.zeros(3))
    seen._home = lambda size: first
    seen.following = True
    seen.watch()
    seen.follow()
    assert strange.camera.position is broken
    assert np.array_equal(sound.camera.position, first.position)

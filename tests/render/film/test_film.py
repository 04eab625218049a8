"""Films: the file holds the drawn pictures, in the right order, at the right times."""

from __future__ import annotations

import dataclasses
import functools
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from halfphysics.errors import FileError, InputError, MissingDependencyError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.render.film import CAMERAS, FilmOptions, encoding, save_film, save_picture
from halfphysics.render.film.filming import Shoot
from halfphysics.render.film.overlay import Overlay
from halfphysics.render.film.sampling import sampled
from halfphysics.render.film.saving import film_rate, film_times
from halfphysics.render.film.tracking import Story, hiding, track
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.viewpoint import choose_direction, spread
from halfphysics.scene.scene import Scene
from support.results.small_result import FPS, FRAMES, small_result

SIZE = (128, 96)
# One view from a fixed place, small and coarse: the pictures of these tests.
PLAIN = FilmOptions(camera=("fixed",), size=SIZE, samples=1)
# H.264 at this quality is off by this much in the mean, of 255.
LOSSY = 4.0


BEST = np.array([0.5, -0.8, 0.33]) / np.linalg.norm([0.5, -0.8, 0.33])


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """The best direction is computed once in these tests: it takes longer than they do."""
    monkeypatch.setattr("halfphysics.render.film.tracking.choose_direction", lambda *_: BEST)


def shoot(options=PLAIN, results=None, frames=None):
    """The pictures of all frames of the small result."""
    results = [small_result()] if results is None else results
    frames = np.arange(FRAMES, dtype=float) if frames is None else frames
    times = (frames / FPS).tolist()
    return Shoot(results, options, [frames] * len(results), rate=FPS, times=times)


@functools.cache
def plain_shoot():
    return shoot()


@functools.cache
def plain(frame):
    """A frame of the small result as `PLAIN` has it: drawn once for all tests."""
    picture = plain_shoot().picture(frame)
    picture.setflags(write=False)
    return picture


def decoded(path):
    iio = pytest.importorskip("imageio.v3")
    pytest.importorskip("imageio_ffmpeg")
    return iio.imread(path, plugin="FFMPEG"), iio.immeta(path, plugin="FFMPEG")


def blue(picture):
    """Pixels that only the ghost can have."""
    red, green, of_blue = np.moveaxis(picture.astype(int), -1, 0)
    return int(((of_blue - red > 35) & (of_blue - green > 20) & (of_blue > 120)).sum())


def off(a, b):
    return np.abs(a.astype(int) - b.astype(int)).mean()


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "codec"), [(".mp4", "h264"), (".webm", "vp9")])
def test_a_film_has_every_frame_in_order(tmp_path, suffix, codec):
    path = tmp_path / f"film{suffix}"
    assert save_film(small_result(), path, PLAIN, threads=2) == path
    frames, meta = decoded(path)
    assert frames.shape == (FRAMES, SIZE[1], SIZE[0], 3)
    assert (meta["fps"], meta["codec"]) == (FPS, codec)
    assert meta["pix_fmt"].startswith("yuv420p")
    for k in range(FRAMES):
        errors = [off(frames[k], plain(j)) for j in (k, (k + 8) % FRAMES)]
        assert errors[0] < LOSSY
        assert errors[0] < errors[1]
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_gif_needs_no_ffmpeg_and_has_the_colours_and_the_pace(tmp_path, monkeypatch):
    monkeypatch.setattr(encoding, "ffmpeg", lambda suffix: pytest.fail("asked for ffmpeg"))
    path = tmp_path / "film.GIF"
    save_film(small_result(), path, PLAIN)
    with Image.open(path) as film:
        assert (film.size, film.info["loop"]) == (SIZE, 0)
        assert film.n_frames == FRAMES / 2  # 15 frames/s, of 30
        lasting, drawn = [], shoot(frames=np.arange(0.0, FRAMES, 2.0))
        for k in range(film.n_frames):
            film.seek(k)
            lasting.append(film.info["duration"])
            assert off(np.asarray(film.convert("RGB")), drawn.picture(k)) < LOSSY
    assert set(lasting) <= {60, 70}
    assert sum(lasting) == pytest.approx(1000 * FRAMES / FPS, abs=5)


@pytest.mark.slow
def test_the_film_does_not_depend_on_the_number_of_threads(tmp_path):
    for suffix in (".mp4", ".gif"):
        if suffix == ".mp4":
            pytest.importorskip("imageio_ffmpeg")
        files = [tmp_path / f"{threads}{suffix}" for threads in (1, 3)]
        for threads, path in zip((1, 3), files, strict=True):
            save_film(small_result(), path, PLAIN, threads=threads)
        assert files[0].read_bytes() == files[1].read_bytes()


def test_ghost_and_body_show_and_the_ghost_can_be_left_out():
    apart = plain(10)
    alone = shoot(dataclasses.replace(PLAIN, ghost=False)).picture(10)
    red, _, of_blue = np.moveaxis(apart.astype(int), -1, 0)
    assert ((red - of_blue > 25) & (red - of_blue < 90)).sum() > 60  # skin
    # The words of the key have a blue square: look at the upper part.
    assert blue(apart[:80]) > 40
    assert blue(alone) == 0


def test_slow_motion_is_smooth_and_whole_frames_are_the_same():
    options = dataclasses.replace(PLAIN, speed=0.5, text=False)
    times = film_times([small_result()], options, film_rate([small_result()], options, ".mp4"))
    np.testing.assert_allclose(times, np.arange(2 * FRAMES - 1) / (2 * FPS), atol=1e-12)
    slow = shoot(options, frames=times * FPS)
    normal = shoot(dataclasses.replace(options, speed=1.0))
    for k in (0, 7, FRAMES - 1):
        np.testing.assert_array_equal(slow.picture(2 * k), normal.picture(k))
    between = slow.picture(23)
    assert min(off(between, normal.picture(k)) for k in (11, 12)) > 0.05


def test_fewer_frames_and_a_part_of_the_story():
    few = dataclasses.replace(PLAIN, fps=10.0)
    result = small_result()
    np.testing.assert_allclose(film_times([result], few, 10.0) * FPS, np.arange(0, FRAMES, 3))
    part = dataclasses.replace(PLAIN, start=0.1, end=0.2)
    np.testing.assert_allclose(film_times([result], part, FPS) * FPS, [3, 4, 5, 6])
    fast = SimpleNamespace(fps=150.0)
    assert film_rate([fast], FilmOptions(), ".mp4") == 50.0
    assert film_rate([fast], FilmOptions(), ".gif") == 150.0 / 8
    assert film_rate([fast], FilmOptions(fps=100.0), ".mp4") == 100.0


@pytest.mark.parametrize(
    ("options", "count"),
    [
        ({"fps": 0.5}, 1),
        ({"start": 0.1, "end": 0.11}, 1),
        ({"speed": 40.0}, 1),
        ({"speed": 5.0, "fps": 5.0}, 1),
    ],
)
@pytest.mark.parametrize("camera", ["fixed", "follow", "orbit"])
def test_a_film_may_have_one_picture(tmp_path, options, count, camera):
    result = small_result()
    film = save_film(
        result, tmp_path / "film.gif", dataclasses.replace(PLAIN, camera=(camera,), **options)
    )
    with Image.open(film) as image:
        assert image.n_frames == count


def test_poses_of_a_film_may_be_farther_apart_than_a_motion_allows():
    """10 m a frame at 4 fps, every second frame: 80 m/s, were it a motion of its own."""
    result = small_result()
    way = np.arange(FRAMES)[:, None] * [10.0, 0.0, 0.0]
    far = result.motion.with_frames(way, result.motion.rotations, fps=4.0)
    person = SimpleNamespace(**(vars(result.people[0]) | {"motion": far, "recorded": far}))
    seen = sampled(
        SimpleNamespace(**(vars(result) | {"people": (person,), "motion": far})),
        np.arange(0.0, FRAMES, 2.0),
    )
    np.testing.assert_array_equal(seen.motion.translation, way[::2])
    assert seen.motion.fps == 4.0


def test_views_stand_beside_or_below_each_other():
    one, two, wide = SIZE[0], SIZE[1], 2 * SIZE[0] + 2
    bare = dataclasses.replace(PLAIN, text=False)
    cameras = ("fixed", "top")
    alone = [shoot(dataclasses.replace(bare, camera=(c,))).picture(9) for c in cameras]
    row = shoot(dataclasses.replace(bare, camera=cameras, size=(wide, two))).picture(9)
    np.testing.assert_array_equal(row[:, :one], alone[0])
    np.testing.assert_array_equal(row[:, one + 2 :], alone[1])
    column = dataclasses.replace(bare, camera=cameras, size=(one, 2 * two + 2), layout="column")
    picture = shoot(column).picture(9)
    np.testing.assert_array_equal(picture[:two], alone[0])
    np.testing.assert_array_equal(picture[two + 2 :], alone[1])


def test_two_results_are_seen_from_the_same_place_and_the_shorter_waits():
    longer, shorter = small_result(), small_result()
    person = longer.people[0]
    cut = SimpleNamespace(**vars(person) | {"motion": person.motion[:8]})
    cut.recorded = person.recorded[:8]
    ball = longer.objects["ball"]
    track_cut = SimpleNamespace(position=ball.position[:8], quaternion=ball.quaternion[:8])
    shorter = SimpleNamespace(**vars(longer) | {"people": (cut,), "motion": cut.motion})
    shorter.objects = {"ball": track_cut}
    times = film_times([longer, shorter], PLAIN, FPS)
    assert len(times) == FRAMES
    both = shoot(dataclasses.replace(PLAIN, size=(258, 96), text=False), [longer, shorter])
    last, waiting = both.picture(FRAMES - 1), both.picture(7)
    np.testing.assert_array_equal(last[:, 130:], waiting[:, 130:])
    # The same but for a floor whose lines fade out a little nearer.
    differs = np.abs(waiting[:, :128].astype(int) - waiting[:, 130:]).max(axis=2) > 2
    assert differs.mean() < 0.05
    assert off(last[:, :128], waiting[:, :128]) > 1.0


def test_results_are_columns_and_cameras_are_rows():
    options = dataclasses.replace(
        PLAIN, camera=("fixed", "top"), size=(258, 194), label=("a", "b"), text=False
    )
    sheet = shoot(options, [small_result()] * 2).picture(3)
    body = sheet.copy()
    # The same picture twice, but for the labels in the corners.
    assert off(body[:96, :128][24:], body[:96, 130:][24:]) == 0.0
    assert off(body[98:, :128][24:], body[98:, 130:][24:]) == 0.0
    assert off(body[:96, :128], body[98:, :128]) > 3.0
    assert off(body[:24, :40], body[:24, 130:170]) > 0.1


@pytest.mark.parametrize("name", CAMERAS)
def test_every_camera_has_the_whole_story_in_its_picture(name):
    story = Story([Drawing(small_result())], ghost=True)
    path = track(story, name, SIZE, FPS)
    assert len(path) == FRAMES
    for frame, camera in enumerate(path):
        local = (story.at(frame) - camera.position) @ camera.axes().T
        tangent = np.tan(np.radians(camera.fov) / 2)
        assert (local[:, 2] > 0.5).all()
        assert (np.abs(local[:, 1] / local[:, 2]) < tangent).all()
        assert (np.abs(local[:, 0] / local[:, 2]) < tangent * SIZE[0] / SIZE[1]).all()


@pytest.mark.slow
def test_the_story_is_seen_from_its_best_side(monkeypatch):
    monkeypatch.setattr("halfphysics.render.film.tracking.choose_direction", choose_direction)
    drawing = Drawing(small_result())
    camera = track(Story([drawing], ghost=True), "follow", SIZE, FPS)[3]
    best = choose_direction(drawing, spread(FRAMES, 6), SIZE)
    np.testing.assert_allclose(camera.axes()[2], -best, atol=1e-9)


def test_a_following_camera_follows_without_a_jerk_and_an_orbit_turns():
    drawing = Drawing(small_result())
    story = Story([drawing], ghost=True)
    follow = np.array([camera.position for camera in track(story, "follow", SIZE, FPS)])
    assert np.linalg.norm(follow[-1] - follow[0]) > 0.1
    assert np.linalg.norm(np.diff(follow, 2, axis=0), axis=1).max() * FPS**2 < 5.0  # [m/s2]
    fixed = np.array([camera.position for camera in track(story, "fixed", SIZE, FPS)])
    assert (fixed == fixed[0]).all()
    orbit = track(story, "orbit", SIZE, FPS)
    ways = [camera.position - camera.target for camera in (orbit[0], orbit[-1])]
    angles = [np.arctan2(w[1], w[0]) for w in ways]
    turned = np.degrees(angles[1] - angles[0]) % 360
    assert turned == pytest.approx(24.0 * (FRAMES - 1) / FPS, abs=1e-6)


def test_the_time_is_written_and_labels_are_and_both_can_be_left_out():
    big = dataclasses.replace(PLAIN, size=(320, 240), label=("λ = 0",))
    written = shoot(big).picture(0).astype(int)
    bare = shoot(dataclasses.replace(big, text=False, label=())).picture(0).astype(int)
    changed = (written != bare).any(axis=2)
    for corner in (changed[:24, :70], changed[-26:, :60], changed[-26:, -120:]):
        assert corner.mean() > 0.3
    assert not changed[30:-30].any()
    assert written[:24, :70].max(axis=2).min() < 80  # dark letters
    later = shoot(big).picture(9)
    assert (later[-26:, :60] != written[-26:, :60]).any()


def test_a_shorter_time_begins_where_its_digits_are():
    """Times end at the same place; before the digit of 1.00 there is no box of a missing letter."""
    overlay = Overlay((200, 100), [(0, 0, 200, 100)], times=[1.0, 10.0])
    first = []
    for index in range(2):
        picture = np.full((100, 200, 3), 255, dtype=np.uint8)
        overlay.draw(picture, index)
        first.append(np.flatnonzero(picture.min(axis=(0, 2)) < 128)[0])
    assert first[0] - first[1] >= 4  # a digit of the smallest text is 5 pixels wide


@pytest.mark.slow
def test_one_frame_is_that_of_the_film_and_a_sheet_has_the_key_frames(tmp_path):
    still = tmp_path / "still.png"
    save_picture(small_result(), still, PLAIN, frame=-1)
    with Image.open(still) as image:
        np.testing.assert_array_equal(np.asarray(image), plain(FRAMES - 1))
    sheet = tmp_path / "sheet.png"
    save_picture([small_result()] * 2, sheet, FilmOptions(size=(130, 64), samples=1))
    with Image.open(sheet) as image:
        assert image.size == (2 * 14 + 3 * 136 - 6, 2 * 14 + 2 * (64 + 36 + 10) + 18)
    strip = tmp_path / "strip.png"
    save_picture(small_result(), strip, FilmOptions(size=(60, 60), samples=1))
    with Image.open(strip) as image:
        assert image.size[0] == 2 * 14 + 6 * 66 - 6


def test_what_stands_in_the_way_is_seen_through():
    result = small_result()
    options = dataclasses.replace(PLAIN, camera=("front", "back", "left", "right"), size=(520, 96))
    pictures = shoot(options, [result])
    glass = [any(s.alpha < 1 for s in view.statics.values()) for view in pictures._views]
    assert any(glass)  # the wall beside the way hides the person from one side
    assert not all(glass)


def test_a_table_is_seen_through_with_its_legs_and_nothing_else_is():
    result = small_result()
    scene = Scene()
    middle = result.motion.translation[8] + (0.0, 0.0, 0.3)
    before, up = middle + 0.7 * BEST, np.array([0.0, 0.0, 1.0])
    scene.add_static("floor", Plane())
    scene.add_static("table", Box((0.5, 0.5, 0.5)), position=before)
    scene.add_static("table_leg", Box((0.1, 0.1, 0.3)), position=before - up)
    scene.add_static("stool", Box((0.2, 0.2, 0.2)), position=middle - 2 * BEST)
    scene.add_object("ball", Sphere(0.11), mass=0.43, position=(0.9, 0.1, 0.11))
    drawing = Drawing(SimpleNamespace(**vars(result) | {"scene": scene}))
    cameras = track(Story([drawing], ghost=True), "fixed", SIZE, FPS)
    assert hiding(drawing, cameras, SIZE) == {"static/table", "static/table_leg"}


# -- mistakes -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"camera": ("folow",)}, "did you mean follow"),
        ({"size": "640"}, "640x480"),
        ({"size": (0, 480)}, "16 to 8192"),
        ({"size": (640, 100000)}, "16 to 8192"),
        ({"size": (64.5, 48)}, "16 to 8192"),
        ({"fps": 0.0}, "fps"),
        ({"fps": float("nan")}, "fps"),
        ({"speed": -1.0}, "speed"),
        ({"start": -0.1}, "start"),
        ({"start": 1.0, "end": 1.0}, "end"),
        ({"samples": 9}, "samples"),
        ({"layout": "ring"}, "row or column"),
    ],
)
def test_impossible_options_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        FilmOptions(**wrong)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("film.avi", {}, "mp4"),
        ("film", {}, "mp4"),
        ("film.mp4", {"size": (65, 48)}, "Try 66x48"),
        ("film.gif", {"fps": 60.0}, "at most 50"),
        ("film.gif", {"end": 9.0}, "ends at 0.500 s"),
        ("film.gif", {"start": 2.0}, "ends at 0.500 s"),
        ("film.gif", {"label": ("a", "b")}, "label"),
        ("film.gif", {"camera": ("top",) * 4, "size": (40, 40)}, "too small"),
    ],
)
def test_films_that_cannot_be_leave_nothing(tmp_path, name, options, message):
    with pytest.raises(InputError, match=message):
        save_film(small_result(), tmp_path / name, FilmOptions(**options))
    assert list(tmp_path.iterdir()) == []


def test_other_mistakes_leave_nothing(tmp_path):
    with pytest.raises(InputError, match="0 to 15"):
        save_picture(small_result(), tmp_path / "a.png", frame=FRAMES)
    with pytest.raises(InputError, match="speed"):
        save_picture(small_result(), tmp_path / "a.png", FilmOptions(speed=2.0))
    with pytest.raises(InputError, match="threads"):
        save_film(small_result(), tmp_path / "a.gif", threads=0)
    with pytest.raises(InputError, match="Result"):
        save_film([], tmp_path / "a.gif")
    with pytest.raises(FileError, match="does not exist"):
        save_film(small_result(), tmp_path / "no" / "a.gif")
    assert list(tmp_path.iterdir()) == []


def test_without_ffmpeg_the_way_out_is_said(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingDependencyError, match=r"halfphysics\[film\].*imageio-ffmpeg"):
        save_film(small_result(), tmp_path / "a.mp4", PLAIN)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="the program stands in as a shell script")
@pytest.mark.parametrize("reads", [True, False])
def test_a_full_disk_ends_in_one_message_and_nothing_is_left(tmp_path, monkeypatch, reads):
    program = tmp_path / "ffmpeg"
    swallow = "cat > /dev/null; " if reads else ""
    program.write_text(
        f"#!/bin/sh\n{swallow}echo '[out @ 0x5] x: No space left on device' >&2; exit 1\n"
    )
    program.chmod(0o755)
    monkeypatch.setattr(encoding, "ffmpeg", lambda suffix: str(program))
    folder = tmp_path / "films"
    folder.mkdir()
    with pytest.raises(FileError, match="film: x: No space left on device"):
        save_film(small_result(), folder / "a.mp4", PLAIN)
    assert list(folder.iterdir()) == []


def test_a_film_that_is_interrupted_leaves_what_was_there(tmp_path, monkeypatch):
    pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "a.mp4"
    path.write_bytes(b"before")
    picture = Shoot.picture

    def stopped(self, index, threads=1):
        if index == 5:
            raise KeyboardInterrupt
        return picture(self, index, threads)

    monkeypatch.setattr(Shoot, "picture", stopped)
    with pytest.raises(KeyboardInterrupt):
        save_film(small_result(), path, PLAIN)
    assert path.read_bytes() == b"before"
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"]

"""The software z-buffer against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.errors import FileError, InputError
from halfphysics.render.rasterizer import Camera, Light, Look, Surface, render, save_png, visible

# A look without shading: every object has exactly its own colour.
PLAIN = Look(
    top=(0.0, 0.0, 0.0), bottom=(0.0, 0.0, 0.0), sky=(1, 1, 1), ground=(1, 1, 1), lights=()
)
SIZE = (64, 48)
# From 5 m in front of the origin; the picture's height spans 2 m there: 24 pixels per metre.
FRONT = Camera(position=(0, -5, 0), fov=2 * np.degrees(np.arctan(1 / 5)))
SQUARE = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], dtype=float)
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def square(half: float, y: float = 0.0, middle=(0.0, 0.0), **look) -> Surface:
    """A square across the view, its front towards the camera."""
    vertices = SQUARE * half + np.array([middle[0], y, middle[1]])
    return Surface(vertices=vertices, faces=TWO, rim=0.0, **look)


def sphere(radius: float = 0.5, middle=(0, 0, 0), **look) -> Surface:
    n = 24
    polar, around = np.meshgrid(np.linspace(0, np.pi, n), np.arange(n) * 2 * np.pi / n)
    unit = np.stack(
        [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1
    )
    index = np.arange(n * n).reshape(n, n)
    a, b = index[:, :-1], index[:, 1:]
    c, d = np.roll(index, -1, axis=0)[:, :-1], np.roll(index, -1, axis=0)[:, 1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, d), (a, d, c))])
    vertices = unit.reshape(-1, 3) * radius + np.array(middle, dtype=float)
    return Surface(vertices=vertices, faces=faces, crease=180.0, **look)


def pixels(image: np.ndarray) -> np.ndarray:
    """Rows of different colours in a picture."""
    return np.unique(image.reshape(-1, 3), axis=0)


@pytest.mark.parametrize(("half", "y"), [(0.5, 0.0), (0.5, 2.0), (0.37, -1.0)])
def test_a_square_covers_exactly_the_pixels_it_must(half, y):
    index, depth = visible([square(half, y)], FRONT, SIZE)
    scale = 24.0 * 5 / (5 + y)  # pixels per metre at that depth
    columns = np.abs(np.arange(64) + 0.5 - 32) <= half * scale
    rows = np.abs(np.arange(48) + 0.5 - 24) <= half * scale
    expected = rows[:, None] & columns[None, :]
    assert expected.sum() > 50
    np.testing.assert_array_equal(index == 0, expected)
    np.testing.assert_array_equal(index[~expected], -1)
    # The inverse depth is a sum of three products: rounding only.
    np.testing.assert_allclose(depth[expected], 5 + y, rtol=1e-13)
    assert np.isinf(depth[~expected]).all()


def test_depth_of_a_slanted_plane():
    tilt = np.array([[-1, -0.8, -1], [1, -0.8, -1], [1, 0.8, 1], [-1, 0.8, 1]], dtype=float)
    index, depth = visible([Surface(vertices=tilt, faces=TWO)], FRONT, SIZE)
    up = (24 - (np.arange(48) + 0.5)) / 24 / 5  # height over depth of each row's ray
    # On the plane y = 0.8 z and y = depth - 5, z = up * depth.
    exact = np.broadcast_to((5 / (1 - 0.8 * up))[:, None], index.shape)
    hit = index == 0
    assert hit.sum() > 1000
    np.testing.assert_allclose(depth[hit], exact[hit], rtol=1e-12)


def test_the_nearer_hides_the_farther_in_any_order():
    near = square(0.4, -1.0, color=(1, 0, 0))
    far = square(0.9, 1.0, color=(0, 0, 1))
    a = render([near, far], FRONT, SIZE, look=PLAIN)
    b = render([far, near], FRONT, SIZE, look=PLAIN)
    np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(a[24, 32], [255, 0, 0])
    np.testing.assert_array_equal(a[24, 32 + 15], [0, 0, 255])
    np.testing.assert_array_equal(a[24, 2], [0, 0, 0])


def test_planes_that_cross_show_each_where_it_is_nearer():
    left = np.array([[-1, -0.5, -1], [1, 0.5, -1], [1, 0.5, 1], [-1, -0.5, 1]], dtype=float)
    right = left * [1, -1, 1]
    index, _ = visible([Surface(vertices=v, faces=TWO) for v in (left, right)], FRONT, SIZE)
    # The picture's middle column of pixels is where they meet.
    assert (index[10:38, 12:32] == 0).all()
    assert (index[10:38, 32:52] == 1).all()


def test_a_mesh_has_no_cracks():
    rng = np.random.default_rng(3)
    n = 40
    x, z = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    inner = (np.abs(x) < 1) & (np.abs(z) < 1)
    step = 2 / (n - 1)
    x = x + inner * rng.uniform(-0.3, 0.3, x.shape) * step
    z = z + inner * rng.uniform(-0.3, 0.3, z.shape) * step
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    vertices = np.stack([x, rng.uniform(-0.05, 0.05, x.shape), z], -1).reshape(-1, 3)
    mesh = Surface(vertices=vertices, faces=faces, color=(1, 1, 1), rim=0.0)
    image = render([mesh], FRONT, (640, 480), samples=3, look=PLAIN)
    # 240 pixels per metre at 5 m; the border stays a little inside on account of the bumps.
    np.testing.assert_array_equal(pixels(image[4:-4, 90:550]), [[255, 255, 255]])


def test_a_floor_that_passes_under_the_camera_ends_at_the_horizon():
    floor = SQUARE[:, [0, 2, 1]] * 1e4  # z = 0, the camera stands on it
    camera = Camera(position=(0, 0, 1.5), target=(0, 1, 1.5), fov=60.0)
    index, depth = visible([Surface(vertices=floor, faces=TWO)], camera, SIZE)
    below = np.arange(48) + 0.5 - 24  # of the horizon [pixels]
    np.testing.assert_array_equal(index >= 0, np.broadcast_to(below[:, None] > 0, index.shape))
    focal = 24 / np.tan(np.radians(30))
    exact = np.broadcast_to((1.5 * focal / below[24:])[:, None], (24, 64))
    np.testing.assert_allclose(depth[24:], exact, rtol=1e-9)


def test_behind_the_camera_nothing_is_drawn():
    index, _ = visible([square(1.0, -7.0), square(1.0, -4.97)], FRONT, SIZE)
    assert (index == -1).all()  # the second is nearer than `near`


@pytest.mark.parametrize(("cull", "seen"), [("none", True), ("back", False), ("front", True)])
def test_culling_of_a_square_seen_from_behind(cull, seen):
    turned = Surface(vertices=SQUARE * 0.5, faces=TWO[:, ::-1], cull=cull)
    assert (visible([turned], FRONT, SIZE)[0] == 0).any() == seen
    facing = Surface(vertices=SQUARE * 0.5, faces=TWO, cull=cull)
    assert (visible([facing], FRONT, SIZE)[0] == 0).any() == (cull != "front")


def test_a_ghost_is_one_skin_however_many_layers_lie_behind_it():
    look = Look(top=(1, 1, 1), bottom=(1, 1, 1), sky=(1, 1, 1), ground=(1, 1, 1), lights=())
    shells = [sphere(r, color=(0, 0, 1)) for r in (0.7, 0.5, 0.3)]
    first = np.cumsum([0, *(len(s.vertices) for s in shells[:-1])])
    onion = Surface(
        vertices=np.concatenate([s.vertices for s in shells]),
        faces=np.concatenate([s.faces + k for s, k in zip(shells, first, strict=True)]),
        color=(0, 0, 1),
        alpha=0.5,
        rim=0.0,
    )
    image = render([onion], FRONT, SIZE, samples=1, look=look)
    # Half of the background's white in linear light: sRGB 188.
    np.testing.assert_array_equal(pixels(image), [[188, 188, 255], [255, 255, 255]])
    assert (image[:, :, 0] == 188).sum() > 500


def test_two_translucent_meshes_blend_far_to_near_in_any_order():
    a = square(0.5, -0.5, color=(1, 0, 0), alpha=0.5)
    b = square(0.5, 0.5, color=(0, 0, 1), alpha=0.5)
    one, two = (render(s, FRONT, SIZE, samples=1, look=PLAIN) for s in ([a, b], [b, a]))
    np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(one[24, 32], [188, 0, 137])  # 1/2 red, 1/4 blue, linear


def test_a_ghost_shows_only_where_it_is_off_the_body():
    body = square(0.5, 0.0, color=(0, 1, 0))
    for distance, shown in ((0.0, False), (0.003, False), (0.006, True), (-0.02, False)):
        ghost = square(0.5, -distance, color=(0, 0, 1), alpha=0.5, bias=0.004)
        image = render([body, ghost], FRONT, SIZE, look=PLAIN)
        assert (image[24, 32, 2] > 0) == shown


def test_an_edge_pixel_is_the_mean_of_its_samples_in_linear_light():
    # The right edge lies at 32 + 24 * 0.5 + 0.5 pixels: half of column 44 is covered.
    vertices = SQUARE * 0.5
    vertices[1:3, 0] += 0.5 / 24
    mesh = Surface(vertices=vertices, faces=TWO, color=(1, 1, 1), rim=0.0)
    image = render([mesh], FRONT, SIZE, samples=2, look=PLAIN)
    np.testing.assert_array_equal(image[24, 43:46, 0], [255, 188, 0])


def test_colours_come_out_as_they_went_in():
    rng = np.random.default_rng(0)
    for color in rng.integers(0, 256, (20, 3)):
        mesh = square(0.5, color=tuple(color / 255))
        image = render([mesh], FRONT, SIZE, look=PLAIN)
        np.testing.assert_allclose(image[24, 32].astype(int), color, atol=1)  # table step


def test_checkerboard():
    floor = SQUARE[:, [0, 2, 1]] * 4
    above = Camera(position=(0, 0, 6), up=(0, 1, 0), fov=60.0)
    mesh = Surface(
        vertices=floor, faces=TWO, color=(1, 0, 0), checker=(0, 0, 1), checker_size=1.0, rim=0.0
    )
    image = render([mesh], above, (400, 400), look=PLAIN)
    focal = 200 / np.tan(np.radians(30))
    for x in (-1.5, -0.5, 0.5, 1.5):
        for y in (-1.5, -0.5, 0.5, 1.5):
            got = image[int(200 - y * focal / 6), int(200 + x * focal / 6)]
            even = (np.floor(x) + np.floor(y)) % 2 == 0
            np.testing.assert_array_equal(got, [255, 0, 0] if even else [0, 0, 255])
    # Far away it is grey, not a pattern of its own.
    wide = Surface(vertices=floor * 100, faces=TWO, color=(1, 0, 0), checker=(0, 0, 1), rim=0.0)
    far = render([wide], Camera(position=(0, -400, 40), fov=20.0), (40, 40), look=PLAIN)
    np.testing.assert_allclose(far[20, 20].astype(int), [188, 0, 188], atol=2)


def test_the_picture_does_not_depend_on_threads():
    rng = np.random.default_rng(5)
    scene = [sphere(0.3, rng.uniform(-0.7, 0.7, 3), color=tuple(rng.random(3))) for _ in range(8)]
    scene += [sphere(0.4, (0, -1, 0), alpha=0.4), square(1.5, 1.2)]
    size = (141, 99)  # not a multiple of a tile
    images = [render(scene, FRONT, size, samples=3, threads=n) for n in (1, 1, 2, 5)]
    assert len({i.tobytes() for i in images}) == 1
    assert len(pixels(images[0])) > 100


def test_a_shadow_lies_where_it_must_and_nowhere_else():
    floor = SQUARE[:, [0, 2, 1]] * 4
    lid = SQUARE[:, [0, 2, 1]] * 0.5 + np.array([0, 0, 1.0])
    scene = [
        Surface(vertices=floor, faces=TWO, color=(1, 1, 1), rim=0.0),
        Surface(vertices=lid, faces=TWO, color=(1, 0, 0), cull="front", rim=0.0),
    ]
    # Light at 45 degrees from -x: the shadow's middle lies at x = 1. The lid itself is unseen
    # from above.
    light = Light(towards=(-1, 0, 1), strength=0.5 * np.sqrt(2), softness=0.02)
    look = Look(sky=(0.5, 0.5, 0.5), ground=(0.5, 0.5, 0.5), lights=(light,))
    above = Camera(position=(0, 0, 8), up=(0, 1, 0), fov=40.0)
    image = render(scene, above, (320, 320), look=look)[:, :, 0]
    focal = 160 / np.tan(np.radians(20))
    x = (np.arange(320) + 0.5 - 160) * 8 / focal
    row = image[160]
    edge = 0.03  # half the blur and a texel
    inside = (np.abs(x - 1) < 0.5 - edge) & (np.abs(x) < 2)
    outside = (np.abs(x - 1) > 0.5 + edge) & (np.abs(x) < 2)
    np.testing.assert_array_equal(np.unique(row[inside]), [188])  # ambient half only
    np.testing.assert_array_equal(np.unique(row[outside]), [255])


@pytest.mark.parametrize("tilt", [0.0, 30.0, 60.0])
def test_a_lit_plane_does_not_shade_itself(tilt):
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    floor = SQUARE[:, [0, 2, 1]] * 4
    turned = floor @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    look = Look(
        sky=(0.2,) * 3,
        ground=(0.2,) * 3,
        lights=(Light(towards=(0, 0, 1), strength=0.7, softness=0.3),),
    )
    camera = Camera(position=(0, 0, 8), up=(0, 1, 0), fov=8.0)  # sees the middle only
    image = render([Surface(vertices=turned, faces=TWO, rim=0.0)], camera, (60, 60), look=look)
    assert len(pixels(image)) == 1


def test_a_smooth_ball_is_lit_like_a_sphere():
    look = Look(sky=(0.1,) * 3, ground=(0.1,) * 3, lights=(Light(towards=(0, -1, 0), strength=1),))
    ball = sphere(0.8, rim=0.0, casts=False, color=(0.5, 0.5, 0.5))
    row = render([ball], FRONT, (200, 150), samples=3, look=look)[75, :, 0].astype(int)
    # Rays of that row against the sphere: 75 pixels per metre at 5 m, half a pixel below level.
    x = (np.arange(200) + 0.5 - 100) / 75 / 5
    ray = np.stack([x, np.ones(200), np.full(200, -0.5 / 75 / 5)], -1)
    a, b, c = (ray**2).sum(1), -5 * ray[:, 1], 25 - 0.8**2
    hit = b * b - a * c > 0.15 * 0.8**2  # clear of the rim
    near = (-b - np.sqrt(np.maximum(b * b - a * c, 0))) / a
    cosine = -(near * ray[:, 1] - 5) / 0.8
    linear = ((0.5 + 0.055) / 1.055) ** 2.4 * (0.1 + cosine)
    exact = 255 * (1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055)
    assert hit.sum() > 60
    assert np.ptp(exact[hit]) > 25
    # Flat facets of 15 degrees would be off by up to 10.
    np.testing.assert_allclose(row[hit], exact[hit], atol=2.5)


def test_faded_floors_end_in_the_background():
    floor = SQUARE[:, [0, 2, 1]] * 20
    mesh = Surface(vertices=floor, faces=TWO, color=(0.2, 0.5, 0.2), fade=(1.0, 5.0), rim=0.0)
    camera = Camera(position=(0, 0, 20), up=(0, 1, 0), fov=60.0)
    image = render([mesh], camera, (100, 100), look=Look(sky=(1,) * 3, lights=()))
    empty = render([], camera, (100, 100))
    np.testing.assert_array_equal(image[:, :5], empty[:, :5])
    assert np.abs(image[50, 50].astype(int) - empty[50, 50]).max() > 50


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(-3, 3)] * 3), min_size=1, max_size=12),
    st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-0.9, 0.9)).filter(
        lambda d: np.hypot(d[0], d[1]) > 0.1
    ),
)
def test_framing_has_every_point_in_the_picture_and_none_to_spare(points, direction):
    points = np.array(points)
    size, margin = (300, 340), 1.1
    camera = Camera.framing(points, direction, size=size, margin=margin)
    right, down, forward = camera.axes()
    local = points - camera.position
    depth = local @ forward
    assert (depth > 0.05).all()
    tan = np.tan(np.radians(camera.fov) / 2)
    x = np.abs(local @ right) / depth / (tan * size[0] / size[1])
    y = np.abs(local @ down) / depth / tan
    reach = max(x.max(), y.max())
    assert reach <= 1 / margin + 1e-9
    if depth.min() > 0.101:  # no point had to be kept from the eye itself
        assert reach >= 1 / margin - 1e-9  # the nearest such camera


def test_framing_keeps_the_least_distance():
    camera = Camera.framing([[0, 0, 0]], (0, -1, 0), distance=4.0)
    np.testing.assert_allclose(camera.position, [0, -4, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vertices": np.zeros((4, 2))}, r"vertices.*\(V, 3\)"),
        ({"vertices": SQUARE * np.nan}, "finite"),
        ({"faces": np.array([[0, 1, 4]])}, "0 to 4"),
        ({"faces": np.array([[0.0, 1.0, 2.0]])}, "integers"),
        ({"cull": "both"}, "cull.*none, back, front"),
        ({"alpha": 1.5}, "alpha"),
        ({"alpha": float("nan")}, "alpha"),
    ],
)
def test_impossible_surfaces_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        Surface(**{"vertices": SQUARE, "faces": TWO, **change})


def test_impossible_cameras_and_pictures_are_refused():
    with pytest.raises(InputError, match="along up"):
        Camera(position=(0, 0, 5))
    with pytest.raises(InputError, match="fov"):
        Camera(position=(0, -5, 0), fov=0.0)
    with pytest.raises(InputError, match="position"):
        Camera(position=(0, np.inf, 0))
    with pytest.raises(InputError, match="size"):
        render([], FRONT, (0, 10))
    with pytest.raises(InputError, match="samples"):
        render([], FRONT, SIZE, samples=5)
    with pytest.raises(InputError, match="threads"):
        render([], FRONT, SIZE, threads=0)


def test_png_is_whole_or_not_there(tmp_path):
    from PIL import Image

    image = render([square(0.5)], FRONT, SIZE)
    path = tmp_path / "a.png"
    save_png(image, path)
    np.testing.assert_array_equal(np.asarray(Image.open(path)), image)
    with pytest.raises(FileError, match="missing"):
        save_png(image, tmp_path / "missing" / "a.png")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png"]

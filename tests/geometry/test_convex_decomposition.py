"""Objects of any shape: hollows stay open, pieces are measured, cached and reproducible."""

from __future__ import annotations

import os
import sys

import numpy as np
import pytest

from halfphysics.base import progress
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry import convex_decomposition as decomposition
from halfphysics.geometry import piece_cache
from halfphysics.geometry.convex_decomposition import Cut, content_key, decompose, judged
from halfphysics.geometry.shapes import Box, Mesh, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.terminals import terminal

trimesh = pytest.importorskip("trimesh")

#: Corners of an L: 0.3 by 0.2, both legs 0.1 wide.
L = np.array([(0, 0), (0.3, 0), (0.3, 0.1), (0.1, 0.1), (0.1, 0.2), (0, 0.2)])


def prism(corners, height=0.1):
    """A star-shaped polygon (seen from its first corner) with a height."""
    n = len(corners)
    low = np.column_stack([corners, np.zeros(n)])
    faces = [(0, k + 1, k) for k in range(1, n - 1)]
    faces += [(n, n + k, n + k + 1) for k in range(1, n - 1)]
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, j + n), (i, j + n, i + n)]
    return Mesh(np.concatenate([low, low + np.array([0, 0, height])]), np.array(faces))


def l_shape():
    return prism(L)


def l_pieces():
    long = [(0, 0), (0.3, 0), (0.3, 0.1), (0, 0.1)]
    return [prism(np.array(long)), prism(np.array([(0, 0), (0.1, 0), (0.1, 0.2), (0, 0.2)]))]


def ring():
    return trimesh.creation.torus(0.05, 0.01, major_sections=16, minor_sections=6)


def run(scene, seconds, fps=60.0):
    """Positions per frame by name, and all pairs in contact."""
    simulator = Simulator(scene, body=[], fps=fps)
    frames = [simulator.reset([])]
    met = set()
    for _ in range(round(seconds * fps)):
        frames.append(simulator.step([]))
        names, touches = simulator.world.names, frames[-1].contacts
        for a, b in zip(touches.subject, touches.other, strict=True):
            met.add(frozenset((names[a], names[b])))
    return {n: np.array([f.objects[n][0] for f in frames]) for n in scene.objects}, met


def test_exact_pieces_have_no_error():
    error = judged(l_shape(), l_pieces())
    assert (error.outside_mm, error.inside_mm, error.volume_percent) == (0.0, 0.0, 0.0)


def test_the_error_of_a_hull_in_closed_form():
    error = judged(l_shape(), [l_shape().hull])
    # Deepest in the notch, on the slanted side: equally far from both legs, t / 0.2 + t / 0.1 = 1.
    assert error.outside_mm == pytest.approx(1000 * 0.2 / 3, rel=0.01)
    assert error.inside_mm == 0.0
    assert error.volume_percent == pytest.approx(100 * 0.01 / 0.04, rel=0.06)


def test_the_error_of_too_little_in_closed_form():
    error = judged(l_shape(), l_pieces()[:1])
    assert error.outside_mm == 0.0
    assert error.inside_mm == pytest.approx(100.0)  # the end of the leg, a corner: exact
    assert error.volume_percent == pytest.approx(-25.0, rel=0.06)


def test_mass_and_inertia_are_of_the_mesh():
    thing = Scene().add_object("l", l_shape(), density=500.0, pieces=l_pieces())
    assert thing.mass == pytest.approx(500 * 0.004)  # overlapping pieces do not count twice
    legs = [((0.3, 0.1, 0.1), (0.15, 0.05, 0.05)), ((0.1, 0.1, 0.1), (0.05, 0.15, 0.05))]
    masses = [500 * np.prod(size) for size, _ in legs]
    com = sum(m * np.array(c) for m, (_, c) in zip(masses, legs, strict=True)) / sum(masses)
    inertia = np.zeros((3, 3))
    for m, (size, centre) in zip(masses, legs, strict=True):
        d = np.array(centre) - com
        inertia += m * (Box(size).unit_inertia() + d @ d * np.eye(3) - np.outer(d, d))
    np.testing.assert_allclose(thing.com, com, atol=1e-12)
    np.testing.assert_allclose(thing.inertia, inertia, atol=1e-12)


def test_solids_of_one_mesh_need_no_cutting(monkeypatch):
    monkeypatch.setitem(sys.modules, "coacd", None)
    boxes = [trimesh.creation.box((0.6, 0.03, 0.35)), trimesh.creation.box((0.25, 0.2, 0.015))]
    thing = Scene().add_object("monitor", trimesh.util.concatenate(boxes), mass=5.0)
    assert len(thing.pieces) == 2
    assert thing.decomposition.outside_mm == 0.0


def test_without_coacd_the_hull_touches_and_the_way_out_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "coacd", None)
    shifted = prism(L + 7.0)
    with pytest.warns(HalfPhysicsWarning, match=r"convex hull.*adds 2\d\.. %.*pip install"):
        thing = Scene().add_object("l", shifted, mass=1.0)
    assert len(thing.pieces) == 1


@pytest.mark.slow
def test_pieces_are_kept_by_content_and_made_again_where_broken(tmp_path, monkeypatch):
    pytest.importorskip("coacd")
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path))
    mesh, cut = l_shape(), Cut()
    first = decompose(mesh, cut)
    assert first.outside_mm < 1.0
    (file,) = tmp_path.rglob("*.npz")
    content = file.read_bytes()

    def same(other):
        assert [p.vertices.tobytes() for p in first.pieces] == [
            p.vertices.tobytes() for p in other.pieces
        ]
        assert (first.outside_mm, first.volume_percent) == (other.outside_mm, other.volume_percent)

    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "coacd", None)
        same(decompose(l_shape(), cut))
    for broken in (content[: len(content) // 2], b"", b"nonsense"):
        file.write_bytes(broken)
        same(decompose(mesh, cut))  # a second run gives the same
        assert file.read_bytes() == content


def test_what_is_kept_differs_by_content_and_options():
    meshes = [
        l_shape(),
        prism(L + 1e-9),
        prism(L, 0.2),
        Mesh(l_shape().vertices, l_shape().faces[::-1]),
    ]
    keys = {content_key(mesh, Cut()) for mesh in meshes}
    keys |= {content_key(meshes[0], Cut(threshold=0.01)), content_key(meshes[0], Cut(max_pieces=3))}
    assert len(keys) == 6
    assert content_key(l_shape(), Cut()) == content_key(l_shape(), Cut())


def test_a_cache_that_cannot_be_written_is_said(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path / "file"))
    boxes = [trimesh.creation.box((1, 1, 1)), trimesh.creation.box((2, 0.5, 0.5))]
    with pytest.warns(HalfPhysicsWarning, match="cannot be kept.*HALFPHYSICS_CACHE"):
        thing = Scene().add_object("x", trimesh.util.concatenate(boxes), mass=1.0)
    assert len(thing.pieces) == 2


def test_the_cache_keeps_what_was_used_last(tmp_path, monkeypatch):
    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path))
    figures = np.zeros(3)
    piece_cache.write("a", l_pieces(), figures)
    size = (tmp_path / "pieces" / "a.npz").stat().st_size
    monkeypatch.setattr(piece_cache, "MOST_BYTES", 3 * size + size // 2)
    for age, key in ((50, "b"), (40, "c")):
        piece_cache.write(key, l_pieces(), figures)
        os.utime(tmp_path / "pieces" / f"{key}.npz", (age, age))
    os.utime(tmp_path / "pieces" / "a.npz", (10, 10))
    assert piece_cache.read("a") is not None  # used now: the newest
    piece_cache.write("d", l_pieces(), figures)
    assert sorted(path.stem for path in (tmp_path / "pieces").iterdir()) == ["a", "b", "d"]


def test_a_bar_says_that_a_mesh_is_cut(monkeypatch):
    """At a terminal, unasked: it may take minutes. A moment's work says nothing."""
    pytest.importorskip("coacd")
    monkeypatch.setenv("HALFPHYSICS_CACHE", "off")
    said = terminal(monkeypatch)
    decompose(l_shape(), Cut(threshold=0.05))
    assert said.getvalue() == ""
    monkeypatch.setattr(progress, "DELAY", 0.0)
    monkeypatch.setattr(progress, "_EVERY", 0.0)
    decompose(l_shape(), Cut(threshold=0.05))
    assert "cutting a mesh into convex pieces: 100%" in said.getvalue()


@pytest.mark.slow
def test_a_ring_falls_over_a_peg_without_touching_it():
    pytest.importorskip("coacd")
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_static("peg", Box((0.03, 0.03, 0.2)), position=(0, 0, 0.1))
    thing = scene.add_object("ring", ring(), mass=0.1, position=(0, 0, 0.3))
    assert thing.decomposition.outside_mm < 5.0
    tracks, met = run(scene, 0.6)
    assert met == {frozenset(("ring", "floor"))}
    assert np.abs(tracks["ring"][-1, :2]).max() < 2e-3
    assert tracks["ring"][-1, 2] < 0.015  # lies on the floor, around the peg


def test_a_ball_lands_in_a_box_without_a_lid():
    walls = [((0.2, 0.2, 0.01), (0, 0, 0.005))]
    walls += [((0.01, 0.19, 0.1), (s * 0.094, 0, 0.055)) for s in (-1, 1)]
    walls += [((0.17, 0.01, 0.1), (0, s * 0.093, 0.055)) for s in (-1, 1)]
    parts = []
    for size, at in walls:
        parts.append(trimesh.creation.box(size))
        parts[-1].apply_translation(at)
    scene = Scene()
    scene.add_static("floor", Plane())
    bowl = scene.add_object("bowl", trimesh.util.concatenate(parts), mass=1.0)
    assert (len(bowl.pieces), bowl.decomposition.outside_mm) == (5, 0.0)
    scene.add_object("ball", Sphere(0.03), mass=0.05, position=(0.02, 0.01, 0.2))
    tracks, met = run(scene, 1.0)
    assert frozenset(("ball", "bowl")) in met
    inside = tracks["ball"][-1] - tracks["bowl"][-1]
    assert np.abs(inside[:2]).max() < 0.06
    assert inside[2] == pytest.approx(0.04, abs=2e-3)  # on the bottom, 1 cm thick


def test_pieces_that_overlap_where_the_meshes_are_clear_stay_as_they_are():
    """Two Ls whose hulls overlap in the notches: neither pushed apart nor any deeper."""
    scene = Scene(gravity=0.0)
    scene.add_object("a", l_shape(), mass=1.0, pieces="hull")
    scene.add_object("b", Sphere(0.02), mass=1.0, position=(0.15, 0.15, 0.05))
    tracks, _ = run(scene, 0.3)
    for track in tracks.values():
        assert np.abs(track - track[0]).max() < 1e-6


def test_scene_files_carry_how_it_is_cut(tmp_path):
    scene = Scene()
    scene.add_object("own", l_shape(), mass=1.0, pieces=l_pieces())
    scene.add_object("hull", l_shape(), mass=1.0, pieces="hull")
    boxes = trimesh.util.concatenate(
        [trimesh.creation.box((1, 1, 1)), trimesh.creation.box((2, 0.5, 0.5))]
    )
    scene.add_object("auto", boxes, mass=1.0, threshold=0.002, max_pieces=9)
    scene.save(tmp_path / "scene.yaml")
    again = Scene.load(tmp_path / "scene.yaml")
    for name, thing in scene.objects.items():
        assert again.objects[name].cut == thing.cut
        for a, b in zip(thing.pieces, again.objects[name].pieces, strict=True):
            np.testing.assert_array_equal(a.vertices, b.vertices)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pieces": "all"}, "found 'all', expected \"auto\""),
        ({"pieces": 3}, "found int"),
        ({"pieces": []}, "found none"),
        ({"pieces": [3]}, r"pieces\[0\]: found int"),
        ({"pieces": [l_shape()]}, r"pieces\[0\]: is not convex"),
        ({"threshold": 0.0}, "threshold"),
        ({"max_pieces": 0}, "max_pieces"),
        ({"max_pieces": 1.5}, "whole number"),
    ],
)
def test_what_is_refused(options, message):
    with pytest.raises(InputError, match=message):
        Scene().add_object("x", l_shape(), mass=1.0, **options)


def test_own_pieces_of_another_size_are_said():
    small = Mesh(0.5 * l_pieces()[1].vertices, l_pieces()[1].faces)
    with pytest.warns(HalfPhysicsWarning, match="its 1 pieces stick out.*leave up"):
        Scene().add_object("x", l_shape(), mass=1.0, pieces=[small])
    assert decomposition.WARN_MM == 5.0


def cushion():
    """A box of 1.6 by 0.5 by 0.3 m with a seam of 2 cm across its middle, closed."""
    import trimesh

    half = np.array([[-0.25, 0.0], [0.25, 0.0], [0.25, 0.3], [-0.25, 0.3]])
    rings = []
    for x, inset in ((-0.8, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.02, 0.0), (0.8, 0.0)):
        middle = half.mean(axis=0)
        ring = middle + (half - middle) * (1.0 - inset / np.abs(half - middle))
        rings.append(np.column_stack([np.full(4, x), ring]))
    vertices = np.concatenate(rings)
    faces = [[0, 1, 2], [0, 2, 3], [18, 17, 16], [19, 18, 16]]
    for k in range(4):
        for i in range(4):
            a, b = 4 * k + i, 4 * k + (i + 1) % 4
            faces += [[a, a + 4, b], [b, a + 4, b + 4]]
    mesh = trimesh.Trimesh(vertices, faces)
    mesh.fix_normals()
    return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def test_the_seam_of_a_cushion_is_not_cut_unless_it_is_asked_for(monkeypatch):
    seen = decompose(cushion(), Cut())
    assert len(seen.pieces) == 1
    assert seen.outside_mm == pytest.approx(20.0 / np.sqrt(2.0), abs=2.0)  # a groove of 90 degrees
    cut = []

    def halves(solid, threshold, most):  # the engine takes minutes for it
        cut.append((len(solid.faces), threshold, most))
        return [Mesh(part[0], part[1]) for part in (of_box(-0.8, 0.0), of_box(0.0, 0.8))]

    monkeypatch.setattr(decomposition, "pieces_of", halves)
    assert len(decomposition._pieces(cushion(), Cut(threshold=0.0029))) == 2
    assert cut == [(len(cushion().faces), 0.0029, -1)]


def of_box(low, high):
    """Vertices and faces of half of the cushion."""
    import trimesh

    box = trimesh.creation.box((high - low, 0.5, 0.3)).apply_translation(
        [0.5 * (low + high), 0, 0.15]
    )
    return np.asarray(box.vertices), np.asarray(box.faces)

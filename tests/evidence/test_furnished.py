"""Table 2 of the evidence: furnished rooms, visits to them, the section, a user's scenes."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest

import halfphysics as hp
from evidence.model import Options, plain
from evidence.rooms import brought, verify
from evidence.rooms.furniture import KINDS, mesh_of
from evidence.rooms.layout import room
from evidence.rooms.standing import floor, walk_through
from evidence.rooms.visits import visit
from evidence.runs.visiting import WAYS, made
from evidence.sections import table2
from halfphysics import metrics
from halfphysics.errors import FileError, InputError
from halfphysics.geometry.shapes import Mesh

NUMBERS = table2.SCENES


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


def shapes(one):
    return [s.shape for s in one.scene.statics.values() if isinstance(s.shape, Mesh)]


def contents(one, motion):
    arrays = [a for s in shapes(one) for a in (s.vertices, s.faces)]
    return b"".join(a.tobytes() for a in (*arrays, motion.translation, motion.rotations))


def test_same_seed_same_bytes(body):
    def made(number, seed):
        one = room(number, seed)
        return contents(one, visit(one, body, number, seed).motion)

    assert made(3, 0) == made(3, 0)
    assert len({made(3, 0), made(3, 1), made(4, 0)}) == 3


@pytest.fixture(scope="module")
def rooms():
    return [room(number) for number in NUMBERS]


@pytest.mark.slow
def test_rooms_are_furnished_and_differ(rooms):
    assert len(rooms) == 20
    for one in rooms:
        assert 30_000 <= one.triangles <= 100_000
        assert len(one.items) >= 4
        for a, b in itertools.combinations(one.items, 2):
            assert a.at.apart(b.at) > 0.0
        for item in one.items:
            assert all(item.at.apart(wall) > 0.0 for wall in one.walls)
            assert all(np.abs(item.at.place) < 0.5 * np.array(one.size))
    # As modelled: closed meshes, one each. As scanned: one open mesh of many bodies.
    assert {one.scanned for one in rooms} == {False, True}
    assert all(s.closed for s in shapes(rooms[0]))
    assert [len(shapes(one)) for one in rooms[:2]] == [1 + len(rooms[0].items), 1]
    assert not shapes(rooms[1])[0].closed
    assert len({one.size for one in rooms}) == 20


@pytest.mark.parametrize("kind", KINDS)
def test_furniture_is_closed_and_as_large_as_said(kind):
    for size in (KINDS[kind].least, KINDS[kind].most):
        mesh = Mesh(*mesh_of(tuple(KINDS[kind].make(*size)), 0.08))
        assert mesh.closed
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        assert low[2] >= 0.0
        # Head boards and pillows, monitors and plates protrude from beds, desks and cabinets.
        out = {"bed": (0.0, 0.06, 0.46), "desk": (0.0, 0.0, 0.41), "cabinet": (0.02, 0.03, 0.0)}
        spare = np.array(out.get(kind, (0.0, 0.0, 0.0))) + 0.02
        assert (high - low <= np.array(size) + spare).all()
        assert (high - low >= np.array(size) - 0.15).all()


@pytest.mark.slow
def test_visits_start_clear_and_last(body, rooms):
    """All visits are clear at the start, none leaves the ground, and most penetrate something."""
    deep = []
    for number, one in zip(NUMBERS, rooms, strict=True):
        motion = visit(one, body, number).motion
        assert 5.0 <= motion.duration <= 12.0
        assert (np.linalg.norm(np.diff(motion.translation, axis=0), axis=1) * 30.0 < 3.0).all()
        start = metrics.penetration(motion[:2], body, one.scene)
        assert start.deepest[0] == 0.0
        if number % 3 == 0:
            deep.append(metrics.penetration(motion[-2:], body, one.scene).depth_max_mm)
    assert np.mean(np.array(deep) > 20.0) > 0.7


@pytest.mark.slow
def test_a_scene_is_measured_and_verified():
    """The reference penetrates and both judges find it; in our motion neither finds any."""
    arguments = {"number": 9, "seed": 0, "ways": ["ours"], "strip": False, "quick": True}
    values = made(**arguments).values
    again = made(**{**arguments, "ways": ["ours", "peer"]}).values
    peer = again.pop("peer")
    assert json.dumps(plain(values, "")) == json.dumps(plain(again, ""))
    asked, ours = values["asked"], values["ours"]
    assert asked["rate"] > 1.0
    assert asked["max_mm"] > 50.0
    assert 0 < asked["intersecting"] < asked["checked"]
    assert (ours["rate"], ours["mean_mm"], ours["max_mm"]) == (0.0, 0.0, 0.0)
    assert (ours["intersecting"], ours["success"]) == (0, True)
    assert ours["distance_mm"] > 0.1
    assert peer["max_mm"] > 1.0
    assert "library" not in peer


def values_of(**changes):
    way = {
        "rate": 0.0, "mean_mm": 0.0, "max_mm": 0.0, "inside_mm": 0.0, "success": True,
        "local_mm": 2.0, "global_mm": 90.0, "lost_s": 0.0, "library": "coal 3", "checked": 50,
        "intersecting": 0, "distance_mm": 0.98,
    }  # fmt: skip
    asked = {**way, "rate": 7.0, "mean_mm": 60.0, "max_mm": 180.0, "intersecting": 20}
    about = {"items": ["bed"], "uses": "bed", "triangles": 9, "scanned": False}
    ours = {**way, **changes}
    return {"asked": asked, "ours": ours, "paper": way, "room": about, "frames": 90, "fps": 30.0}


def every(**rooms):
    """All rooms pass, except the given ones."""
    return {f"room-{number:02d}": values_of() for number in NUMBERS} | rooms


def judged(values, name=WAYS["ours"][0]):
    rows = table2.content(Options(), values).rows
    row = next(r for r in rows if r.name == name)
    return row, {f.name: f.reproduced for f in row.figures if f.expected}


@pytest.mark.parametrize(
    ("changes", "measure"),
    [
        ({"rate": 1e-6}, "penetration rate"),
        ({"max_mm": 0.001}, "largest depth"),
        ({"intersecting": 1}, "frames that intersect, by coal"),
        ({"success": False}, "success"),
    ],
)
def test_what_is_not_reproduced_is_shown_so(changes, measure):
    """One bad scene of twenty fails the section."""
    _, good = judged(every())
    assert all(good.values())
    _, bad = judged({**every(), "room-01": values_of(**changes)})
    assert [name for name, well in bad.items() if not well] == [measure]


def test_a_scene_that_ended_in_an_error_is_no_success():
    values = every()
    del values["room-07"]
    row, found = judged(values)
    assert found["success"] is False
    assert row.data.startswith("19 of 20 furnished rooms")


@pytest.mark.parametrize(
    ("changes", "measure"),
    [
        ({"rate": 0.0}, "penetration rate"),
        ({"mean_mm": 0.0}, "mean depth"),
        ({"max_mm": 0.0}, "largest depth"),
        ({"intersecting": 0}, "scenes that coal finds out"),
    ],
)
def test_judges_that_see_nothing_are_shown_so(changes, measure):
    """The reference penetrates: otherwise a measure of 0 elsewhere proves nothing."""
    values = every()
    for found in values.values():
        found["asked"] |= changes
    _, bad = judged(values, "reference")
    assert [name for name, well in bad.items() if not well] == [measure]
    values = every()
    values["room-03"]["asked"]["intersecting"] = 0
    assert judged(values, "reference")[1]["scenes that coal finds out"] is False


def test_without_the_library_it_says_so():
    values = values_of()
    for way in ("asked", "ours"):
        for key in ("library", "checked", "intersecting", "distance_mm"):
            del values[way][key]
    row, found = judged({"room-00": values})
    assert found["frames that intersect, by coal"] is None
    assert judged({"room-00": values}, "reference")[1]["scenes that coal finds out"] is None
    assert verify.MISSING in row.note


def test_tasks():
    full, quick = table2.tasks(Options()), table2.tasks(Options(quick=True, seed=5))
    assert len(full) == 20
    assert 3 <= len(quick) <= 4
    assert {t.arguments["seed"] for t in quick} == {5}
    assert sum(t.seconds for t in full) < 360.0


# -- the user's scenes ---------------------------------------------------------------------


def scan(number):
    return shapes(room(number))[0]


def test_floor():
    one = scan(1)
    assert floor(one) == pytest.approx(0.0, abs=1e-6)
    assert floor(Mesh(one.vertices - np.array([0.0, 0.0, 1.3]), one.faces)) == pytest.approx(-1.3)
    # A free-standing piece has none; nor does a table.
    assert floor(Mesh(*mesh_of(tuple(KINDS["table"].make(0.9, 1.6, 0.75)), 0.1))) is None


@pytest.mark.slow
@pytest.mark.parametrize("height", [0.0, -2.5])
def test_a_walk_begins_and_ends_clear(body, height):
    one = scan(1)
    moved = Mesh(one.vertices + np.array([7.0, -3.0, height]), one.faces)
    sequence = walk_through(moved, body, 4)
    ends = sequence.motion[:: len(sequence.motion) - 1]
    assert metrics.penetration(ends, body, sequence.scene).depth_max_mm == 0.0
    low = body.vertices(sequence.motion[0])[:, 2].min()
    assert height < low < height + 0.06
    again = walk_through(moved, body, 4)
    assert again.motion.translation.tobytes() == sequence.motion.translation.tobytes()


def test_a_scene_in_other_units_is_refused(body):
    one = scan(1)
    with pytest.raises(InputError, match="is it in metres"):
        walk_through(Mesh(1000.0 * one.vertices, one.faces), body, 0)


@pytest.fixture
def folder(tmp_path, body):
    """A scan, a piece of furniture, a file without a mesh, a motion without a scene, a text."""
    import trimesh

    one = scan(3)
    trimesh.Trimesh(one.vertices, one.faces, process=False).export(tmp_path / "a.ply")
    (tmp_path / "office_0" / "habitat").mkdir(parents=True)
    couch = mesh_of(tuple(KINDS["sofa"].make(0.9, 1.8, 0.85)), 0.1)
    for path in ("mesh.ply", "habitat/mesh_semantic.ply"):
        trimesh.Trimesh(*couch, process=False).export(tmp_path / "office_0" / path)
    (tmp_path / "broken.glb").write_bytes(b"glTF nothing")
    (tmp_path / "broken.pkl").write_bytes(b"\x80\x04 nothing")
    visit(room(3), body, 3).motion.save(tmp_path / "walk.npz")
    (tmp_path / "readme.txt").write_text("scenes")
    return tmp_path


@pytest.mark.slow
def test_scenes_of_the_user(folder):
    tasks = brought.tasks(Options(data={"scenes": folder}))
    names = [(task.key, task.arguments["path"]) for task in tasks]
    assert [key.split("-", 2)[2] for key, _ in names] == [
        "a", "broken", "broken", "office_0-mesh", "walk",
    ]  # fmt: skip
    assert all(task.inputs == (path,) for task, (_, path) in zip(tasks, names, strict=True))
    values, causes = {}, {}
    for task in tasks:
        try:
            quick = {**task.arguments, "quick": True}
            values[task.key] = brought.brought(**quick).values
        except FileError as error:
            causes[task.key] = str(error)
    assert list(values) == ["scene-00-a", "scene-03-office_0-mesh"]
    for found in values.values():
        assert found["asked"]["max_mm"] > 0.0
        assert found["ours"]["max_mm"] == 0.0
        assert found["ours"]["intersecting"] == 0
    assert "broken.glb" in causes["scene-01-broken"]
    assert "broken.pkl" in causes["scene-02-broken"]
    assert "a motion without a scene" in causes["scene-04-walk"]
    rows = table2.content(Options(), values).rows
    assert {"scene-00-a", "scene-03-office_0-mesh"} <= {row.name for row in rows}


def test_a_folder_without_scenes(tmp_path):
    (tmp_path / "readme.txt").write_text("nothing")
    with pytest.raises(FileError, match="no scene in it"):
        brought.tasks(Options(data={"scenes": tmp_path}))


def test_furniture_of_others(shared_data):
    """An open scan of several bodies, on its side as its axis is unknown: it is still played."""
    path = shared_data / "meshes" / "kaykit_furniture" / "couch.obj"
    found = brought.brought(str(path), None, 0, True).values
    assert found["ours"]["rate"] == 0.0
    assert found["ours"]["intersecting"] == 0

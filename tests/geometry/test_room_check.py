"""Units and the up axis of static meshes by content: authored rooms, and furniture from files."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_files import load_mesh, turned
from halfphysics.geometry.room_check import doubts
from support.paths import ROOT

MESHES = ROOT.parent / "shared" / "data" / "meshes"
#: Corners of a box from two bits each, and its sides as pairs of triangles.
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SIDES = {
    "-x": (0, 1, 3, 2), "+x": (4, 6, 7, 5), "-y": (0, 4, 5, 1),
    "+y": (2, 3, 7, 6), "-z": (0, 2, 6, 4), "+z": (1, 5, 7, 3),
}  # fmt: skip


def box(low, high, sides=tuple(SIDES)):
    faces = [t for s in sides for a, b, c, d in [SIDES[s]] for t in ((a, b, c), (a, c, d))]
    low, high = np.asarray(low, float), np.asarray(high, float)
    return low + CORNERS * (high - low), np.array(faces)


def room(low, high, sides=tuple(SIDES)):
    """Sides of a room in z-up metres with a table and a cupboard in it."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    table, cupboard = low + np.array((1.0, 1.0, 0.7)), low + np.array((0.1, 0.1, 0.0))
    parts = [
        box(low, high, sides),
        box(table, table + np.array((1.2, 0.8, 0.05))),
        box(cupboard, cupboard + np.array((0.6, 1.0, 1.9))),
    ]
    starts = np.cumsum([0, *(len(v) for v, _ in parts)])[:-1]
    faces = [f + start for (_, f), start in zip(parts, starts, strict=True)]
    return Mesh(np.vstack([v for v, _ in parts]), np.vstack(faces))


def y_up(mesh):
    """The same in a file with y up: (x, y, z) as (x, z, -y)."""
    x, y, z = mesh.vertices.T
    return Mesh(np.stack([x, z, -y], axis=1), mesh.faces)


OPEN = ("-z", "-x", "-y")  # a scan: floor and two walls
ROOMS = {
    "closed, about zero": room((-3, -2, 0), (3, 2, 2.6)),
    "closed, from a corner": room((0, 0, 0), (6, 4, 2.6)),
    "open, about zero": room((-3, -2, 0), (3, 2, 2.6), OPEN),
    "open, somewhere": room((1.3, -7.1, -0.6), (6.3, -3.1, 1.8), ("-z", "-x", "+x")),
    "corridor": room((0, 0, 0), (12, 1.6, 2.5)),
    "narrow corridor about zero": room((-6, -0.8, 0), (6, 0.8, 2.5)),
    "tall hall": room((-5, -4, 0), (5, 4, 12)),
    "basement": room((0, 0, -3), (4, 3, 0)),
    "a floor alone": room((-4, -3, 0), (4, 3, 2.0), ("-z",)),
    "a wall": Mesh(*box((-2, -0.1, 0), (2, 0.1, 2.5))),
    "an open wall": Mesh(*box((-2, 0, 0), (2, 0.2, 2.5), ("-x", "+x", "-y", "+y"))),
    "ground of a town": Mesh(*box((-300, -300, 0), (300, 300, 40))),
}


@pytest.mark.parametrize("name", ROOMS)
@pytest.mark.parametrize("suffix_up", ["z", "y"])
def test_rooms_that_are_read_rightly_are_in_no_doubt(name, suffix_up):
    found = doubts(ROOMS[name], suffix_up)
    assert (found.unit, found.up) == (None, None)


@pytest.mark.parametrize("name", ["closed, about zero", "open, about zero", "open, somewhere"])
def test_rooms_with_another_axis_up(name):
    """Of a file that has y up and no standard that says so, and of a glTF file that has z up."""
    file = y_up(ROOMS[name])
    assert doubts(turned(file, scale=1.0, up="z"), "z").up == "y"
    assert doubts(turned(ROOMS[name], scale=1.0, up="y"), "y").up == "z"
    assert doubts(turned(file, scale=1.0, up="y"), "y").up is None


@pytest.mark.parametrize(
    ("per_metre", "unit"), [(100.0, (0.01, "centimetres")), (1000.0, (0.001, "millimetres"))]
)
@pytest.mark.parametrize("name", [name for name in ROOMS if "corridor" in name or "clos" in name])
def test_rooms_in_other_units(name, per_metre, unit):
    """In the other unit as in metres, the right way up or not."""
    mesh = turned(ROOMS[name], scale=per_metre, up="z")
    assert doubts(mesh, "z").unit == unit
    assert doubts(mesh, "z").up is None
    if "about zero" in name and "narrow" not in name:
        both = doubts(turned(y_up(ROOMS[name]), scale=per_metre, up="z"), "z")
        assert (both.unit, both.up) == (unit, "y")


@pytest.mark.skipif(not MESHES.is_dir(), reason="the shared data is not here")
def test_furniture_from_files():
    """All of it has y up: said as such nothing is in doubt, and what is in doubt is right."""
    files = sorted(MESHES.rglob("*.obj"))
    assert len(files) > 15
    wrong, noticed = [], 0
    for path in files:
        mesh, source = load_mesh(path, scale=0.7, up="y")
        said = doubts(mesh, source.up)
        # Some begin at zero along two axes, and are in doubt where nobody says which is up.
        if said.unit is not None:
            wrong.append(path.name)
        found = doubts(*((one := load_mesh(path))[0], one[1].up))
        assert found.unit is None, path.name
        assert found.up in (None, "y")
        noticed += found.up == "y"
    assert wrong == []
    assert noticed >= 12

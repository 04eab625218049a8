"""Units and the up axis of static meshes by content: authored rooms, and furniture from files."""

from __future__ import annotations

import pytest

from halfphysics.geometry.mesh_files import load_mesh, turned
from halfphysics.geometry.room_check import doubts
from support.boxed_rooms import ROOMS, y_up
from support.paths import ROOT

MESHES = ROOT.parent / "shared" / "data" / "meshes"


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

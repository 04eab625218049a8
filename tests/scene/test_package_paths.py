"""Meshes that a URDF names by package, as ROS does."""

import os

import numpy as np
import pytest
import trimesh

from halfphysics import Scene
from halfphysics.errors import FileError, InputError

SIZE = (0.2, 0.1, 0.4)
#: Meshes are in single precision, here and in MuJoCo [m].
SINGLE = 1e-6
INERTIAL = """<inertial><mass value="1"/>
<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>"""
#: The picture of its arm is in a format that nobody reads, and not there.
URDF = f"""<robot name="r"><link name="base">{INERTIAL}</link>
<link name="arm">{INERTIAL}
<visual><geometry><mesh filename="package://r/none.dae"/></geometry></visual>
<collision><geometry><mesh filename="{{mesh}}"/></geometry></collision></link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
</joint></robot>"""


def put(folder, mesh_at, urdf_at, name):
    """A box as a mesh, and a robot that names it; the path of the robot."""
    mesh, urdf = folder / mesh_at, folder / urdf_at
    for path in (mesh, urdf):
        path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box(SIZE).export(mesh)
    urdf.write_text(URDF.format(mesh=name))
    return urdf


def extents(urdf):
    """Of the arm's mesh, in the arm's frame (3,) [m]."""
    scene = Scene()
    scene.add_articulated("robot", urdf)
    return np.ptp(scene.articulated["robot"].links[-1].mesh()[0], axis=0)


@pytest.mark.parametrize(
    ("mesh_at", "urdf_at", "name"),
    [
        ("ws/arm/meshes/a.stl", "ws/arm/urdf/arm.urdf", "package://arm/meshes/a.stl"),
        ("ws/arm/meshes/a.stl", "ws/arm/arm.urdf", "package://arm/meshes/a.stl"),
        ("ws/parts/a.stl", "ws/arm/urdf/arm.urdf", "package://parts/a.stl"),
        ("arm-main/meshes/a b.stl", "arm-main/urdf/arm.urdf", "package://arm/meshes/a%20b.stl"),
        ("arm-main/a.stl", "arm-main/arm.urdf", "model://arm/a.stl"),
        ("[arm/meshes/a.stl", "[arm/arm.urdf", "package://[arm/meshes/a.stl"),
        ("arm/meshes/a#1.stl", "arm/arm.urdf", "package://arm/meshes/a#1.stl"),
        ("arm/meshes/a?b.stl", "arm/arm.urdf", "package://arm/meshes/a?b.stl"),
        ("arm/meshes/a%20b.stl", "arm/arm.urdf", "package://arm/meshes/a%20b.stl"),
        ("my arm/a.stl", "ws/arm.urdf", "package://my%20arm/a.stl"),
        ("arm/meshes/a.stl", "arm/urdf/arm.urdf", "package://arm/urdf/../meshes/a.stl"),
    ],
)
def test_a_package_is_a_folder_above_or_beside_the_file(tmp_path, mesh_at, urdf_at, name):
    np.testing.assert_allclose(extents(put(tmp_path, mesh_at, urdf_at, name)), SIZE, atol=SINGLE)


def test_a_package_of_the_name_comes_before_others(tmp_path):
    urdf = put(tmp_path, "parts/a.stl", "robot/urdf/a.urdf", "package://parts/a.stl")
    other = tmp_path / "robot" / "a.stl"
    trimesh.creation.box((1, 1, 1)).export(other)
    np.testing.assert_allclose(extents(urdf), SIZE, atol=SINGLE)


def test_whole_paths_are_taken(tmp_path):
    name = (tmp_path / "far" / "a.stl").as_uri()
    urdf = put(tmp_path, "far/a.stl", "robot/a.urdf", name)
    np.testing.assert_allclose(extents(urdf), SIZE, atol=SINGLE)


def test_a_whole_path_is_taken_as_written_too(tmp_path):
    urdf = put(tmp_path, "far/a#1%20.stl", "robot/a.urdf", f"file://{tmp_path}/far/a#1%20.stl")
    np.testing.assert_allclose(extents(urdf), SIZE, atol=SINGLE)


def test_who_tells_mujoco_to_strip_paths_is_obeyed(tmp_path):
    urdf = put(tmp_path, "robot/parts/a.stl", "robot/a.urdf", "package://arm/meshes/a.stl")
    strip = '<mujoco><compiler meshdir="parts" strippath="true"/></mujoco></robot>'
    urdf.write_text(urdf.read_text().replace("</robot>", strip))
    np.testing.assert_allclose(extents(urdf), SIZE, atol=SINGLE)


def test_what_is_not_there_is_said(tmp_path):
    urdf = put(tmp_path, "other/a.stl", "robot/a.urdf", "package://arm/meshes/a.stl")
    with pytest.raises(FileError, match=r"'package://arm/meshes/a\.stl' is not there.*'arm'"):
        Scene().add_articulated("robot", urdf)
    with pytest.raises(InputError, match="text that has no folder"):
        Scene().add_articulated("robot", urdf.read_text())


@pytest.mark.parametrize("name", ["[arm/b.stl", "[arm]/b.stl", "arm/a%00.stl"])
def test_names_that_no_file_has_end_in_a_message(tmp_path, name):
    urdf = put(tmp_path, "arm/a.stl", "arm/a.urdf", f"package://{name}")
    with pytest.raises(FileError, match="is not there; expected the folder"):
        Scene().add_articulated("robot", urdf)


def test_a_picture_of_an_impossible_name_is_not_used(tmp_path):
    urdf = put(tmp_path, "arm/a.stl", "arm/a.urdf", "package://arm/a.stl")
    urdf.write_text(urdf.read_text().replace("r/none.dae", "[r/none.dae"))
    np.testing.assert_allclose(extents(urdf), SIZE, atol=SINGLE)


def test_of_a_whole_path_the_one_place_is_said(tmp_path):
    urdf = put(tmp_path, "arm/a.stl", "arm/a.urdf", "file:///nowhere/x%20y.stl")
    with pytest.raises(FileError, match=r"expected a file at /nowhere/x y\.stl\. "):
        Scene().add_articulated("robot", urdf)


@pytest.mark.parametrize(
    "name",
    ["arm/../a.stl", "arm/../../far/a.stl", "arm/urdf/../../../a.stl", "arm/%2e%2e/a.stl",
     "../a.stl"],
)  # fmt: skip
def test_a_path_that_leaves_its_package_is_refused(tmp_path, name):
    urdf = put(tmp_path, "ws/a.stl", "ws/arm/a.urdf", f"package://{name}")
    for other in ("a.stl", "far/a.stl"):
        put(tmp_path, other, "ws/arm/a.urdf", f"package://{name}")
    with pytest.raises(FileError, match=r"is outside its package.*expected a path without '\.\.'"):
        Scene().add_articulated("robot", urdf)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_a_pipe_is_not_read(tmp_path):
    urdf = put(tmp_path, "arm/b.stl", "arm/a.urdf", "package://arm/a.stl")
    os.mkfifo(tmp_path / "arm" / "a.stl")
    with pytest.raises(InputError, match="is a pipe"):
        Scene().add_articulated("robot", urdf)

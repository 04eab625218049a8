"""MJCF and URDF that include themselves, or ask for gigabytes and devices."""

from __future__ import annotations

import os
from pathlib import Path

from support.files.hostile.attacks import attack, written

_BODY = '<body><joint name="j"/><geom size="1"/></body>'


def _mjcf(folder: Path, text: str, name: str = "a.xml") -> Path:
    return written(folder / name, f"<mujoco>{text}</mujoco>")


@attack("articulated")
def mjcf_that_attaches_itself(folder: Path) -> Path:
    return _mjcf(
        folder,
        '<asset><model name="me" file="a.xml"/></asset>'
        f'<worldbody>{_BODY}<body name="b"><attach model="me" body="b" prefix="x"/></body>'
        "</worldbody>",
    )


@attack("articulated")
def mjcf_that_attaches_another_that_attaches_it(folder: Path) -> Path:
    for name, other in (("a.xml", "b.xml"), ("b.xml", "a.xml")):
        _mjcf(
            folder,
            f'<asset><model name="me" file="{other}"/></asset>'
            f'<worldbody>{_BODY}<body name="b"><attach model="me" body="b" prefix="x"/></body>'
            "</worldbody>",
            name,
        )
    return folder / "a.xml"


@attack("articulated")
def mjcf_that_includes_itself(folder: Path) -> Path:
    return _mjcf(folder, f'<worldbody>{_BODY}</worldbody><include file="a.xml"/>')


@attack("articulated")
def mjcf_that_includes_another_that_includes_it(folder: Path) -> Path:
    _mjcf(folder, '<include file="a.xml"/>', "b.xml")
    return _mjcf(folder, f'<worldbody>{_BODY}</worldbody><include file="b.xml"/>')


@attack("articulated")
def mjcf_of_includes_by_squares(folder: Path) -> Path:
    """Each file includes the next ten times over: 10^8 in all."""
    for k in range(8):
        _mjcf(folder, f'<worldbody><include file="{k + 1}.xml"/></worldbody>' * 10, f"{k}.xml")
    _mjcf(folder, f"<worldbody>{_BODY}</worldbody>", "8.xml")
    return folder / "0.xml"


@attack("articulated")
def mjcf_of_copies_of_copies(folder: Path) -> Path:
    inner = '<body><joint type="ball"/><geom size=".1"/></body>'
    for _ in range(6):
        inner = f'<replicate count="1000" offset="0 0 .001">{inner}</replicate>'
    return _mjcf(folder, f"<worldbody>{inner}</worldbody>")


@attack("articulated")
def mjcf_of_a_cloth_of_10_000_points_squared(folder: Path) -> Path:
    return _mjcf(
        folder,
        f'<worldbody>{_BODY}<flexcomp name="f" type="grid" count="10000 10000 1" '
        'spacing=".1 .1 .1" dim="2"/></worldbody>',
    )


@attack("articulated")
def mjcf_of_a_gigabyte_of_stack(folder: Path) -> Path:
    return _mjcf(folder, f'<size memory="900G"/><worldbody>{_BODY}</worldbody>')


@attack("articulated")
def mjcf_nested(folder: Path) -> Path:
    depth = 100_000
    return _mjcf(folder, f"<worldbody>{'<body>' * depth}{'</body>' * depth}</worldbody>")


@attack("articulated")
def mjcf_of_5_000_bodies_in_a_chain(folder: Path) -> Path:
    depth = 450
    one = '<body pos="0 0 .1"><joint/><geom size=".01"/>'
    return _mjcf(folder, f"<worldbody>{(one * depth + '</body>' * depth) * 12}</worldbody>")


@attack("articulated")
def mjcf_with_a_device_for_a_mesh(folder: Path) -> Path:
    return _mjcf(
        folder,
        '<asset><mesh name="m" file="/dev/zero" content_type="model/stl"/></asset>'
        '<worldbody><body><joint/><geom type="mesh" mesh="m"/></body></worldbody>',
    )


@attack("articulated")
def mjcf_with_a_pipe_for_a_mesh(folder: Path) -> Path:
    os.mkfifo(folder / "m.stl")
    return _mjcf(
        folder,
        '<asset><mesh name="m" file="m.stl"/></asset>'
        '<worldbody><body><joint/><geom type="mesh" mesh="m"/></body></worldbody>',
    )


@attack("articulated")
def mjcf_with_a_pipe_for_a_texture(folder: Path) -> Path:
    os.mkfifo(folder / "t.png")
    return _mjcf(
        folder,
        f'<asset><texture name="t" type="2d" file="t.png"/></asset><worldbody>{_BODY}</worldbody>',
    )


@attack("articulated")
def mjcf_with_a_texture_of_gigabytes(folder: Path) -> Path:
    return _mjcf(
        folder,
        '<asset><texture name="t" type="2d" builtin="flat" width="60000" height="60000"/></asset>'
        f"<worldbody>{_BODY}</worldbody>",
    )


@attack("articulated")
def mjcf_of_entities(folder: Path) -> Path:
    lines = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10 if k else "x"}">' for k in range(12))
    return written(folder / "a.xml", f"<!DOCTYPE a [{lines}]><mujoco model='&e11;'/>")


@attack("articulated")
def urdf_of_a_chain_of_5_000_links(folder: Path) -> Path:
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    links = "".join(
        f'<link name="l{k}"><inertial><mass value="1"/>{inertia}</inertial></link>'
        for k in range(5000)
    )
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="l{k}"/><child link="l{k + 1}"/>'
        '<axis xyz="0 0 1"/></joint>'
        for k in range(4999)
    )
    return written(folder / "a.urdf", f"<robot name='r'>{links}{joints}</robot>")


@attack("articulated")
def urdf_of_a_chain_of_5_000_rigid_links(folder: Path) -> Path:
    links = "".join(f'<link name="l{k}"/>' for k in range(5000))
    joints = "".join(
        f'<joint name="j{k}" type="{"continuous" if k % 2 else "fixed"}"><parent link="l{k}"/>'
        f'<child link="l{k + 1}"/></joint>'
        for k in range(4999)
    )
    return written(folder / "a.urdf", f"<robot name='r'>{links}{joints}</robot>")


@attack("articulated")
def urdf_whose_links_are_in_a_ring(folder: Path) -> Path:
    links = "".join(
        f'<link name="l{k}"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for k in range(3)
    )
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="l{k}"/>'
        f'<child link="l{(k + 1) % 3}"/></joint>'
        for k in range(3)
    )
    return written(folder / "a.urdf", f"<robot name='r'>{links}{joints}</robot>")

"""Files that a stranger made to hang, fill or kill the process that reads them; small on disk.

`ATTACKS`: name -> function (folder) -> path of the file, by what opens it. Each must end in one
error of ours within 5 s and 1 GB (`tests/formats/test_hostile.py`).
"""

from __future__ import annotations

import base64
import bz2
import io
import json
import lzma
import os
import pickle
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from support.files.dumps import Tensor, torch_saved

Builder = Callable[[Path], Path]

#: What opens the file -> name of the attack -> what makes it.
ATTACKS: dict[str, dict[str, Builder]] = {
    "motion": {}, "scene": {}, "articulated": {}, "mesh": {}, "body": {},
}  # fmt: skip


def attack(opened_by: str) -> Callable[[Builder], Builder]:
    def add(build: Builder) -> Builder:
        ATTACKS[opened_by][build.__name__] = build
        return build

    return add


def _written(path: Path, content: bytes | str) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def _pickled(opened_by: str, name: str, program: bytes) -> None:
    ATTACKS[opened_by][name] = lambda folder: _written(folder / "a.pkl", b"\x80\x04" + program)


# -- pickles -------------------------------------------------------------------------------------

_FROZEN = b"cbuiltins\nfrozenset\n"
_ENCODE = b"c_codecs\nencode\n"


def _text(text: str) -> bytes:
    raw = text.encode()
    return b"X" + struct.pack("<I", len(raw)) + raw


def _put(slot: int) -> bytes:
    return b"r" + struct.pack("<I", slot)


def _get(slot: int) -> bytes:
    return b"j" + struct.pack("<I", slot)


#: frozenset({a, frozenset({a})}) of the one before, 60 times: 2^60 ways down to the first.
_pickled(
    "motion",
    "frozensets_in_frozensets",
    b"(\x91" + _put(0) + b"0"
    + b"".join(
        b"(" + _get(k) + b"(" + _get(k) + b"K\x01\x91\x91" + _put(k + 1) + b"0"
        for k in range(60)
    )
    + _get(60) + b".",
)  # fmt: skip
_pickled(
    "motion",
    "frozensets_called",
    _FROZEN + _put(999) + b")R" + _put(0) + b"0"
    + b"".join(
        _get(999) + b"(" + _get(k) + _get(999) + b"(" + _get(k) + b"l\x85Rl\x85R" + _put(k + 1)
        + b"0"
        for k in range(60)
    )
    + _get(60) + b".",
)  # fmt: skip
#: A key of a dict that is a tuple of the one before twice, 100 times: its hash takes 2^100 steps.
_KEY = (
    b"K\x01" + _put(0) + b"0"
    + b"".join(_get(k) + _get(k) + b"\x86" + _put(k + 1) + b"0" for k in range(100))
    + _get(100)
)  # fmt: skip
_pickled("motion", "tuples_as_key", b"}" + _KEY + b"K\x01s.")
_pickled("motion", "tuples_as_keys", b"}(" + _KEY + b"K\x01u.")
_pickled("motion", "tuples_in_a_set", b"\x8f(" + _KEY + b"\x90.")
_pickled("motion", "tuples_in_a_dict_called", b"cbuiltins\ndict\n(" + _KEY + b"K\x01\x86l\x85R.")
#: A tuple in a tuple, 300,000 deep, as a key: the hash goes down on the stack of C.
_pickled("motion", "deep_tuple_as_key", b"})" + b"\x85" * 300_000 + b"K\x01s.")
#: Whole numbers of one hash: 60,000 of them take 2 * 10^9 comparisons.
_pickled(
    "motion",
    "keys_of_one_hash",
    b"}(" + b"".join(pickle.dumps(k * (2**61 - 1), 2)[2:-1] + b"N" for k in range(60_000)) + b"u.",
)
#: A list of 10^5 numbers, copied 10^5 times.
_BASE = b"](" + b"K\x01" * 100_000 + b"e" + _put(0) + b"0"
for _name, _kind in (("lists", b"list"), ("tuples", b"tuple")):
    _pickled(
        "motion",
        f"{_name}_by_squares",
        _BASE + b"cbuiltins\n" + _kind + b"\n" + _put(1) + b"0]("
        + (_get(1) + _get(0) + b"\x85R") * 100_000 + b"e.",
    )  # fmt: skip
_pickled(
    "motion",
    "tuples_made_new",
    _BASE + b"cbuiltins\ntuple\n" + _put(1) + b"0](" + (_get(1) + _get(0) + b"\x85\x81") * 100_000
    + b"e.",
)  # fmt: skip
_pickled(
    "motion",
    "encode_by_squares",
    _text("x" * 100_000) + _put(0) + b"0" + _ENCODE + _put(1) + b"0]("
    + (_get(1) + _get(0) + b"\x85R") * 100_000 + b"e.",
)  # fmt: skip
_pickled(
    "motion",
    "bytearrays_by_squares",
    _text("x" * 100_000) + _put(0) + b"0cbuiltins\nbytearray\n" + _put(1) + b"0]("
    + (_get(1) + _get(0) + b"\x85R") * 100_000 + b"e.",
)  # fmt: skip
#: Lists of references to lists of references: 10^12 numbers once somebody unfolds them.
_UNFOLDS = (
    b"](" + b"K\x01" * 1000 + b"e" + _put(0) + b"0"
    + b"".join(b"](" + _get(k) * 1000 + b"e" + _put(k + 1) + b"0" for k in range(3))
    + _get(3)
)  # fmt: skip
_pickled("motion", "lists_that_unfold", b"}" + _text("poses") + _UNFOLDS + b"s.")
_pickled(
    "motion",
    "lists_that_unfold_as_fields",
    b"}("
    + b"".join(
        _text(key) + (_UNFOLDS if n == 0 else _get(3))
        for n, key in enumerate(("smpl_poses", "smpl_trans", "smpl_scaling"))
    )
    + b"u.",
)
#: One array of a megabyte, in a list a hundred thousand times.
_pickled(
    "motion",
    "an_array_many_times",
    b"}" + _text("smpl_poses") + b"](" + pickle.dumps(np.zeros(2**17), 2)[2:-1] + _put(9999)
    + _get(9999) * 100_000 + b"es.",
)  # fmt: skip
#: The bytes of one array, made into an array again and again.
_STATE = pickle.dumps(bytes(2**20), 4)[2:-1]
_pickled(
    "motion",
    "arrays_of_the_same_bytes",
    _STATE + _put(8000) + b"0cnumpy.core.numeric\n_frombuffer\n" + _put(8001) + b"0"
    + pickle.dumps(np.dtype("u1"), 2)[2:-1] + _put(8002) + b"0]("
    + (_get(8001) + b"(" + _get(8000) + _get(8002) + b"J\x00\x00\x10\x00U\x01CtR") * 100_000
    + b"e.",
)  # fmt: skip
#: Named so often that each naming costs a class.
_pickled("motion", "names_of_chumpy", b"](" + b"cchumpy.ch\nCh\n)\x81" * 100_000 + b"e.")
_pickled(
    "motion",
    "many_names_of_chumpy",
    b"](" + b"".join(b"cchumpy.ch\nC%d\n)\x81" % k for k in range(100_000)) + b"e.",
)


def _chumpy(state: bytes) -> bytes:
    return b"cchumpy.ch\nCh\n)\x81" + state + b"b"


#: chumpy arrays of lists that unfold, of one another, selections of selections.
_pickled("body", "chumpy_that_unfolds", _chumpy(b"}" + _text("x") + _UNFOLDS + b"s") + b".")
_pickled(
    "body",
    "chumpy_in_chumpy",
    pickle.dumps(np.zeros(2**19), 2)[2:-1] + _put(9999) + b"0"
    + b"".join(
        _chumpy(b"}" + _text("x") + (_get(9999) if k == 0 else _get(10_000 + k - 1)) + b"s")
        + _put(10_000 + k) + b"0"
        for k in range(250)
    )
    + _get(10_249) + b".",
)  # fmt: skip
_pickled(
    "body",
    "chumpy_selections",
    pickle.dumps(np.zeros(2**19), 2)[2:-1] + _put(9999) + b"0"
    + pickle.dumps(np.zeros(2**19, np.int64), 2)[2:-1] + _put(9998) + b"0]("
    + (
        b"cchumpy.reordering\nSelect\n)\x81}(" + _text("a") + _get(9999)
        + _text("idxs") + _get(9998) + b"ub"
    ) * 5000
    + b"e.",
)  # fmt: skip


@attack("body")
def sparse_matrices_of_a_gigabyte(folder: Path) -> Path:
    import scipy.sparse as sp

    each = [sp.coo_matrix(([1.0], ([k], [0])), shape=(10_000, 10_000)) for k in range(30)]
    return _written(folder / "a.pkl", pickle.dumps(each, 2))


# -- packed --------------------------------------------------------------------------------------


def _gzip() -> bytes:
    """3 GiB of zeros behind the start of a pickle: full blocks of deflate repeat."""
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    head = packer.compress(b"\x80\x04B\x00\x00\x00\xc0") + packer.flush(zlib.Z_FULL_FLUSH)
    one = packer.compress(bytes(2**24)) + packer.flush(zlib.Z_FULL_FLUSH)
    return head + one * 192


@attack("motion")
def gzip_of_3_gigabytes(folder: Path) -> Path:
    return _written(folder / "a.pkl", _gzip())


@attack("motion")
def bz2_of_zeros(folder: Path) -> Path:
    packer = bz2.BZ2Compressor()
    return _written(folder / "a.pkl", packer.compress(bytes(160 * 2**20)) + packer.flush())


@attack("motion")
def xz_of_zeros(folder: Path) -> Path:
    packer = lzma.LZMACompressor(preset=0)
    content = packer.compress(bytes(160 * 2**20)) + packer.flush()
    return _written(folder / "a.pkl", content)


@attack("motion")
def lzma_with_a_dictionary_of_4_gigabytes(folder: Path) -> Path:
    content = bytearray(lzma.compress(bytes(100), lzma.FORMAT_ALONE))
    content[1:5] = b"\xff\xff\xff\xff"
    content[0:3] = b"]\x00\x00"
    content[3:5] = b"\x00\xf0"
    return _written(folder / "a.pkl", bytes(content))


def _npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, array)
    return stream.getvalue()


def _amass(folder: Path, more: dict[str, bytes], without: tuple[str, ...] = ()) -> Path:
    path = folder / "a.npz"
    fields = {
        "trans": np.zeros((4, 3)), "poses": np.zeros((4, 165)), "betas": np.zeros(10),
        "gender": np.array("neutral"), "mocap_frame_rate": np.array(30.0),
    }  # fmt: skip
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for key, array in fields.items():
            if key not in more and key not in without:
                archive.writestr(f"{key}.npy", _npy(array))
        for key, content in more.items():
            archive.writestr(f"{key}.npy", content)
    return path


def _zeros(folder: Path, key: str, shape: tuple[int, ...]) -> Path:
    path = _amass(folder, {}, (key,))
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open(f"{key}.npy", "w", force_zip64=True) as stream,
    ):
        head = {"descr": "<f8", "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(stream, head)
        left = 8 * int(np.prod(shape))
        while left:
            left -= stream.write(bytes(min(left, 2**22)))
    return path


@attack("motion")
def npz_with_800_megabytes_of_betas(folder: Path) -> Path:
    return _zeros(folder, "betas", (100_000_000,))


@attack("motion")
def npz_with_200_megabytes_of_betas(folder: Path) -> Path:
    """Zeros that may be there, in a place where they may not."""
    return _zeros(folder, "betas", (25_000_000,))


@attack("motion")
def npz_with_200_megabytes_of_rate(folder: Path) -> Path:
    return _zeros(folder, "mocap_frame_rate", (25_000_000,))


@attack("motion")
def npz_with_200_megabytes_of_gender(folder: Path) -> Path:
    return _zeros(folder, "gender", (25_000_000,))


@attack("motion")
def npz_of_20_000_members(folder: Path) -> Path:
    return _amass(folder, {f"k{k:05}": _npy(np.zeros(1)) for k in range(20_000)})


@attack("motion")
def npz_of_one_member_4_096_times(folder: Path) -> Path:
    """4,096 lines of the directory for one array of 2 MB."""
    path = _amass(folder, {"big": _npy(np.zeros(2**18))})
    raw = path.read_bytes()
    first = raw.index(b"PK\x01\x02")
    end = raw.index(b"PK\x05\x06")
    last = raw.rindex(b"PK\x01\x02", 0, end)
    lines, line = raw[first:last], raw[last:end]
    many = b"".join(line[:46] + (b"%03x.npy" % k)[:7] + line[53:] for k in range(4096))
    directory = lines + many
    tail = struct.pack(
        "<4s4H2LH", b"PK\x05\x06", 0, 0, (5 + 4096) & 0xFFFF, 5 + 4096, len(directory), first, 0
    )
    return _written(path, raw[:first] + directory + tail)


@attack("motion")
def npy_of_objects_that_unfold(folder: Path) -> Path:
    path = folder / "a.npy"
    head = b"{'descr': '|O', 'fortran_order': False, 'shape': (), }\n"
    magic = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
    return _written(path, magic + b"\x80\x04}" + _text("poses") + _UNFOLDS + b"s.")


@attack("motion")
def npy_with_a_header_of_4_gigabytes(folder: Path) -> Path:
    return _written(folder / "a.npy", b"\x93NUMPY\x02\x00\xff\xff\xff\xff" + b"{" * 60_000)


# -- torch ---------------------------------------------------------------------------------------


def _torch(folder: Path, data, storages, kind=zipfile.ZIP_DEFLATED) -> Path:
    plain = torch_saved(folder / "plain.pt", data, storages)
    path = folder / "a.pt"
    with zipfile.ZipFile(plain) as old, zipfile.ZipFile(path, "w", kind, compresslevel=1) as new:
        for name in old.namelist():
            new.writestr(name, old.read(name))
    plain.unlink()
    return path


@attack("motion")
def torch_storage_of_zeros(folder: Path) -> Path:
    count = 2**27  # 512 MiB in half a megabyte
    tensor = Tensor("0", "FloatStorage", count, (count // 591, 591), (591, 1))
    return _torch(folder, tensor, {"0": np.zeros(count, "f4")})


@attack("motion")
def torch_tensors_of_one_storage(folder: Path) -> Path:
    count = 2**18
    whole = [Tensor("0", "FloatStorage", count, (count,), (1,)) for _ in range(20_000)]
    return _torch(folder, {"poses": whole}, {"0": np.zeros(count, "f4")}, zipfile.ZIP_STORED)


@attack("motion")
def torch_strides_that_overlap(folder: Path) -> Path:
    tensor = Tensor("0", "FloatStorage", 64, (2**20, 2**20), (0, 0))
    return _torch(folder, {"poses": tensor}, {"0": np.zeros(64, "f4")}, zipfile.ZIP_STORED)


@attack("motion")
def torch_sizes_that_lie(folder: Path) -> Path:
    tensor = Tensor("0", "FloatStorage", 2**40, (2**40,), (1,))
    return _torch(folder, {"poses": tensor}, {"0": np.zeros(64, "f4")}, zipfile.ZIP_STORED)


@attack("motion")
def torch_dimensions_by_the_thousand(folder: Path) -> Path:
    tensor = Tensor("0", "FloatStorage", 64, (1,) * 5000, (1,) * 5000)
    return _torch(folder, {"poses": tensor}, {"0": np.zeros(64, "f4")}, zipfile.ZIP_STORED)


# -- scenes --------------------------------------------------------------------------------------


@attack("scene")
def json_of_a_gigabyte(folder: Path) -> Path:
    path = folder / "a.json"
    with path.open("wb") as handle:  # sparse: no blocks on the disk
        handle.write(b'{"statics": {}, "objects": {')
        handle.truncate(2**30)
    return path


@attack("scene")
def json_of_lists(folder: Path) -> Path:
    return _written(folder / "a.json", '{"statics": [' + "[]," * 4_000_000 + "[]]}")


@attack("scene")
def json_nested(folder: Path) -> Path:
    return _written(folder / "a.json", '{"statics": ' + "[" * 2_000_000)


@attack("scene")
def yaml_of_aliases(folder: Path) -> Path:
    lines = ["gravity: &a0 [" + ", ".join(["1"] * 10) + "]"]
    lines += [f"k{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 10)]
    return _written(folder / "a.yaml", "\n".join(["statics: {}", *lines[:1], *lines[1:]]))


@attack("scene")
def yaml_of_aliases_for_a_number(folder: Path) -> Path:
    lists = "[&a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"
    for k in range(1, 12):
        lists += f", &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]"
    text = f"statics:\n  a: {{shape: sphere, radius: {lists}]}}\n"
    return _written(folder / "a.yaml", text)


@attack("scene")
def yaml_nested(folder: Path) -> Path:
    return _written(folder / "a.yaml", "statics: " + "[" * 100_000)


@attack("scene")
def yaml_nested_in_blocks(folder: Path) -> Path:
    return _written(folder / "a.yaml", "- " * 100_000)


# -- articulated ---------------------------------------------------------------------------------

_BODY = '<body><joint name="j"/><geom size="1"/></body>'


def _mjcf(folder: Path, text: str, name: str = "a.xml") -> Path:
    return _written(folder / name, f"<mujoco>{text}</mujoco>")


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
    return _written(folder / "a.xml", f"<!DOCTYPE a [{lines}]><mujoco model='&e11;'/>")


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
    return _written(folder / "a.urdf", f"<robot name='r'>{links}{joints}</robot>")


@attack("articulated")
def urdf_of_a_chain_of_5_000_rigid_links(folder: Path) -> Path:
    links = "".join(f'<link name="l{k}"/>' for k in range(5000))
    joints = "".join(
        f'<joint name="j{k}" type="{"continuous" if k % 2 else "fixed"}"><parent link="l{k}"/>'
        f'<child link="l{k + 1}"/></joint>'
        for k in range(4999)
    )
    return _written(folder / "a.urdf", f"<robot name='r'>{links}{joints}</robot>")


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
    return _written(folder / "a.urdf", f"<robot name='r'>{links}{joints}</robot>")


# -- meshes --------------------------------------------------------------------------------------

_TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"


@attack("mesh")
def ply_of_many_vertices(folder: Path) -> Path:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    return _written(folder / "a.ply", head.encode() + bytes(100))


@attack("mesh")
def ply_of_lists(folder: Path) -> Path:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1000000000\n"
        "property list uint int vertex_indices\nend_header\n"
    )
    return _written(folder / "a.ply", head.encode() + bytes(36) + b"\xff\xff\xff\x7f" + bytes(99))


@attack("mesh")
def stl_of_many_triangles(folder: Path) -> Path:
    return _written(folder / "a.stl", bytes(80) + b"\xff\xff\xff\xff" + bytes(100))


@attack("mesh")
def off_of_many_vertices(folder: Path) -> Path:
    return _written(folder / "a.off", "OFF\n4000000000 4000000000 0\n0 0 0\n")


def _gltf(folder: Path, more: dict[str, object], name: str = "a.gltf") -> Path:
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:;base64," + "A" * 48}],
        **more,
    }
    return _written(folder / name, json.dumps(document))


def _outside(uri: str) -> Builder:
    def build(folder: Path) -> Path:
        inner = folder / "inner"
        inner.mkdir()
        (folder / "secret.bin").write_bytes(np.eye(3, dtype="f4").tobytes())
        os.mkfifo(inner / "pipe.bin")
        os.symlink("/dev/zero", inner / "link.bin")
        here = uri.replace("HERE", str(folder))
        return _gltf(inner, {"buffers": [{"byteLength": 36, "uri": here}]})

    return build


for _name, _uri in {
    "above": "../secret.bin",
    "absolute": "HERE/secret.bin",
    "as_url": "file://HERE/secret.bin",
    "quoted": "%2e%2e/secret.bin",
    "from_the_net": "http://127.0.0.1:9/secret.bin",
    "of_a_pipe": "pipe.bin",
    "of_a_link_to_a_device": "link.bin",
    "of_a_device": "/dev/zero",
}.items():
    ATTACKS["mesh"][f"gltf_buffer_{_name}"] = _outside(_uri)


@attack("mesh")
def gltf_accessor_of_terabytes(folder: Path) -> Path:
    accessor = {"componentType": 5126, "count": 2**40, "type": "VEC3"}
    return _gltf(folder, {"accessors": [accessor]})


@attack("mesh")
def gltf_accessor_of_gigabytes(folder: Path) -> Path:
    accessor = {"componentType": 5126, "count": 2**28, "type": "VEC3"}
    return _gltf(folder, {"accessors": [accessor]})


@attack("mesh")
def gltf_nodes_in_a_ring(folder: Path) -> Path:
    return _gltf(folder, {"nodes": [{"mesh": 0, "children": [1]}, {"mesh": 0, "children": [0]}]})


@attack("mesh")
def gltf_nodes_that_unfold(folder: Path) -> Path:
    nodes = [{"mesh": 0, "children": [k + 1, k + 1]} for k in range(40)] + [{"mesh": 0}]
    return _gltf(folder, {"nodes": nodes})


@attack("mesh")
def gltf_buffers_that_repeat(folder: Path) -> Path:
    """One accessor in 10,000 primitives: each is a copy."""
    count = 100_000
    raw = np.zeros((count, 3), "f4")
    primitive = {"attributes": {"POSITION": 0}}
    more = {
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": raw.nbytes}],
        "buffers": [
            {
                "byteLength": raw.nbytes,
                "uri": "data:;base64," + base64.b64encode(raw.tobytes()).decode(),
            }
        ],
        "meshes": [{"primitives": [primitive] * 10_000}],
    }
    return _gltf(folder, more)


@attack("mesh")
def glb_that_lies(folder: Path) -> Path:
    return _written(
        folder / "a.glb",
        b"glTF" + struct.pack("<III4s", 2, 0xFFFFFFFF, 0xFFFFFFF0, b"JSON") + b"{}",
    )


@attack("mesh")
def glb_of_json_nested(folder: Path) -> Path:
    text = b'{"asset": ' + b"[" * 200_000
    head = struct.pack("<II", 2, 20 + len(text)) + struct.pack("<I4s", len(text), b"JSON")
    return _written(folder / "a.glb", b"glTF" + head + text)


@attack("mesh")
def zip_of_a_mesh(folder: Path) -> Path:
    path = folder / "a.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.obj", b"# " + bytes(2**24))
    return path


#: Files that are read as if nothing were beside them: name -> what makes it.
HARMLESS: dict[str, Builder] = {}


def _harmless(build: Builder) -> Builder:
    HARMLESS[build.__name__] = build
    return build


@_harmless
def obj_whose_material_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "a.mtl")
    return _written(folder / "a.obj", "mtllib a.mtl\nusemtl a\n" + _TRIANGLE)


@_harmless
def obj_whose_material_is_a_device(folder: Path) -> Path:
    return _written(folder / "a.obj", "mtllib /dev/zero\nusemtl a\n" + _TRIANGLE)


@_harmless
def obj_whose_texture_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "t.png")
    _written(folder / "a.mtl", "newmtl a\nmap_Kd t.png\n")
    return _written(folder / "a.obj", "mtllib a.mtl\nusemtl a\n" + _TRIANGLE)


@_harmless
def obj_whose_texture_is_a_device(folder: Path) -> Path:
    _written(folder / "a.mtl", "newmtl a\nmap_Kd /dev/zero\n")
    return _written(folder / "a.obj", "mtllib a.mtl\nusemtl a\n" + _TRIANGLE)


@_harmless
def obj_whose_texture_unpacks_to_gigabytes(folder: Path) -> Path:
    side = 40_000
    head = struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)

    def chunk(kind: bytes, data: bytes) -> bytes:
        crc = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + crc

    _written(
        folder / "t.png",
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(2**20)))
        + chunk(b"IEND", b""),
    )  # fmt: skip
    _written(folder / "a.mtl", "newmtl a\nmap_Kd t.png\n")
    return _written(folder / "a.obj", "mtllib a.mtl\nusemtl a\nvt 0 0\n" + _TRIANGLE)


@_harmless
def ply_whose_texture_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "t.png")
    head = (
        "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nelement face 4\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n"
    )
    return _written(folder / "a.ply", head)


@_harmless
def gltf_whose_image_is_a_pipe(folder: Path) -> Path:
    os.mkfifo(folder / "t.png")
    raw = base64.b64encode(np.eye(3, dtype="f4").tobytes()).decode()
    return _gltf(
        folder,
        {
            "buffers": [{"byteLength": 36, "uri": f"data:;base64,{raw}"}],
            "images": [{"uri": "t.png"}, {"uri": "/dev/zero"}],
            "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        },
    )

"""glTF files that are refused, each in words, and damaged ones: refused, or harmless."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsError
from support.files.gltf_rigs import motion_of, person, read

BODY = hp.Body.default()


def without_animation(b):
    b.json["animations"] = []


def of_a_table(b):
    for k, node in enumerate(b.json["nodes"]):
        node["name"] = f"leg{k}"


WRONG = {
    "a model without animation": (without_animation, "a model without animation"),
    "no person": (of_a_table, "no joint is known as left_hip"),
    "a node below itself": (
        lambda b: b.json["nodes"][3].__setitem__("children", [2]),
        "two parents|below itself",
    ),
    "a loop": (
        lambda b: b.json["nodes"].extend([{"children": [len(b.json["nodes"]) + 1]},
                                          {"children": [len(b.json["nodes"])]}]),
        "below itself",
    ),
    "a child that is not there": (
        lambda b: b.json["nodes"][3].__setitem__("children", [99999]), "children"),
    "a skin of no nodes": (
        lambda b: b.json["skins"][0].__setitem__("joints", [10**9]), "index of no node"),
    "too few matrices": (
        lambda b: b.json["accessors"][b.json["skins"][0]["inverseBindMatrices"]]
        .__setitem__("count", 3), "found 3, expected 52"),
    "another type": (
        lambda b: b.json["accessors"][0].__setitem__("type", "VEC3"), "expected SCALAR"),
    "another component": (
        lambda b: b.json["accessors"][0].__setitem__("componentType", 5130), "component type 5130"),
    "a huge count": (
        lambda b: b.json["accessors"][0].__setitem__("count", 2**60), "rows of 4 bytes"),
    "a negative offset": (
        lambda b: b.json["accessors"][0].__setitem__("byteOffset", -4), "rows of 4 bytes"),
    "a sparse accessor": (
        lambda b: b.json["accessors"][0].__setitem__("sparse", {"count": 1}), "is sparse"),
    "no data": (lambda b: b.json["accessors"][0].pop("bufferView"), "has no data"),
    "a view of no buffer": (
        lambda b: b.json["bufferViews"][0].__setitem__("buffer", 5), "buffers: found index 5"),
    "a long view": (
        lambda b: b.json["bufferViews"][0].__setitem__("byteLength", 2**40), "rows of 4 bytes"),
    "no sampler": (
        lambda b: b.json["animations"][0]["channels"][0].__setitem__("sampler", -1),
        "no sampler -1"),
    "no such node": (
        lambda b: b.json["animations"][0]["channels"][0]["target"].__setitem__("node", 4000),
        "no node 4000"),
    "an unknown interpolation": (
        lambda b: b.json["animations"][0]["samplers"][0].__setitem__("interpolation", "MAGIC"),
        "found 'MAGIC'"),
    "cubic without tangents": (
        lambda b: b.json["animations"][0]["samplers"][0].__setitem__(
            "interpolation", "CUBICSPLINE"), "found 16 values, expected 48"),
    "times for values": (
        lambda b: b.json["animations"][0]["samplers"][0].__setitem__("output", 0), "expected VEC"),
    "compressed": (
        lambda b: b.json.__setitem__("extensionsRequired", ["KHR_draco_mesh_compression"]),
        "Export it uncompressed"),
    "version 1": (lambda b: b.json.__setitem__("asset", {"version": "1.0"}), "found '1.0'"),
    "nodes of text": (lambda b: b.json.__setitem__("nodes", "many"), "expected a list of objects"),
    "a scale of nothing": (
        lambda b: b.json["nodes"][0].__setitem__("scale", [0, 0, 0]), "have no extent"),
    "a mirror": (lambda b: b.json["nodes"][0].__setitem__("scale", [-1, 1, 1]), "mirror.*Apply"),
    "a shear": (lambda b: b.json["nodes"][0].__setitem__("scale", [1, 5, 1]), "shear|scales"),
    "a scale of words": (
        lambda b: b.json["nodes"][0].__setitem__("scale", ["a", {}, None]), "expected 3 numbers"),
    "infinite": (
        lambda b: b.json["nodes"][0].__setitem__("translation", [1e300, 0, 0]), "3 numbers"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_wrong_files(tmp_path, case):
    spoil, message = WRONG[case]
    builder = person(motion_of(), BODY, tilt=(0.3, 0.0, 0.0))
    spoil(builder)
    path = builder.glb(tmp_path / "a.glb")
    with pytest.raises(HalfPhysicsError, match=message) as caught:
        read(path)
    assert "a.glb" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("last", "said"),
    [(1e7, r"frames of .* nodes, expected at most"), (1e30, "expected fewer than .* frames")],
)
def test_a_day_between_two_keys_is_refused(tmp_path, last, said):
    builder = person(motion_of(), BODY)
    times = np.arange(16) / 30.0
    times[-1] = last
    for sampler in builder.json["animations"][0]["samplers"]:
        sampler["input"] = builder.accessor(times[:, None], "SCALAR")
    with pytest.raises(HalfPhysicsError, match=said):
        read(builder.glb(tmp_path / "a.glb"))


def test_more_nodes_than_people_and_rooms_have_are_refused_at_once(tmp_path):
    builder = person(motion_of(4), BODY)
    builder.json["nodes"] += [{"name": "n"} for _ in range(20_000)]
    with pytest.raises(HalfPhysicsError, match="found 20053 nodes, expected at most 20000"):
        read(builder.glb(tmp_path / "a.glb"))
    builder = person(motion_of(4), BODY)
    first, count = builder.json["skins"][0]["joints"][0], len(builder.json["nodes"])
    builder.json["nodes"] += [{"children": [count + k + 1]} for k in range(600)] + [{}]
    builder.json["nodes"][first]["children"].append(count)
    with pytest.raises(HalfPhysicsError, match="over 500 deep"):
        read(builder.glb(tmp_path / "a.glb"))
    builder = person(motion_of(4), BODY)
    count = len(builder.json["nodes"])
    builder.json["nodes"] += [{} for _ in range(2_000)]
    builder.json["nodes"][first]["children"] += range(count, count + 2_000)
    builder.json["skins"].append({"joints": [first, *range(count, count + 2_000)]})
    with pytest.raises(HalfPhysicsError, match="a skeleton of 2052 nodes, expected a person's"):
        read(builder.glb(tmp_path / "a.glb"))


def test_fbx_says_how_to_convert_it(tmp_path):
    for name, raw in (("a.fbx", b"; FBX 7.4.0 project file\n"), ("b", b"Kaydara FBX Binary  \0")):
        (tmp_path / name).write_bytes(raw)
        with pytest.raises(
            HalfPhysicsError, match="File > Import > FBX, then File > Export > glTF"
        ):
            read(tmp_path / name)


def test_usd_says_how_to_convert_it(tmp_path):
    (tmp_path / "a.usda").write_bytes(b"#usda 1.0\n")
    (tmp_path / "b").write_bytes(b"PXR-USDC\0\x08")
    with zipfile.ZipFile(tmp_path / "c.usdz", "w") as archive:
        archive.writestr("c.usdc", b"PXR-USDC\0\x08")
    for name in ("a.usda", "b", "c.usdz"):
        with pytest.raises(HalfPhysicsError, match=r"USD file.*File > Export > glTF"):
            read(tmp_path / name)


def test_broken_bytes_are_refused_or_harmless(tmp_path):
    hp.export(motion_of(4), tmp_path / "good.glb")
    whole = (tmp_path / "good.glb").read_bytes()
    size = int.from_bytes(whole[12:16], "little") + 20
    rng, path = np.random.default_rng(1), tmp_path / "broken.glb"
    for length in np.linspace(0, len(whole) - 1, 16).astype(int):
        path.write_bytes(whole[:length])
        with pytest.raises(HalfPhysicsError):
            read(path)
    for _ in range(60):
        bad = bytearray(whole)
        bad[rng.integers(size)] ^= 1 << rng.integers(8)
        path.write_bytes(bytes(bad))
        try:
            read(path)
        except HalfPhysicsError:
            continue


def values_below(value, path=()):
    """The path of every value in the text of a file."""
    if path:
        yield path
    if isinstance(value, dict | list):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for key, each in items:
            yield from values_below(each, (*path, key))


def test_odd_values_anywhere_are_refused_or_harmless(tmp_path):
    odd = [None, -1, 3, 2**63, 1e308, "x", [], {}, [[]], True, [0, 0, 0, 0], {"a": 1}, "VEC4", 5121]
    path, rng = tmp_path / "a.gltf", np.random.default_rng(2)
    person(motion_of(4), BODY, seed=1).gltf(path, "a.bin")
    whole = path.read_text()
    paths: dict[str, list] = {}
    for way in values_below(json.loads(whole)):
        paths.setdefault(way[0], []).append(way)
    refused = 0
    for trial in range(150):
        content = json.loads(whole)
        below = paths[list(paths)[trial % len(paths)]]
        *way, last = below[rng.integers(len(below))]
        inner = content
        for key in way:
            inner = inner[key]
        inner[last] = odd[rng.integers(len(odd))]
        path.write_text(json.dumps(content))
        try:
            read(path)
        except HalfPhysicsError:
            refused += 1
    assert refused > 50


def test_json_that_is_no_gltf_is_left_to_others(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({"poses": []}))
    with pytest.raises(HalfPhysicsError, match="no known motion format"):
        read(tmp_path / "a.json")

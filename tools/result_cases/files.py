"""What is written and read back: results, motions, scenes, bodies, animated scenes."""

from __future__ import annotations

import json
import struct
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import motion_values, result_values
from result_cases.live import ACROSS, CABINET
from result_cases.measured import simulated
from result_cases.scenes import body, bowling, clip

#: Format that motions are written in -> suffix of its files.
FORMATS = {
    **dict.fromkeys(("amass-smplx", "amass-smplh", "amass-smpl", "blender", "smpl-codec"), ".npz"),
    "aist": ".pkl",
    "motionx": ".npy",
    "bvh": ".bvh",
}


def npz(path: Path) -> dict[str, Any]:
    """The arrays of a file except those about the program that wrote it (meta/...)."""
    with np.load(path) as file:
        return {key: file[key] for key in sorted(file) if not key.startswith("meta/")}


def results(name: str) -> dict[str, Any]:
    """A result file: its arrays, and what is read back."""
    result = simulated(name)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "result.npz"
        result.save(path)
        again = hp.Result.load(path)
        return {"arrays": npz(path), "read": result_values(again)}


def motions(name: str, form: str) -> dict[str, Any]:
    """A motion file of a format: its arrays or bytes, and what is read back."""
    motion = clip(name)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"motion{FORMATS[form]}"
        motion.save(path, format=form, body=body())
        written: Any = npz(path) if path.suffix == ".npz" else path.read_bytes()
        return {"written": written, "read": motion_values(hp.Motion.load(path))}


def scenes() -> dict[str, Any]:
    """A scene file, and the scene that it is read as."""
    scene = bowling()
    scene.add_articulated("cabinet", CABINET, **ACROSS)
    scene.friction("floor", "person/left_foot", 0.9)
    scene.ignore("post", "ball")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        scene.save(path)
        text, again = path.read_text(), hp.Scene.load(path)
    read = hp.simulate(clip("asap_kick1", 0.5), again, body=body())
    return {"text": text, "read": result_values(read)}


def bodies() -> dict[str, Any]:
    """Bodies of several shapes: joints, skin, and their MuJoCo models."""
    out: dict[str, Any] = {}
    motion = clip("asap_kick1")[:9:4]
    tall = hp.Body.default(stature=1.9)
    shaped = hp.Body.default(betas=np.linspace(1.5, -1.5, len(hp.Body.default().betas)))
    with tempfile.TemporaryDirectory() as folder:
        for name, one in (("mean", body()), ("tall", tall), ("shaped", shaped)):
            path = Path(folder) / f"{name}.xml"
            one.save_mjcf(path)
            out[name] = {
                "joints": one.joints(motion),
                "vertices": one.vertices(motion),
                "threads": one.vertices(motion, threads=2),
                "rest": (one.rest_joints, one.faces, one.weights),
                "mjcf": path.read_text(),
            }
    return out


def animated(suffix: str, name: str) -> dict[str, Any]:
    """An animated scene as a file, without the name of the program that wrote it."""
    result = simulated(name)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"scene{suffix}"
        hp.export(result, path)
        if suffix == ".glb":
            return _glb(path.read_bytes())
        files = sorted(p for p in Path(folder).rglob("*") if p.is_file())
        return {str(p.relative_to(folder)): _without_stamps(p.read_bytes()) for p in files}


def _glb(raw: bytes) -> dict[str, Any]:
    size = struct.unpack("<I", raw[12:16])[0]
    document = json.loads(raw[20 : 20 + size])
    document.pop("asset")
    return {"document": json.dumps(document), "buffer": raw[20 + size :]}


def _without_stamps(raw: bytes) -> bytes:
    """The lines of a text that do not say which program wrote it."""
    return b"\n".join(line for line in raw.split(b"\n") if b"halfphysics 0" not in line)


def cases() -> Iterator[Case]:
    """All kinds of files."""
    for name in ("solids", "shake_hands", "push_door", "room"):
        yield Case(f"file/result/{name}", partial(results, name), name == "solids")
    for form in FORMATS:
        for name in ("asap_kick1", "animdraw_dab"):
            quick = name == "asap_kick1" and form in ("amass-smplx", "bvh")
            yield Case(f"file/{form}/{name}", partial(motions, name, form), quick)
    yield Case("file/scene", scenes, True)
    yield Case("file/bodies", bodies, True)
    for suffix in (".glb", ".gltf", ".xml", ".usda"):
        for name in ("solids", "push_door", "shake_hands"):
            quick = name == "solids" and suffix != ".gltf"
            yield Case(f"file{suffix}/{name}", partial(animated, suffix, name), quick)

"""A folder with the files of which the documents speak, small, and the names that they suppose."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import trimesh

import halfphysics as hp

#: Frames of the small clips, at 30 a second.
FRAMES = 12
#: Frames a second of the result: seconds to cut films from, and few pictures to draw.
SLOW = 2.0

_DOOR = """<mujoco><worldbody><body name="door" pos="0 2.5 1">
  <joint name="hinge" type="hinge" axis="0 0 1" range="-90 90" damping="1"/>
  <geom type="box" size="0.4 0.02 0.9" pos="0.4 0 0" mass="12"/>
</body></worldbody></mujoco>"""
_ROBOT = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="4 4 0.1"/>
  <body name="arm" pos="0 3 1"><joint name="shoulder" axis="0 0 1" damping="1"/>
    <geom name="arm" type="capsule" fromto="0 0 0 0.5 0 0" size="0.04" mass="2"/></body>
</worldbody></mujoco>"""
_ROOM = """version: 1
statics:
  floor: {shape: plane}
  wall: {shape: box, size: [0.1, 3, 2.4], position: [4, 0, 1.2]}
"""
_PLAN = """version: 1
inputs: [{scenarios: kick_ball, fps: 8}]
factors: {objects.mass_factor: [1, 2]}
labels: {also: [behave, omomo]}
outputs: {folder: data, formats: [webdataset], variants_per_shard: 2, batch: 1}
"""


def write_files(folder: Path) -> None:
    """Write them into a folder."""
    for name in ("clips/more", "library", "rooms"):
        (folder / name).mkdir(parents=True)
    walk = hp.scenarios.load("walk_into_wall").motion[:FRAMES]
    for name in ("clip", "walk", "estimated", "generated", "clips/a", "clips/more/b", "library/a"):
        walk.save(folder / f"{name}.npz")
    hp.scenarios.load("kick_ball").motion[70 : 70 + FRAMES].save(folder / "kick.npz")
    walk.save(folder / "walk.bvh", body=hp.Body.default())
    walk.save(folder / "hmr4d_results.pt", format="gvhmr", body=hp.Body.default())
    for name, text in (("door.xml", _DOOR), ("robot.xml", _ROBOT), ("plan.yaml", _PLAN)):
        (folder / name).write_text(text, encoding="utf-8")
    for name in ("room.yaml", "rooms/kitchen.yaml", "rooms/office.yaml"):
        (folder / name).write_text(_ROOM, encoding="utf-8")
    _write_meshes(folder)
    for name, stiffness in (("result", 1.0), ("soft", 0.0), ("stiff", 10.0)):
        _story(stiffness).save(folder / f"{name}.npz")


def _write_meshes(folder: Path) -> None:
    wall = trimesh.creation.box((0.1, 4.0, 2.5))
    wall.apply_translation((5.0, 0.0, 1.25))
    wall.export(folder / "room.ply")
    # glTF is y-up.
    wall.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2.0, (1.0, 0.0, 0.0)))
    wall.export(folder / "room.glb")
    trimesh.creation.box((0.4, 0.4, 0.4)).export(folder / "crate.obj")
    legs = [trimesh.creation.box((0.4, 0.4, 0.05)), trimesh.creation.box((0.05, 0.4, 0.5))]
    legs[1].apply_translation((-0.175, 0.0, 0.275))
    trimesh.util.concatenate(legs).export(folder / "chair.obj")


def _story(stiffness: float) -> hp.Result:
    story = hp.scenarios.load("kick_ball", fps=SLOW)
    return hp.simulate(
        story.motion, story.scene, body=story.body, settings=hp.Settings(stiffness=stiffness)
    )


def write_carry(folder: Path, recorded: Path) -> None:
    """OMOMO's files: a clip under the name of one of its own, and the mesh that it names."""
    (name, clip), *_ = pickle.loads(recorded.read_bytes()).items()
    thing = clip["seq_name"].split("_")[1]
    clip["seq_name"] = "sub3_largebox_003"
    (folder / recorded.name).write_bytes(pickle.dumps({name: clip}))
    meshes = folder / "captured_objects"
    meshes.mkdir()
    mesh = recorded.parent / meshes.name / f"{thing}_cleaned_simplified.obj"
    (meshes / "largebox_cleaned_simplified.obj").write_bytes(mesh.read_bytes())


def names(folder: Path) -> dict[str, Any]:
    """What the blocks of a document suppose: the imports, and what README's block has made."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    motion = hp.Motion.load(folder / "clip.npz").grounded(hp.Body.default())
    return {
        "__name__": "__main__",
        "hp": hp,
        "np": np,
        "json": json,
        "Path": Path,
        "motion": motion,
        "pose": motion[0],
        "out": SimpleNamespace(**{**motion.to_smplx(), "betas": np.zeros(10)}),
        "scene": scene,
        "body": hp.Body.default(),
        "result": hp.Result.load(folder / "result.npz"),
        "soft": hp.Result.load(folder / "soft.npz"),
        "stiff": hp.Result.load(folder / "stiff.npz"),
    }

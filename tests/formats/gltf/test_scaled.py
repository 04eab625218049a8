"""Our own glTF files as programs leave them whose unit is another: all below one scaled node."""

from __future__ import annotations

import json

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning
from halfphysics.results.result import ObjectTrack
from support.files.layouts import movement, quiet

BODY = hp.Body.default()
SINGLE = 1e-5  # metres: keys are in single precision


def scale(path, unit):
    """Put all of a file below one node of this scale."""
    content = json.loads(path.read_text())
    (shown,) = content["scenes"]
    content["nodes"].append({"name": "Armature", "scale": [unit] * 3, "children": shown["nodes"]})
    shown["nodes"] = [len(content["nodes"]) - 1]
    path.write_text(json.dumps(content))


@pytest.mark.parametrize(("unit", "said"), [(100.0, "0.01"), (1000.0, "0.001"), (0.01, "100")])
def test_ours_that_another_program_scaled_is_read_in_metres(tmp_path, unit, said):
    motion, bones = hp.Motion(*movement(20), 30.0), np.full((55, 3), np.nan)
    bones[1:22] = 1.1 * (
        BODY.rest_joints[1:22] - BODY.rest_joints[hp.motion.skeleton.PARENTS[1:22]]
    )
    tall, scene = hp.Body.default(bones=bones), hp.Scene()
    scene.add_static("shelf", hp.Box((0.4, 0.3, 0.2)), position=(1.0, 2.0, 0.5))
    hp.export(hp.Sequence(motion, scene, tall), tmp_path / "a.gltf")
    scale(tmp_path / "a.gltf", unit)
    with pytest.warns(HalfPhysicsWarning, match=f"not in metres, by the legs: read with {said} m"):
        back = hp.load_sequence(tmp_path / "a.gltf")
    assert np.abs(back.body.joints(back.motion) - tall.joints(motion)).max() < SINGLE
    middle = back.scene.statics["shelf"]
    corners = rot.rotate(middle.quaternion, middle.shape.vertices) + middle.position
    between = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    assert np.abs(between - [1.0, 2.0, 0.5]).max() < SINGLE


def test_ours_in_a_unit_that_fits_nobody_is_refused(tmp_path):
    hp.export(hp.Motion(*movement(20), 30.0), tmp_path / "a.gltf")
    scale(tmp_path / "a.gltf", 10.0)
    with pytest.raises(HalfPhysicsError, match=r"pelvis to left_hip.*is it in metres\?"):
        quiet(tmp_path / "a.gltf")


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_what_is_exported_and_scaled_to_centimetres_comes_back(tmp_path):
    """As scenes of programs are whose unit is the centimetre: all below one node of scale 100."""
    people = hp.Motion(*movement(20, seed=3), 30.0)
    scene = hp.Scene()
    path = [0.5, 0.2, 1.0] + 0.3 * np.linspace(0.0, 1.0, 20)[:, None]
    still = np.tile([1.0, 0.0, 0.0, 0.0], (20, 1))
    scene.add_moving("box", hp.Box((0.1, 0.2, 0.3)), path, still, fps=30.0)
    recorded = {"box": ObjectTrack(position=path, quaternion=still)}
    hp.export(hp.Sequence(people, scene, BODY, recorded=recorded), tmp_path / "a.gltf")
    scale(tmp_path / "a.gltf", 100.0)
    back = quiet(tmp_path / "a.gltf", objects="replayed")
    assert back.body is None
    assert np.abs(BODY.vertices(back.motion) - BODY.vertices(people)).max() < SINGLE
    assert (len(back.motion), back.motion.fps) == (len(people), people.fps)
    assert np.abs(back.recorded["box"].position - path).max() < SINGLE
    sizes = np.ptp(back.scene.objects["box"].shape.vertices, axis=0)
    assert np.abs(np.sort(sizes) - [0.1, 0.2, 0.3]).max() < SINGLE

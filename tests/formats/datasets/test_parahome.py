"""ParaHome: a person in a room with furniture that opens."""

from __future__ import annotations

import json

import numpy as np
import pytest

import halfphysics as hp
from support.files import recorded_sets as sets
from support.files.wrong_files import broken_bytes_are_refused, refused, usual

SOMEONE = sets.person(13, (*range(22), *range(25, 55)))


def kinds(scene):
    return {name: type(item).__name__ for name, item in scene.objects.items()}


@pytest.mark.parametrize("axes", [sets.Z_UP, sets.Y_UP], ids=["z", "y"])
def test_upright_with_hands_and_the_room(tmp_path, axes):
    sequence = sets.load(sets.parahome(tmp_path, SOMEONE, axes))
    motion, scene = sequence.motion, sequence.scene
    assert (motion.fps, motion.model, motion.gender) == (30.0, "smplx", "female")
    assert motion.betas.tolist() == np.linspace(1, -1, 20).tolist()
    assert sets.off(motion, SOMEONE) < sets.DOUBLE
    # A thing of one part is free, what stands is static, a lid follows its record.
    assert kinds(scene) == {"pan_base": "Object", "laptop_part1": "KinematicObject"}
    assert sorted(scene.statics) == ["desk_base", "laptop_base"]
    *_, places, matrices = sets.thing(axes)
    vertices = sets.mesh(tmp_path / "own.obj").vertices
    for frame in (1, sets.FRAMES - 1):
        asked = sets.placed(vertices, places[frame], matrices[frame])
        assert sets.mesh_off(sequence, "pan_base", asked, frame) < sets.SINGLE
    lid = sequence.recorded["laptop_part1"]
    assert np.abs(lid.position - places).max() < sets.DOUBLE
    desk = scene.statics["desk_base"]
    assert np.abs(desk.position - places[0]).max() < sets.DOUBLE


def test_the_person_alone_and_what_is_told(tmp_path):
    folder = sets.parahome(tmp_path, SOMEONE)
    motion = hp.Motion.load(folder / "smplx_pose.pkl", frames=(2, 9))
    assert sets.off(motion, tuple(a[2:9] for a in SOMEONE)) < sets.DOUBLE
    with pytest.warns(hp.HalfPhysicsWarning, match="parts of 'laptop' is not here.*as recorded"):
        sequence = hp.load_sequence(folder, adapt=False)
    assert kinds(sequence.scene)["pan_base"] == "Object"
    with pytest.warns(hp.HalfPhysicsWarning, match="nearest pose in the others: pan_base"):
        replayed = hp.load_sequence(folder, objects="replayed")
    assert set(kinds(replayed.scene).values()) == {"KinematicObject"}


@pytest.mark.parametrize(
    ("spoil", "message"), [c[1:] for key in ("transl", "global_orient") for c in usual(key)]
)
def test_wrong_people(tmp_path, spoil, message):
    folder = sets.parahome(tmp_path, SOMEONE)
    content = sets.stored(folder / "smplx_pose.pkl")
    spoil(content)
    sets.dump(folder / "smplx_pose.pkl", content)
    with pytest.raises(hp.HalfPhysicsError, match=f"(?s){message}"):
        sets.load(folder)


def test_wrong_objects(tmp_path):
    folder = sets.parahome(tmp_path, SOMEONE)
    path = tmp_path / "seq" / "s7" / "object_transformations.pkl"
    table = sets.stored(path)
    wrong = {
        "expected for each frame a dict": 3,
        "different length": {k: table[k] for k in range(5)},
        "'pan_base': found no rigid transform": {**table, 3: {"pan_base": np.ones((4, 4))}},
        "found a part '../../x_base'": {**table, 3: {"../../x_base": np.eye(4)}},
        "found a part 'pan'": {**table, 3: {"pan": np.eye(4)}},
        "mesh of 'pot_base'": {**table, 3: {"pot_base": np.eye(4)}},
    }
    for message, content in wrong.items():
        sets.dump(path, content)
        with pytest.raises(hp.HalfPhysicsError, match=message):
            sets.load(folder)
    (tmp_path / "seq" / "s7" / "object_in_scene.json").write_text(json.dumps({"pan": True}))
    refused(tmp_path / "seq" / "s7", "objects and joints of a ParaHome.*smplx_seq/s7")
    path.unlink()
    refused(folder, "objects are in seq/s7/object_transformations.pkl.*assets=")


def test_broken_bytes(tmp_path):
    broken_bytes_are_refused(sets.parahome(tmp_path, SOMEONE) / "smplx_pose.pkl")

"""The command line on data sets: clips, assets, objects, losses of a format; `formats`."""

from __future__ import annotations

import json

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli.options import SceneOptions
from halfphysics.formats.registry import FORMATS
from halfphysics.motion.skeleton import PARENTS
from support.command_line import run
from support.files.layouts import movement
from support.files.trumans_files import release
from support.python_names import python_names

DOOR = """<mujoco><worldbody><body name="wing"><joint name="hinge" axis="0 0 1"/>
<geom type="box" size="0.4 0.02 1" mass="20"/></body></worldbody></mujoco>"""


@pytest.fixture
def dataset(tmp_path, monkeypatch):
    """A release whose first clip has a falling cup, with its meshes beside it."""
    import trimesh

    monkeypatch.chdir(tmp_path)
    release(tmp_path / "TRUMANS")
    for kind, name, size in (("Object", "cup", (0.1, 0.1, 0.1)), ("Scene", "hall", (9, 0.1, 9))):
        folder = tmp_path / "meshes" / f"{kind}_mesh"
        folder.mkdir(parents=True)
        mesh = trimesh.creation.box(size)
        mesh.apply_translation((0, -20, 0) if kind == "Scene" else (0, 0, 0))
        mesh.export(folder / f"{name}.obj")
    return tmp_path


def test_simulate_takes_the_data_sets_objects(dataset, capsys):
    common = ("simulate", "TRUMANS", "--clip", "walk@1", "--no-ground", "--out", "r.npz")
    assert run(*common) == 2
    assert "mesh of the scene 'hall'" in capsys.readouterr().err
    assert run(*common, "--assets", "meshes") == 0
    result = hp.Result.load(dataset / "r.npz")
    assert list(result.objects) == ["cup"]
    assert list(result.scene.statics) == ["hall"]
    # The free object falls, by symplectic Euler's sum in steps of h.
    time, h = 11 / 30, 1 / 240
    fallen = np.ptp(result.objects["cup"].position[:, 2])
    assert abs(fallen - 0.5 * 9.81 * time * (time + h)) < 1e-9
    assert run(*common, "--assets", "meshes", "--objects", "replayed") == 0
    replayed = hp.Result.load(dataset / "r.npz").objects["cup"]
    options = {"clip": "walk@1", "objects": "replayed"}
    recorded = hp.load_sequence(dataset / "TRUMANS", dataset / "meshes", **options).recorded
    assert np.abs(replayed.position - recorded["cup"].position).max() < 1e-9
    assert run(*common, "--objects", "none") == 0
    assert not hp.Result.load(dataset / "r.npz").objects


def test_scene_of_ones_own_and_recorded(dataset, capsys):
    hp.Scene().save(dataset / "mine.yaml")
    clip = ("simulate", "TRUMANS", "--clip", "walk@1", "--assets", "meshes")
    assert run(*clip, "--scene", "mine.yaml") == 2
    assert "brings a scene of its own" in capsys.readouterr().err


def test_what_has_joints_is_a_scene_too(tmp_path):
    hp.Scene().save(tmp_path / "mine.yaml")
    recorded = hp.Scene()
    recorded.add_articulated("door", DOOR)
    with pytest.raises(hp.errors.InputError, match="brings a scene of its own"):
        SceneOptions(scene=tmp_path / "mine.yaml").load(recorded)
    assert list(SceneOptions().load(recorded).articulated) == ["door"]


def test_a_part_of_a_result_is_converted(dataset, capsys):
    clip = ("simulate", "TRUMANS", "--clip", "walk@1", "--objects", "none", "--no-ground")
    assert run(*clip, "--out", "r.npz") == 0
    assert run("convert", "r.npz", "part.npz", "--frames", "2:7") == 0
    whole, part = hp.Result.load("r.npz").motion, hp.Motion.load("part.npz")
    assert np.array_equal(part.rotations, whole.rotations[2:7])
    assert run("convert", "r.npz", "part.glb", "--frames", "2:7") == 2
    assert "a result is written to .glb files whole" in capsys.readouterr().err


def test_convert_says_what_is_lost(dataset, capsys):
    hp.Motion(*movement(), 30.0, betas=np.ones(10)).save(dataset / "a.npz")
    arguments = ("convert", "a.npz", "a.pkl", "--format", "aist", "--stature", "1.7")
    assert run(*arguments) == 0
    said = capsys.readouterr().out
    for line in ("the fingers", "jaw and eyes", "the shape (betas)", "the frame rate 30"):
        assert f"not in the file: {line}" in said
    assert run("convert", "a.npz", "b.smpl") == 2
    assert "Say whose motion it is with --body\n" in capsys.readouterr().err
    assert run("convert", "a.npz", "b.smpl", "--stature", "1.7") == 0
    assert "not in the file" not in capsys.readouterr().out


def test_convert_says_what_of_a_result_is_not_in_a_motion_file(dataset, capsys):
    body = hp.Body.default()
    arms = np.array(body.rest_joints) - body.rest_joints[np.maximum(PARENTS, 0)]
    scene = hp.Scene()
    for k, name in enumerate(("ball", "cup")):
        scene.add_object(name, hp.Sphere(0.1), mass=1.0, position=(3.0, k, 1.0))
    away = hp.Motion(np.tile([0.0, 5.0, 0.0], (4, 1)), np.zeros((4, 55, 3)), 30.0)
    people = [hp.Motion(np.zeros((4, 3)), np.zeros((4, 55, 3)), 30.0), away]
    hp.simulate(people, scene, body=[hp.Body.default(bones=1.1 * arms), body]).save("two.npz")
    capsys.readouterr()
    assert run("convert", "two.npz", "one.npz") == 0
    said = capsys.readouterr().out.splitlines()
    assert "not in the file: the other people (person1)" in said
    assert "not in the file: the objects (ball, cup)" in said
    assert any(line.startswith("not in the file: the person's own bones") for line in said)
    assert run("convert", "two.npz", "two.glb") == 0
    assert "not in the file" not in capsys.readouterr().out


@pytest.mark.parametrize("target", ["out.glb", "out.npz"])
def test_convert_says_the_frames_and_the_rate_that_it_wrote(dataset, capsys, target):
    hp.Motion(*movement(), 30.0).save("a.npz")
    frames = len(hp.Motion.load("a.npz"))
    capsys.readouterr()
    assert run("convert", "a.npz", target, "--to-fps", "60") == 0
    assert f"{2 * frames - 1} frames at 60 fps" in capsys.readouterr().out


def test_the_way_out_is_said_in_options(dataset, capsys):
    translation, rotations = movement()
    fields = {"trans": translation, "poses": rotations.reshape(-1, 165)}
    np.savez(dataset / "a.npz", **fields)
    assert run("convert", "a.npz", "b.npz") == 0
    told = capsys.readouterr().err
    assert "taken as 30. Say it with --fps" in told
    assert "taken as neutral. Say it with --gender" in told
    assert run("convert", "a.npz", "b.npz", "--fps", "30") == 0
    assert run("convert", "b.npz", "b.pkl", "--format", "trumans-clip", "--stature", "1.7") == 0
    assert run("convert", "b.pkl", "c.npz", "--stature", "1.7") == 0
    assert "Say --hands flat, or --hands mean with --model (" in capsys.readouterr().err
    assert run("convert", "a.npz", "y.npz", "--up=-y", "--fps", "30") == 0
    assert hp.Motion.load("y.npz", up="-y").axes[2, 1] == -1.0
    fields["trans"] = np.full_like(translation, np.nan)
    np.savez(dataset / "a.npz", **fields)
    assert run("convert", "a.npz", "b.npz", "--fps", "30") == 2
    assert "or read others with --frames START:STOP\n" in capsys.readouterr().err
    assert run("convert", "b.npz", "b.fbx") == 2
    assert ".glb" in capsys.readouterr().err


def test_formats_lists_every_format(capsys):
    assert run("formats") == 0
    out = capsys.readouterr().out
    heads = [line.split(":")[0] for line in out.splitlines() if not line.startswith(" ")]
    assert heads == sorted(FORMATS)
    assert "not in the file: the person's size in metres, the floor" in out


def test_the_list_speaks_no_python(capsys):
    assert run("formats") == 0
    for line in capsys.readouterr().out.splitlines():
        assert python_names(line.strip()) == [], line


def test_formats_as_json_say_what_the_registry_says(capsys):
    assert run("formats", "--json") == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    assert set(rows) == set(FORMATS)
    for name, format in FORMATS.items():
        assert rows[name]["writes"] == (format.save is not None)
        assert ("objects, scene, bodies" in rows[name]["reads"]) == (
            format.load_sequence is not None
        )
        assert rows[name]["about"], f"{name} does not say what it is"

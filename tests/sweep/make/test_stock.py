"""Inputs of variants: read once, cached in bounded number, named by content."""

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.errors import FileError
from halfphysics.formats.loading import MotionOptions
from halfphysics.sweep.make.kept import Kept
from halfphysics.sweep.make.stock import Stock
from halfphysics.sweep.plan.choices import BodyChoice, SceneChoice
from support.files import grab_files as grab
from support.files.model_files import fields, write_npz
from support.sweeps.sweep_variants import clip, scenario, workshop


def test_kept_is_the_last_few():
    kept, made = Kept(2), []

    def get(key):
        return kept.get(key, lambda: made.append(key) or key)

    for key in "abacab":
        assert get(key) == key
    assert made == ["a", "b", "c", "b"]
    assert len(kept) == 2


def test_what_fails_is_not_kept():
    kept = Kept(2)
    with pytest.raises(ZeroDivisionError):
        kept.get("a", lambda: 1 / 0)
    assert kept.get("a", lambda: 1) == 1


@pytest.fixture
def walk(tmp_path):
    path = tmp_path / "walk.npz"
    hp.scenarios.load("walk_into_wall").motion[:11].save(path)
    return path


@pytest.fixture
def room(tmp_path):
    """A scene file with a mesh, an object of the same mesh and a box."""
    mesh = tmp_path / "block.ply"
    trimesh.creation.box((0.4, 0.4, 0.8)).export(mesh)
    scene = hp.Scene()
    scene.add_static("block", mesh, position=(3.0, 0.0, 0.4))
    scene.add_object("stone", mesh, mass=1.0, scale=0.5, position=(4.0, 0.0, 0.2))
    path = tmp_path / "room.yaml"
    scene.save(path)
    return SceneChoice(file="room.yaml", path=path)


def test_neighbours_share_what_no_factor_changes(walk, room):
    shop = workshop()
    one = shop.make(clip(walk, scene=room, factors={"objects.mass": 1.5}))
    other = shop.make(clip(walk, scene=room, factors={"objects.mass": 2.5}))
    assert one.motions[0] is other.motions[0]
    assert one.bodies[0] is other.bodies[0]
    assert one.scene.statics["block"] is other.scene.statics["block"]
    assert one.scene is not other.scene
    stones = [ready.scene.objects["stone"].shape for ready in (one, other)]
    assert stones[0] is stones[1]


def test_files_are_read_once(walk, room, monkeypatch):
    from halfphysics.formats import registry
    from halfphysics.geometry import mesh_files as meshes

    read = []
    for module, name in ((registry, "load_sequence"), (meshes, "load_mesh")):
        own = getattr(module, name)
        monkeypatch.setattr(
            module, name, lambda *a, _own=own, _name=name, **k: read.append(_name) or _own(*a, **k)
        )
    shop = workshop()
    for k in range(3):
        shop.make(clip(walk, scene=room, factors={"objects.scale": 1.0 + 0.1 * k}))
    assert (read.count("load_sequence"), read.count("load_mesh")) == (1, 2)


def test_sources_name_every_file_once(walk, room, tmp_path):
    ready = workshop().make(clip(walk, scene=room, factors={"objects.scale": 2.0}))
    files = [walk, tmp_path / "room.yaml", tmp_path / "block.ply"]
    assert [s["sha256"] for s in ready.sources] == [
        hashlib.sha256(path.read_bytes()).hexdigest() for path in files
    ]
    assert [s["path"] for s in ready.sources] == [*map(str, files[:2]), str(files[2].resolve())]


def test_a_body_of_a_model_file(walk, tmp_path):
    model_file = tmp_path / "SMPLX_NEUTRAL.npz"
    write_npz(model_file, fields("smplx", columns=10))
    choice = BodyChoice(model="model.npz", path=model_file, allow_mismatch=True)
    ready = workshop().make(clip(walk, body=choice, factors={"body.betas.1": 0.5}))
    assert ready.bodies[0].betas[1] == 0.5
    assert ready.allow_mismatch
    assert ready.sources[-1]["sha256"] == hashlib.sha256(model_file.read_bytes()).hexdigest()


def test_a_folder_is_named_by_what_is_in_it(tmp_path):
    (tmp_path / "clip" / "parts").mkdir(parents=True)
    part = tmp_path / "clip" / "parts" / "a.txt"
    part.write_text("a")
    stock = Stock()
    for text in ("a", "a", "longer"):
        part.write_text(text)
        said = {"path": str(part), "sha256": hashlib.sha256(text.encode()).hexdigest()}
        assert stock._sources([tmp_path / "clip"]) == (said,)
    with pytest.raises(FileError, match="cannot be read: No such file"):
        stock._sources([tmp_path / "nothing"])


def test_scenarios_read_nothing():
    assert workshop().make(scenario("kick_ball")).sources == ()


@pytest.fixture
def recorded(tmp_path, monkeypatch):
    """A clip of a data set with a cup, a table, a subject's template and a body model."""
    content = grab.fields()
    path = grab.written(tmp_path, content)
    tools = path.parents[2] / "tools"
    for name in (content["object"]["object_mesh"], content["table"]["table_mesh"]):
        (tools.parent / name).parent.mkdir(parents=True, exist_ok=True)
        trimesh.creation.box((0.1, 0.1, 0.1)).export(tools.parent / name)
    template = tools.parent / content["body"]["vtemp"]
    template.parent.mkdir(parents=True)
    shape = trimesh.Trimesh(grab.template(), fields("smplx")["f"], process=False)
    shape.export(template)
    models = tmp_path / "models"
    write_npz(models / "smplx" / "SMPLX_MALE.npz", fields("smplx"))
    monkeypatch.setenv("HALFPHYSICS_MODELS", str(models))
    return path


@pytest.mark.filterwarnings("ignore:.*what 'cup' weighs")
def test_all_that_a_data_set_s_clip_is_read_from_is_named(recorded):
    sources = workshop().make(clip(recorded, ground=False)).sources
    names = [Path(source["path"]).name for source in sources]
    assert names[0] == "cup_lift.npz"
    assert sorted(names) == ["SMPLX_MALE.npz", "cup.ply", "cup_lift.npz", "s1.ply", "table.ply"]
    for source in sources:
        content = Path(source["path"]).read_bytes()
        assert source["sha256"] == hashlib.sha256(content).hexdigest()


@pytest.mark.filterwarnings("ignore:.*what 'cup' weighs")
def test_the_subject_s_body_keeps_its_template(recorded):
    shop = workshop()
    own = shop.make(clip(recorded, ground=False)).bodies[0]
    said = {"body.betas.1": 0.5}
    other = shop.make(clip(recorded, ground=False, factors=said)).bodies[0]
    assert (other.template_source, other.source) == (own.template_source, own.source)
    assert other.betas[1] == 0.5
    assert not np.array_equal(other.rest_vertices, own.rest_vertices)
    short = shop.make(clip(recorded, ground=False, factors={"body.stature": 1.6})).bodies[0]
    assert (short.model, short.stature) == ("free", pytest.approx(1.6))


@pytest.mark.filterwarnings("ignore:.*what 'suitcase' weighs")
def test_hands_are_adapted_to_each_variant_s_body_and_settings(carried_file):
    shop = workshop()

    def made(body=None, settings=None, **options):
        factors = {f"settings.{name}": value for name, value in (settings or {}).items()}
        return shop.make(clip(carried_file, body, factors=factors, **options))

    own = made()
    sequence = MotionOptions().sequence(carried_file)
    assert np.array_equal(own.motions[0].rotations, sequence.motion.rotations)
    assert made().motions[0] is own.motions[0]  # neighbours share it
    bare, touching = made(adapt=False).motions[0], made(grip=False).motions[0]
    assert bare.holds == ()
    assert np.array_equal(bare.rotations, own.motions[0].recorded.rotations)
    assert touching.holds[0].force == 0.0
    small = made(body=BodyChoice(stature=1.6))
    again = replace(sequence, body=small.bodies[0]).adapted()
    assert np.array_equal(small.motions[0].rotations, again.motion.rotations)
    firm = made(settings={"stiffness": 4.0})
    again = replace(sequence, settings=firm.settings).adapted()
    assert np.array_equal(firm.motions[0].rotations, again.motion.rotations)


@pytest.mark.filterwarnings("ignore:.*what 'suitcase' weighs")
def test_a_motion_that_is_changed_is_compared_with_its_record_changed_alike(carried_file):
    shop = workshop(grounded=True)
    said = {"motion.yaw": 90.0, "motion.offset_x": 1.0, "motion.speed": 2.0}
    (motion,) = shop.make(clip(carried_file, factors=said)).motions
    usual = MotionOptions().sequence(carried_file).motion[::2]
    assert len(motion) == len(motion.recorded) == len(usual)
    assert (motion.fps, motion.recorded.fps) == (30.0, 30.0)
    # As far apart as before; the arms are moved, the rest is as recorded.
    body = MotionOptions().sequence(carried_file).body
    apart = [
        np.linalg.norm(body.joints(m) - body.joints(m.recorded), axis=2) for m in (motion, usual)
    ]
    assert np.abs(apart[0] - apart[1]).max() < 1e-9
    assert apart[0].max() > 0.01
    (hold,), (before,) = motion.holds, usual.holds
    assert (hold.first, hold.last) == (before.first, before.last)

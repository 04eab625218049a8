"""InterAct: a person and an object; y-up, told from AMASS by what is beside it."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.motion.skeleton import SMPLH_JOINTS
from support.files import recorded_sets as sets
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.wrong_files import broken_bytes_are_refused, changed, put, refused, usual

SMPLH, SMPLX = sets.person(9, SMPLH_JOINTS), sets.person(10)


@pytest.mark.parametrize(
    ("width", "someone", "model"), [(156, SMPLH, "smplh"), (165, SMPLX, "smplx")]
)
def test_upright_with_hands_and_the_object(tmp_path, width, someone, model):
    folder = sets.interact(tmp_path, someone, width)
    for path in (folder, folder / "human.npz"):
        sequence = sets.load(path)
        motion = sequence.motion
        assert (motion.fps, motion.model, motion.gender) == (30.0, model, "male")
        assert motion.betas.tolist() == sets.BETAS.tolist()
        assert sets.off(motion, someone) < sets.DOUBLE
    *_, places, matrices = sets.thing(sets.Y_UP)
    vertices = sets.mesh(tmp_path / "chairs" / "objects" / "chair" / "chair.obj").vertices
    for frame in (0, sets.FRAMES - 1):
        asked = sets.placed(vertices, places[frame], matrices[frame])
        assert sets.mesh_off(sequence, "chair", asked, frame) < sets.SINGLE


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_what_is_taken_is_told(tmp_path):
    folder = sets.interact(tmp_path, SMPLH)
    with pytest.warns(hp.HalfPhysicsWarning, match=r"30 fps, SMPL-H .*flat hand.*\(hands=\)"):
        hp.Motion.load(folder)
    assert hp.Motion.load(folder, hands="flat", model="smplx").model == "smplx"
    assert [clip.format for clip in hp.clips(tmp_path)] == ["interact"]


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_a_file_in_the_order_of_amass_is_known_by_its_still_face(tmp_path):
    someone = sets.person(17, SMPLH_JOINTS)
    content = sets.interact_fields(someone, 165)
    content["poses"] = sets.flat(sets.in_axes(someone, sets.Y_UP)[1], range(55))
    folder = sets.interact(tmp_path, someone, 165)
    np.savez(folder / "human.npz", **content)
    with pytest.warns(hp.HalfPhysicsWarning, match="read in the order of AMASS"):
        assert sets.off(hp.Motion.load(folder), someone) < sets.DOUBLE


def test_components_of_hands_need_the_model(tmp_path):
    content = model_fields("smplx")
    model = write_npz(tmp_path / "SMPLX_MALE.npz", content)
    rng = np.random.default_rng(0)
    hands = rng.normal(0, 0.1, (sets.FRAMES, 24))
    someone = sets.person(11, tuple(range(22)))
    full = someone[1].copy()
    for joints, side, part in ((sets.LEFT, "l", hands[:, :12]), (sets.RIGHT, "r", hands[:, 12:])):
        bent = content[f"hands_mean{side}"] + part @ content[f"hands_components{side}"][:12]
        full[:, joints] = bent.reshape(-1, 15, 3)
    folder = sets.interact(tmp_path, someone)
    filed = sets.interact_fields(someone)
    filed["poses"] = np.concatenate([filed["poses"][:, :66], hands], axis=1)
    np.savez(folder / "human.npz", **filed)
    assert sets.off(hp.Motion.load(folder, model=model), (someone[0], full)) < sets.DOUBLE
    with pytest.warns(hp.HalfPhysicsWarning, match="12 principal components.*fingers stay flat"):
        assert sets.off(hp.Motion.load(folder), someone) < sets.DOUBLE


def test_several_objects_and_parts(tmp_path):
    folder = sets.interact(tmp_path, SMPLH)
    places, turns, *_ = sets.thing(sets.Y_UP)
    (folder / "object.npz").unlink()
    for name in ("book_base", "book_part1"):
        np.savez(folder / f"object_{name}.npz", angles=turns, trans=places, name=np.array(name))
        sets.mesh(tmp_path / "chairs" / "objects" / "book" / f"{name.split('_')[1]}.obj")
    assert list(sets.load(folder).scene.objects) == ["book_base", "book_part1"]


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_a_file_of_amass_keys_alone_is_not_of_interact(tmp_path):
    filed = sets.interact_fields(SMPLH)
    np.savez(tmp_path / "walk.npz", **filed)
    with pytest.warns(hp.HalfPhysicsWarning, match="frame rate"):
        assert hp.Motion.load(tmp_path / "walk.npz").origin.format == "amass-smplh"
    folder = sets.interact(tmp_path, SMPLH)
    np.savez(folder / "human.npz", **filed, mocap_framerate=np.array(30.0))
    assert hp.Motion.load(folder / "human.npz").origin.format == "amass-smplh"


WRONG = [
    *usual("trans"),
    ("poses too wide", changed("poses", lambda a: np.hstack([a, a])), r"\(T, 165\), or \(T, 90\)"),
    ("poses too short", changed("poses", lambda a: a[:-2]), "different length"),
    ("a gender of nobody", put("gender", np.array("cat")), "gender"),
    ("too fast", changed("trans", lambda a: a * 1e4), "m/s"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_people(tmp_path, spoil, message):
    folder = sets.interact(tmp_path, SMPLH)
    content = sets.interact_fields(SMPLH)
    spoil(content)
    np.savez(folder / "human.npz", **content)
    refused(folder / "human.npz", message)


def test_wrong_objects(tmp_path):
    folder = sets.interact(tmp_path, SMPLH)
    places, turns, *_ = sets.thing(sets.Y_UP)
    refused(folder / "object.npz", "the object of an InterAct sequence.*human.npz")
    for name in ("../chair", "/etc/chair", ""):
        np.savez(folder / "object.npz", angles=turns, trans=places, name=np.array(name))
        with pytest.raises(
            hp.HalfPhysicsError, match=r"'name': found .*expected the name of an ob"
        ):
            sets.load(folder)
    np.savez(folder / "object.npz", angles=turns[:-1], trans=places, name=np.array("chair"))
    with pytest.raises(hp.HalfPhysicsError, match="different length"):
        sets.load(folder)
    np.savez(folder / "object.npz", angles=turns, trans=places, name=np.array("sofa"))
    refused(folder, "the mesh of 'sofa'.*objects/sofa/sofa.obj.*assets=")
    (folder / "object.npz").unlink()
    refused(folder, "object.npz or object_NAME.npz beside it.*Motion.load")


def test_broken_bytes(tmp_path):
    folder = sets.interact(tmp_path, SMPLH)
    broken_bytes_are_refused(folder / "human.npz")

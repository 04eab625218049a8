"""Synthetic model files of SMPL-X, SMPL-H and SMPL, written in their layouts."""

from __future__ import annotations

import hashlib
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from halfphysics.body.body import Body
from halfphysics.body.model_paths import gender_of
from halfphysics.errors import FileError, HalfPhysicsError, HalfPhysicsWarning, InputError
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS
from support.files.linear_blend import lbs
from support.files.model_files import (
    LAYOUTS,
    VERTICES,
    chumpy,
    chumpy_select,
    fields,
    write_npz,
    write_pkl,
)

COLUMNS = {"smplx": 400, "smplh": 16, "smpl": 10}
# Sums of products of numbers near one, in another order.
ROUNDING = 1e-12


@pytest.mark.parametrize("suffix", ["npz", "pkl"])
@pytest.mark.parametrize("model", ["smplx", "smplh", "smpl"])
def test_every_layout_skins_as_its_own_equations_say(
    model: str, suffix: str, tmp_path: Path
) -> None:
    content = fields(model, COLUMNS[model])
    path = tmp_path / f"{model.upper()}_FEMALE.{suffix}"
    if suffix == "npz":
        write_npz(path, content)
    else:
        # As in the original pickles: sparse regressor, chumpy arrays.
        content = {
            **content,
            "J_regressor": sp.csc_matrix(content["J_regressor"]),
            "shapedirs": chumpy(content["shapedirs"]),
            "v_template": chumpy_select(
                content["v_template"][::-1], np.arange(3 * VERTICES).reshape(-1, 3)[::-1].ravel(),
                (VERTICES, 3),
            ),
            "bs_style": "lbs",
        }  # fmt: skip
        write_pkl(path, content)
        content = fields(model, COLUMNS[model])
    rng = np.random.default_rng(1)
    betas = rng.normal(size=7)
    rotations = rng.normal(size=(55, 3)) * 0.7
    layout = LAYOUTS[model]
    own = np.array([np.zeros(3) if j is None else rotations[j] for j in layout])
    body = Body.load(path, betas=betas)
    assert (body.model, body.gender) == (model, "female")
    assert body.weights.shape == (VERTICES, 55)
    shift = np.array([1.0, 2.0, 3.0])
    expected = lbs(model, content, betas, own) + shift
    found = body.vertices(Pose(shift, rotations))
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("model", ["smplh", "smpl"])
def test_joints_that_the_file_lacks_sit_at_their_parents_bare(model: str, tmp_path: Path) -> None:
    path = write_npz(tmp_path / "m.npz", fields(model, 10))
    body = Body.load(path, betas=[1.0, -2.0])
    lacking = sorted(set(range(55)) - set(LAYOUTS[model]))
    assert lacking
    for j in lacking:
        np.testing.assert_array_equal(body.rest_joints[j], body.rest_joints[PARENTS[j]])
        assert not body.weights[:, j].any()
    np.testing.assert_allclose(body.weights.sum(axis=1), 1.0, rtol=0, atol=1e-15)


def test_smpl_hands_belong_to_the_wrists(tmp_path: Path) -> None:
    content = fields("smpl", 10)
    body = Body.load(write_npz(tmp_path / "m.npz", content))
    for wrist, hand in (("left_wrist", 22), ("right_wrist", 23)):
        own = content["weights"][:, JOINT_INDEX[wrist]] + content["weights"][:, hand]
        np.testing.assert_allclose(body.weights[:, JOINT_INDEX[wrist]], own, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("model", "columns", "shape"),
    [("smplx", 400, 300), ("smplx", 20, 10), ("smplx", 10, 10), ("smplx", 16, 16),
     ("smplh", 16, 16), ("smpl", 10, 10), ("smpl", 300, 300)],
)  # fmt: skip
def test_betas_of_any_length(model: str, columns: int, shape: int, tmp_path: Path) -> None:
    content = fields(model, columns)
    path = write_npz(tmp_path / "m.npz", content)
    betas = np.random.default_rng(2).normal(size=shape + 4)
    for length in (0, 1, 5, shape):
        body = Body.load(path, betas=betas[:length])
        np.testing.assert_array_equal(body.betas[:length], betas[:length])
        assert body.betas.shape == (shape,)
        assert not body.betas[length:].any()
        expected = content["v_template"] + content["shapedirs"][:, :, :length] @ betas[:length]
        np.testing.assert_allclose(body.rest_vertices, expected, rtol=0, atol=ROUNDING)
        np.testing.assert_array_equal(
            body.rest_vertices, Body.load(path, betas=[betas[:length]]).rest_vertices
        )
    with pytest.warns(HalfPhysicsWarning, match=f"{shape} shape directions: 4 of the last 4"):
        more = Body.load(path, betas=betas)
    np.testing.assert_array_equal(more.rest_vertices, body.rest_vertices)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Body.load(path, betas=[*betas[:shape], 0.0, 0.0])  # no shape component is lost: no warning


@pytest.mark.parametrize(
    ("betas", "text"),
    [(np.zeros((3, 10)), "one vector"), ([np.nan], "NaN"), (["tall"], "not numbers")],
)
def test_impossible_betas(betas: Any, text: str, tmp_path: Path) -> None:
    path = write_npz(tmp_path / "m.npz", fields())
    with pytest.raises(InputError, match=text):
        Body.load(path, betas=betas)


def test_precision_of_the_file_is_kept(tmp_path: Path) -> None:
    """Double-precision files in double precision, half-precision directions unfolded."""
    content = fields(columns=10)
    half = {**content, "shapedirs": content["shapedirs"].astype(np.float16)}
    body = Body.load(write_npz(tmp_path / "a.npz", half), betas=np.ones(10))
    expected = content["v_template"] + half["shapedirs"].astype(np.float64) @ np.ones(10)
    np.testing.assert_allclose(body.rest_vertices, expected, rtol=0, atol=ROUNDING)
    for name in ("weights", "rest_vertices", "rest_joints", "posedirs"):
        array = getattr(body, name)
        assert array.dtype == np.float64
        assert not array.flags.writeable
    assert body.faces.dtype == np.int32


def test_hands(tmp_path: Path) -> None:
    content = fields("smplx")
    body = Body.load(write_npz(tmp_path / "x.npz", content))
    assert body.hands_mean is not None
    assert body.hands_components is not None
    np.testing.assert_array_equal(body.hands_mean[1], content["hands_meanr"])
    np.testing.assert_array_equal(body.hands_components[0], content["hands_componentsl"])
    bare = Body.load(write_npz(tmp_path / "s.npz", fields("smpl", 10)))
    assert bare.hands_mean is None
    assert bare.hands_components is None


def test_source_is_path_and_content(tmp_path: Path) -> None:
    path = write_npz(tmp_path / "m.npz", fields())
    body = Body.load(path)
    assert body.source == (str(path), hashlib.sha256(path.read_bytes()).hexdigest())


def test_zero_pose_blend_shapes_are_none(tmp_path: Path) -> None:
    content = fields()
    content["posedirs"] = np.zeros_like(content["posedirs"])
    assert Body.load(write_npz(tmp_path / "a.npz", content)).posedirs is None
    del content["posedirs"]
    assert Body.load(write_npz(tmp_path / "b.npz", content)).posedirs is None


# Per-subject templates


def test_template_replaces_the_mean(tmp_path: Path) -> None:
    import trimesh

    content = fields("smplx", 20)
    path = write_npz(tmp_path / "m.npz", content)
    template = np.random.default_rng(8).uniform(-0.7, 0.7, (VERTICES, 3)).astype(np.float32)
    template[5] = template[4]  # readers that merge equal vertices would lose one
    mesh = trimesh.Trimesh(template, content["f"].astype(int), process=False)
    ply, obj = tmp_path / "s1.ply", tmp_path / "s1.obj"
    mesh.export(ply)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in template.astype(float)]
    # Texture seams: every triangle has its own corners.
    seams = [f"vt {i} 0" for i in range(6)] + ["vn 0 0 1"]
    corners = [
        f"f {a + 1}/{i % 6 + 1}/1 {b + 1}/1/1 {c + 1}/2/1"
        for i, (a, b, c) in enumerate(content["f"].astype(int))
    ]
    obj.write_text("\n".join(["# template", *lines, *seams, *corners]) + "\n")
    for given in (template, ply, str(obj)):
        body = Body.load(path, v_template=given)
        np.testing.assert_allclose(body.rest_vertices, template, rtol=0, atol=1e-7)
        np.testing.assert_allclose(
            body.rest_joints, content["J_regressor"] @ template, rtol=0, atol=1e-7
        )
    body = Body.load(path, betas=[1.5], v_template=ply)
    np.testing.assert_allclose(
        body.rest_vertices - template, 1.5 * content["shapedirs"][:, :, 0], rtol=0, atol=1e-7
    )
    assert body.template_source == (str(ply), hashlib.sha256(ply.read_bytes()).hexdigest())


@pytest.mark.parametrize(
    ("template", "text"),
    [
        (np.zeros((VERTICES + 1, 3)), rf"\({VERTICES}, 3\)"),
        (np.full((VERTICES, 3), np.nan), "NaN"),
        (np.linspace(0, 1700, 3 * VERTICES).reshape(-1, 3), "^v_template: .*metres"),
        ("nowhere.ply", "nowhere.ply"),
    ],
)
def test_impossible_templates(template: Any, text: str, tmp_path: Path) -> None:
    path = write_npz(tmp_path / "m.npz", fields())
    with pytest.raises(HalfPhysicsError, match=text):
        Body.load(path, v_template=template)


def test_damaged_template(tmp_path: Path) -> None:
    path = write_npz(tmp_path / "m.npz", fields())
    for name, text in (("a.ply", b"ply\nformat"), ("a.obj", b"v 1 2\nv a b c\n"), ("a.stl", b"")):
        (tmp_path / name).write_bytes(text)
        with pytest.raises(FileError, match=name):
            Body.load(path, v_template=tmp_path / name)


# Folders


def test_folder_layouts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HALFPHYSICS_MODELS", raising=False)
    x, h, s = fields("smplx"), fields("smplh", 16), fields("smpl", 10)
    write_npz(tmp_path / "smplx" / "SMPLX_NEUTRAL.npz", x)
    write_npz(tmp_path / "smplx" / "SMPLX_MALE.npz", x)
    write_npz(tmp_path / "smplh" / "female" / "model.npz", h)
    write_pkl(tmp_path / "SMPLH_MALE.pkl", h)
    write_pkl(tmp_path / "smpl" / "basicmodel_f_lbs_10_207_0_v1.1.0.pkl", s)

    def found(**options: Any) -> tuple[str, str]:
        body = Body.load(options.pop("path", tmp_path), **options)
        return body.model, body.gender

    assert found(gender="male") == ("smplx", "male")
    assert found(gender="neutral") == ("smplx", "neutral")
    assert found(gender="female") == ("smplh", "female")
    assert found(gender="male", model="smplh") == ("smplh", "male")
    assert found(model="smpl") == ("smpl", "female")
    assert found(path=tmp_path / "smplx", gender="male") == ("smplx", "male")
    with pytest.raises(InputError, match=r"neutral, male.*gender="):
        found(model="smplx")
    with pytest.raises(FileError, match=r"SMPL_MALE\.npz"):
        found(model="smpl", gender="male")
    with pytest.raises(FileError, match=r"HALFPHYSICS_MODELS"):
        found(path=None, gender="male")
    monkeypatch.setenv("HALFPHYSICS_MODELS", str(tmp_path))
    assert found(path=None, gender="male") == ("smplx", "male")
    assert found(path="smplx/SMPLX_MALE.npz") == ("smplx", "male")
    with pytest.raises(FileError, match=r"absent\.npz"):
        found(path="absent.npz")


@pytest.mark.parametrize(
    ("name", "gender"),
    [
        ("SMPLX_NEUTRAL.npz", "neutral"),
        ("smplx/SMPLX_MALE_2020.npz", "male"),
        ("basicModel_f_lbs_10_207_0_v1.0.0.pkl", "female"),
        ("smplh/male/model.npz", "male"),
        ("female/m_f.npz", None),
        ("body.npz", None),
    ],
)
def test_gender_by_name(name: str, gender: str | None) -> None:
    assert gender_of(Path(name)) == gender


def test_gender_and_model_must_agree_with_the_file(tmp_path: Path) -> None:
    path = write_npz(tmp_path / "SMPLX_MALE.npz", fields())
    with pytest.raises(InputError, match="male by its name"):
        Body.load(path, gender="female")
    with pytest.raises(InputError, match="55 joints"):
        Body.load(path, model="smpl")
    with pytest.raises(InputError, match="neutral, male, female"):
        Body.load(path, gender="man")
    with pytest.raises(InputError, match="smplx, smplh, smpl"):
        Body.load(path, model="mano")
    plain = write_npz(tmp_path / "body.npz", fields())
    assert Body.load(plain).gender == "unknown"
    assert Body.load(plain, gender="female").gender == "female"
    said = write_npz(tmp_path / "said.npz", {**fields(), "gender": np.array("male")})
    assert Body.load(said).gender == "male"


# Damage


def _without(key: str) -> dict[str, Any]:
    return {k: v for k, v in fields().items() if k != key}


def _changed(key: str, change: Any) -> dict[str, Any]:
    content = fields()
    content[key] = change(content[key])
    return content


def _nan(array: np.ndarray) -> np.ndarray:
    array[1] = np.nan
    return array


def _parents(array: np.ndarray) -> np.ndarray:
    array[0, 18] = 3
    return array


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (_without("weights"), "no field weights"),
        (_without("kintree_table"), "kintree_table"),
        (_changed("weights", lambda a: a[:, :16]), r"16 joints, expected one of 55 \(smplx\)"),
        (_changed("weights", lambda a: a * 0.9), r"sums to 0\.9"),
        (_changed("v_template", lambda a: a[:, :2]), r"'v_template' has shape \(90, 2\)"),
        (_changed("v_template", lambda a: a * 100), "metres"),
        (_changed("v_template", lambda a: a[:0]), "shape|metres"),
        (_changed("v_template", _nan), "'v_template' holds NaN"),
        (_changed("J_regressor", lambda a: a[:24]), r"'J_regressor' has shape \(24, 90\)"),
        (_changed("posedirs", lambda a: a[:, :, :207]), r"expected \(90, 3, 486\)"),
        (_changed("shapedirs", lambda a: a[:, 0]), "'shapedirs'"),
        (_changed("f", lambda a: a + 80), "'f' names vertices"),
        (_changed("f", lambda a: a.astype(str)), "'f' is <U"),
        (_changed("kintree_table", _parents), "joint 18 .left_elbow. on spine1, expected left_sh"),
        (_changed("hands_meanl", lambda a: a[:12]), "'hands_meanl'"),
    ],
)
@pytest.mark.parametrize("suffix", ["npz", "pkl"])
def test_damaged_content_is_named(
    content: dict[str, Any], text: str, suffix: str, tmp_path: Path
) -> None:
    write = write_npz if suffix == "npz" else write_pkl
    path = write(tmp_path / f"m.{suffix}", content)
    with pytest.raises(FileError, match=text) as caught:
        Body.load(path)
    assert str(path) in str(caught.value)


def test_damaged_files(tmp_path: Path) -> None:
    whole = {"a.npz": write_npz(tmp_path / "a.npz", fields())}
    whole["a.pkl"] = write_pkl(tmp_path / "a.pkl", fields())
    for name, path in whole.items():
        data = path.read_bytes()
        for share in (0.0, 0.001, 0.5, 0.99):
            broken = tmp_path / f"broken_{name}"
            broken.write_bytes(data[: int(share * len(data))])
            with pytest.raises(FileError, match=f"broken_{name}"):
                Body.load(broken)
    listed = tmp_path / "list.pkl"
    listed.write_bytes(pickle.dumps([1, 2]))
    with pytest.raises(FileError, match="holds a list"):
        Body.load(listed)
    with pytest.raises(FileError, match="no such file"):
        Body.load(tmp_path / "none.npz")


def test_npz_made_of_a_pickles_dict(tmp_path: Path) -> None:
    """numpy hides a sparse matrix in an .npz as a pickle: read, but only as data."""
    content = fields("smpl", 10)
    plain = Body.load(write_npz(tmp_path / "a.npz", content))
    hidden = {**content, "J_regressor": np.array(sp.csc_matrix(content["J_regressor"]), object)}
    body = Body.load(write_npz(tmp_path / "b.npz", hidden))
    np.testing.assert_array_equal(body.rest_joints, plain.rest_joints)

    class Hostile:
        def __reduce__(self) -> Any:
            return (Path.touch, (tmp_path / "ran",))

    hidden["J_regressor"] = np.array(Hostile(), dtype=object)
    with pytest.raises(FileError, match=r"field 'J_regressor'.*unsafe"):
        Body.load(write_npz(tmp_path / "c.npz", hidden))
    assert not (tmp_path / "ran").exists()
    # An object in an unused field is not read.
    hidden = {**content, "part2num": np.array(Hostile(), dtype=object)}
    np.testing.assert_array_equal(
        Body.load(write_npz(tmp_path / "d.npz", hidden)).rest_joints, plain.rest_joints
    )

"""USD, opened again by usd-core, which poses and skins by itself."""

from __future__ import annotations

import dataclasses
import sys

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import FileError, MissingDependencyError
from halfphysics.motion.skeleton import JOINT_NAMES
from support.files.layouts import movement
from support.results import takes

#: Vertices [m]: USD's skeletons are of single precision.
SINGLE = 1e-5
FRAMES = (0, 3, 7, 10, 12)


@pytest.fixture(scope="module")
def pxr():
    return pytest.importorskip("pxr")


class Opened:
    """A USD file, evaluated by usd-core alone."""

    def __init__(self, path) -> None:
        from pxr import Usd, UsdGeom, UsdSkel

        self.stage = stage = Usd.Stage.Open(str(path))
        assert UsdGeom.GetStageUpAxis(stage) == "Z"
        assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
        assert stage.GetDefaultPrim().GetName() == "World"
        self._skel, self._geom, self._time = UsdSkel, UsdGeom, Usd.TimeCode
        self._traverse = Usd.TraverseInstanceProxies()

    def skin(self, name: str, k: float) -> np.ndarray:
        """World positions of a person's skin at a time code."""
        root = self._skel.Root(self.stage.GetPrimAtPath(f"/World/{name}"))
        cache = self._skel.Cache()
        assert cache.Populate(root, self._traverse)
        (binding,) = cache.ComputeSkelBindings(root, self._traverse)
        (target,) = binding.GetSkinningTargets()
        skeleton = cache.GetSkelQuery(binding.GetSkeleton())
        mesh = self._geom.Mesh(target.GetPrim())
        points = mesh.GetPointsAttr().Get()
        if target.HasBlendShapes():
            weights = skeleton.GetAnimQuery().ComputeBlendShapeWeights(k)
            shapes = self._skel.BlendShapeQuery(self._skel.BindingAPI(target.GetPrim()))
            sub_weights, blend, sub = shapes.ComputeSubShapeWeights(weights)
            assert shapes.ComputeDeformedPoints(
                sub_weights, blend, sub, shapes.ComputeBlendShapePointIndices(),
                shapes.ComputeSubShapePointOffsets(), points,
            )  # fmt: skip
        transforms = skeleton.ComputeSkinningTransforms(k)
        assert target.ComputeSkinnedPoints(transforms, points, k)
        return self._placed(points, binding.GetSkeleton().GetPrim(), k)

    def thing(self, name: str, k: float) -> np.ndarray:
        """World positions of an object's mesh at a time code."""
        mesh = self._geom.Mesh(self.stage.GetPrimAtPath(f"/World/{name}/Mesh"))
        return self._placed(mesh.GetPointsAttr().Get(), mesh.GetPrim(), k)

    def box(self, name: str, k: float) -> np.ndarray:
        root = self._geom.Boundable(self.stage.GetPrimAtPath(f"/World/{name}"))
        return np.array(root.GetExtentAttr().Get(k))

    def _placed(self, points, prim, k) -> np.ndarray:
        matrix = np.array(self._geom.Xformable(prim).ComputeLocalToWorldTransform(self._time(k)))
        return np.array(points, dtype=np.float64) @ matrix[:3, :3] + matrix[3, :3]


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """Distance of points of either set from the nearest of the other [m]."""
    distance = np.linalg.norm(a[:, None] - b[None], axis=2)
    return max(distance.min(axis=0).max(), distance.min(axis=1).max())


@pytest.mark.parametrize(
    ("suffix", "magic"),
    [(".usd", b"PXR-USDC"), (".usdc", b"PXR-USDC"), (".usda", b"#usda"), (".usdz", b"PK")],
)
def test_people_and_things_are_where_they_were(tmp_path, pxr, suffix, magic):
    result = takes.result(2)
    path = tmp_path / f"a{suffix}"
    hp.export(result, path)
    assert path.read_bytes().startswith(magic)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    opened = Opened(path)
    stage = opened.stage
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 30.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, 12.0)
    for person in result.people:
        for k in FRAMES:
            asked = person.body.vertices(person.motion, frames=k)
            assert np.abs(opened.skin(person.name, k) - asked).max() < SINGLE
            low, high = opened.box(person.name, k)
            assert (asked > low).all()
            assert (asked < high).all()
    scene = result.scene
    for name, static in scene.statics.items():
        if isinstance(static.shape, hp.Plane):  # a square of it, near the people
            normal = rot.rotate(static.quaternion, static.shape.normal)
            height = opened.thing(name, 5.0) @ normal - static.shape.offset
            assert np.abs(height - normal @ static.position).max() < SINGLE
            continue
        vertices = static.mesh()[0]
        asked = vertices @ rot.to_matrix(static.quaternion).T + static.position
        assert apart(opened.thing(name, 5.0), asked) < SINGLE
    seen = {name: thing.mesh()[0] for name, thing in scene.objects.items()}
    cabinet = scene.articulated["cabinet"]
    seen |= {n: link.mesh()[0] for n, link in zip(cabinet.link_names, cabinet.links, strict=True)}
    for name, vertices in seen.items():
        track = result.objects[name]
        for k in FRAMES:
            turn = rot.to_matrix(rot.normalize(track.quaternion[k]))
            found = opened.thing(name.replace("/", "_"), k)
            assert apart(found, vertices @ turn.T + track.position[k]) < SINGLE, name
    assert stage.GetPrimAtPath("/World/cabinet_door").GetDisplayName() == "cabinet/door"


def test_pose_blend_shapes_act_before_the_skinning(tmp_path, pxr):
    rng = np.random.default_rng(1)
    body = hp.Body.default()
    few = rng.normal(0.0, 0.002, (len(body.rest_vertices), 3, 6)) @ rng.normal(0, 1, (6, 486))
    body = dataclasses.replace(body, posedirs=few)
    motion = hp.Motion(*movement(13), 30.0)
    hp.export(motion, tmp_path / "a.usdc", body=body)
    opened = Opened(tmp_path / "a.usdc")
    plain = dataclasses.replace(body, posedirs=None)
    for k in FRAMES:
        asked = body.vertices(motion, frames=k)
        assert np.abs(asked - plain.vertices(motion, frames=k)).max() > 100 * SINGLE
        assert np.abs(opened.skin("person", k) - asked).max() < SINGLE


def test_between_frames_turns_go_the_short_way(tmp_path, pxr):
    translation, rotations = movement(13)
    # Past half a turn: the quaternions of one frame and the next have opposite signs.
    spin = np.linspace(0.0, 3.0, 13)[:, None] * np.array([0.0, 0.0, np.pi])
    rotations[:, 0] = rot.log(rot.multiply(rot.exp(spin), rot.exp(rotations[:, 0])))
    motion = hp.Motion(translation, rotations, 30.0)
    hp.export(motion, tmp_path / "a.usd")
    opened, fine, body = Opened(tmp_path / "a.usd"), motion.resample(60.0), hp.Body.default()
    for k in range(12):
        asked = body.vertices(fine, frames=2 * k + 1)
        assert np.abs(opened.skin("person", k + 0.5) - asked).max() < SINGLE


def test_it_passes_the_rules_of_usd(tmp_path, pxr):
    from pxr import Sdf, UsdShade, UsdSkel

    validation = pytest.importorskip("pxr.UsdValidation")
    hp.export(takes.result(), tmp_path / "a.usdz")
    stage = Opened(tmp_path / "a.usdz").stage
    rules = validation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(rules) > 10
    broken = validation.ValidationContext(rules).Validate(stage)
    assert [error.GetMessage() for error in broken] == []
    skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath("/World/person/Skeleton"))
    joints = list(skeleton.GetJointsAttr().Get())
    assert [Sdf.Path(joint).name for joint in joints] == list(JOINT_NAMES)
    assert UsdSkel.Topology(joints).Validate()[0]
    material, _ = UsdShade.MaterialBindingAPI(
        stage.GetPrimAtPath("/World/person/Skin")
    ).ComputeBoundMaterial()
    assert material


def test_what_is_missing_is_said(tmp_path, monkeypatch):
    motion = hp.Motion(*movement(), 30.0)
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(MissingDependencyError, match=r"halfphysics\[usd\]"):
        hp.export(motion, tmp_path / "a.usd")
    assert not list(tmp_path.iterdir())


def test_no_folder(tmp_path, pxr):
    with pytest.raises(FileError, match="does not exist"):
        hp.export(hp.Motion(*movement(), 30.0), tmp_path / "none" / "a.usda")

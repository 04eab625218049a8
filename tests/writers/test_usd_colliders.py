"""Colliders in USD files, read by usd-core's own parser of physics."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from support.results import takes

#: Points [m]: meshes are of single precision.
SINGLE = 1e-5

pytest.importorskip("pxr")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A result of two people with a room and objects, and its stage."""
    from pxr import Usd

    result = takes.result(2)
    path = tmp_path_factory.mktemp("usd") / "a.usd"
    hp.export(result, path, colliders=True)
    return result, Usd.Stage.Open(str(path))


def parsed(stage):
    """Type -> prim paths, as an engine finds them; each description says whether it is valid."""
    from pxr import UsdPhysics

    found = UsdPhysics.LoadUsdPhysicsFromRange(stage, ["/World"])
    for paths, descriptions in found.values():
        assert len(paths) == len(descriptions)
        assert all(description.isValid for description in descriptions)
    return {str(kind).rpartition(".")[2]: [str(p) for p in v[0]] for kind, v in found.items()}


def test_an_engine_finds_every_part_as_a_kinematic_body(written):
    from pxr import UsdPhysics

    result, stage = written
    bodies = parsed(stage)["RigidBody"]
    for person in result.people:
        parts = [part.name for part in person.body.variant.parts if len(part.vertices)]
        assert len(parts) == 55
        for name in parts:
            path = f"/World/{person.name}Colliders/{name}"
            assert path in bodies
            prim = stage.GetPrimAtPath(path)
            assert UsdPhysics.RigidBodyAPI(prim).GetKinematicEnabledAttr().Get()
            hull = stage.GetPrimAtPath(f"{path}/Hull")
            assert hull.HasAPI(UsdPhysics.CollisionAPI)
            shape = UsdPhysics.MeshCollisionAPI(hull)
            assert shape.GetApproximationAttr().Get() == "convexHull"
    inside = [b for b in bodies for a in bodies if b.startswith(f"{a}/")]
    assert inside == [], "bodies within bodies"


@pytest.mark.parametrize("k", [0, 5, 12])
def test_hulls_follow_the_animation(written, k):
    from pxr import Usd, UsdGeom

    result, stage = written
    for person in result.people:
        positions, quaternions = person.body.joint_frames(person.motion)
        for part in person.body.variant.parts:
            path = f"/World/{person.name}Colliders/{part.name}/Hull"
            mesh = UsdGeom.Mesh(stage.GetPrimAtPath(path))
            matrix = np.array(mesh.ComputeLocalToWorldTransform(Usd.TimeCode(k)))
            points = np.array(mesh.GetPointsAttr().Get()) @ matrix[:3, :3] + matrix[3, :3]
            j = part.index
            asked = rot.rotate(quaternions[k, j], part.vertices) + positions[k, j]
            assert np.abs(points - asked).max() < SINGLE


def test_the_room_collides_and_what_moves_is_kinematic(written):
    from pxr import UsdPhysics

    result, stage = written
    for name in result.scene.statics:
        prim = stage.GetPrimAtPath(f"/World/{name}")
        assert not prim.HasAPI(UsdPhysics.RigidBodyAPI)
        assert stage.GetPrimAtPath(f"/World/{name}/Mesh").HasAPI(UsdPhysics.CollisionAPI)
    for name in result.scene.objects:
        prim = stage.GetPrimAtPath(f"/World/{name}")
        assert UsdPhysics.RigidBodyAPI(prim).GetKinematicEnabledAttr().Get()
    (scene,) = parsed(stage)["Scene"]
    found = UsdPhysics.Scene(stage.GetPrimAtPath(scene))
    assert found.GetGravityMagnitudeAttr().Get() == pytest.approx(9.81, abs=0.01)
    assert tuple(found.GetGravityDirectionAttr().Get()) == (0.0, 0.0, -1.0)


def test_without_colliders_nothing_of_physics_is_written(tmp_path):
    from pxr import Usd

    hp.export(takes.result(1), tmp_path / "a.usda")
    assert "Physics" not in (tmp_path / "a.usda").read_text()
    assert Usd.Stage.Open(str(tmp_path / "a.usda"))


def test_other_formats_have_none(tmp_path):
    with pytest.raises(InputError, match="USD only"):
        hp.export(takes.result(1), tmp_path / "a.glb", colliders=True)
    assert list(tmp_path.iterdir()) == []


def test_objects_named_as_the_colliders_have_paths_of_their_own(tmp_path):
    from pxr import Usd, UsdPhysics

    scene = hp.Scene()
    for k, name in enumerate(("PhysicsScene", "personColliders")):
        scene.add_object(name, hp.Sphere(0.1), mass=1.0, position=(1.0 + k, 0.0, 1.0))
    still = hp.Motion(np.zeros((3, 3)), np.zeros((3, 55, 3)), 25.0)
    path = tmp_path / "named.usd"
    hp.export(hp.simulate(still, scene), path, colliders=True)
    stage = Usd.Stage.Open(str(path))
    assert UsdPhysics.Scene(stage.GetPrimAtPath("/World/PhysicsScene"))
    assert not stage.GetPrimAtPath("/World/PhysicsScene/Mesh")
    for name in ("PhysicsScene", "personColliders"):
        prim = stage.GetPrimAtPath(f"/World/{name}_")
        assert prim.GetTypeName() == "Xform"
        assert prim.GetDisplayName() == name
        assert stage.GetPrimAtPath(f"/World/{name}_/Mesh").HasAPI(UsdPhysics.CollisionAPI)
    # Without colliders nothing else has these names.
    hp.export(hp.simulate(still, scene), tmp_path / "plain.usd")
    stage = Usd.Stage.Open(str(tmp_path / "plain.usd"))
    assert stage.GetPrimAtPath("/World/PhysicsScene/Mesh")

"""The core's search for near vertices against plain numpy, and solids against another library."""

from __future__ import annotations

import dataclasses

import coal
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.labels.bounding_spheres import part_balls
from halfphysics.labels.item_solids import ItemSolids, Solid, item_solids
from halfphysics.labels.proximity import Target, near
from halfphysics.labels.sampling import ObjectSurface, covered
from halfphysics.results.result import ObjectTrack
from support.forearms import forearm, wavy
from support.judges.coal_shapes import coal_shape
from support.references.labels import near_reference, solid_distance

#: Both compute the same sums in another order.
ROUNDING = 1e-12
EVERYTHING = np.ones(55, dtype=bool)


def _shapes() -> dict[str, hp.Box | hp.Sphere | hp.Capsule | hp.Cylinder | hp.Mesh]:
    rng = np.random.default_rng(5)
    cloud = hp.Mesh(*hp.Box((0.3, 0.2, 0.4)).triangles())
    return {
        "box": hp.Box((0.3, 0.2, 0.5)),
        "ball": hp.Sphere(0.2),
        "capsule": hp.Capsule(0.1, 0.4),
        "cylinder": hp.Cylinder(0.15, 0.4),
        "hull": hp.Mesh(cloud.vertices + 0.02 * rng.normal(size=(8, 3)), cloud.faces).hull,
    }


@pytest.mark.parametrize("name", _shapes())
def test_distances_of_solids_are_those_of_another_library(name):
    shape = _shapes()[name]
    rng = np.random.default_rng(1)
    turn = rot.to_matrix(rot.normalize(rng.normal(size=4)))
    position = np.array([0.1, -0.2, 0.3])
    solid = Solid(shape, position, turn)
    points = position + rng.uniform(-0.6, 0.6, size=(300, 3))
    distance = solid_distance(solid, points)
    body = coal_shape(shape, solid=True)
    place, dot = coal.Transform3s(turn, position), coal.Sphere(1e-6)
    judged = np.empty(len(points))
    for i, point in enumerate(points):
        found = coal.DistanceResult()
        at = coal.Transform3s(np.eye(3), point)
        judged[i] = coal.distance(body, place, dot, at, coal.DistanceRequest(), found) + 1e-6
    outside = judged > 1e-5
    assert 50 < outside.sum() < 300
    np.testing.assert_allclose(distance[outside], judged[outside], atol=1e-6)
    assert (distance[~outside] < 1e-5).all()
    item = ItemSolids("it", (solid,), np.zeros((1, 3)), np.eye(3)[None], True, EVERYTHING)
    np.testing.assert_allclose(item.distance(points), distance, rtol=0, atol=ROUNDING)


@pytest.mark.slow
@pytest.mark.parametrize("reach", [0.002, 0.03])
def test_the_core_finds_what_plain_numpy_finds(reach):
    body, motion = forearm(), wavy(2)
    joints = body.joints(motion)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(offset=float(joints[0, 18, 2])))
    scene.add_static(
        "stairs", hp.Mesh(*hp.Box((0.2, 0.2, 0.1)).triangles()), position=joints[0, 20]
    )
    scene.add_static("pillar", hp.Cylinder(0.1, 2.0), position=joints[0, 16])
    for i, (name, shape) in enumerate(_shapes().items()):
        scene.add_object(name, shape, mass=1.0, position=joints[0, [18, 20, 37, 38, 39][i]])
    shift, turn = np.linspace(0.0, 0.03, 2)[:, None], np.linspace(0.0, 0.4, 2)[:, None]
    tracks = {
        name: ObjectTrack(
            position=item.position + shift + 0.05, quaternion=rot.exp(turn * [0.3, 0.2, 0.9])
        )
        for name, item in scene.objects.items()
    }
    targets = []
    for item in item_solids(scene, tracks):
        surface = None
        if not item.stands:
            shape = scene.objects[item.name].shape
            mesh = isinstance(shape, hp.Mesh)
            vertices, faces = shape.triangles() if mesh else covered(shape, 0.04)
            surface = ObjectSurface(name=item.name, vertices=vertices, faces=faces, off=0.0)
        targets.append(Target(item, reach, surface))
    seen = np.zeros(2)
    for target, found in zip(targets, near(body, motion, targets), strict=True):
        for side, (mine, its) in enumerate(
            zip(found, near_reference(body, motion, target), strict=True)
        ):
            assert np.array_equal(mine.frame, its.frame), target.item.name
            assert np.array_equal(mine.vertex, its.vertex)
            np.testing.assert_allclose(mine.distance, its.distance, rtol=0, atol=ROUNDING)
            np.testing.assert_allclose(mine.point, its.point, rtol=0, atol=1e-9)
            seen[side] += len(mine)
    assert (seen >= [300, 2]).all()


def test_a_part_that_passes_through_is_not_labelled():
    body, motion = forearm(), wavy(2)
    hand = body.joints(motion)[0, 20]
    scene = hp.Scene()
    scene.add_object("ball", hp.Sphere(0.2), mass=1.0, position=hand)
    scene.ignore("ball", "person/left_wrist")
    tracks = {"ball": ObjectTrack(position=[hand, hand], quaternion=[[1, 0, 0, 0]] * 2)}
    (item,) = item_solids(scene, tracks)
    vertices, faces = covered(hp.Sphere(0.2), 0.05)
    surface = ObjectSurface(name="ball", vertices=vertices, faces=faces, off=0.0)
    target = Target(item, 0.01, surface)
    ((skin, surface),) = near(body, motion, [target])
    part = part_balls(body).part
    assert len(skin)
    assert not (part[skin.vertex] == 20).any()
    reference = near_reference(body, motion, target)
    assert np.array_equal(skin.vertex, reference[0].vertex)
    assert np.array_equal(surface.vertex, reference[1].vertex)


@pytest.mark.parametrize("shapes", [False, True])
@pytest.mark.parametrize("kind", ["parts", "clusters"])
def test_every_face_that_reaches_into_a_group_is_in_its_ball(kind, shapes):
    body, motion = forearm(), wavy()
    if shapes:
        rng = np.random.default_rng(2)
        posedirs = 0.01 * rng.normal(size=(len(body.rest_vertices), 3, 486))
        body = dataclasses.replace(body, posedirs=posedirs)
    balls = part_balls(body)
    group, some = (balls.part, balls.parts) if kind == "parts" else (balls.cluster, balls.clusters)
    assert np.array_equal(balls.of[balls.cluster], balls.part)
    moved = motion.rotations, *body.joint_frames(motion)
    centres, radii = some.at(*moved)
    posed = body.vertices(motion)
    whose = group[body.faces]
    for corner in range(3):
        for other in range(3):
            place, its = posed[:, body.faces[:, other]], whose[:, corner]
            apart = np.linalg.norm(place - centres[:, its], axis=2)
            assert (apart <= radii[:, its]).all()
    apart = np.linalg.norm(posed - centres[:, group], axis=2)
    if not shapes:  # and no ball is much larger than the group
        for g in np.unique(group):
            assert (radii[:, g] < apart[:, group == g].max(axis=1) + 0.15).all()
    wanted = np.random.default_rng(3).random(radii.shape) < 0.5
    few = some.at(*moved, wanted)
    assert np.array_equal(few[0][wanted], centres[wanted])
    assert np.array_equal(few[1][wanted], radii[wanted])
    assert (few[1][~wanted] == -np.inf).all()

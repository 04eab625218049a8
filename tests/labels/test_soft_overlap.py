"""Vertices inside soft things, and those of soft things inside the skin."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.mesh_queries import MeshQuery
from halfphysics.geometry.subdivision import subdivided
from halfphysics.labels import contact_labels
from halfphysics.labels.item_solids import item_solids
from halfphysics.labels.proximity import Target, near
from halfphysics.labels.sampling import ObjectSurface, covered
from halfphysics.results.result import ObjectTrack, Result
from support.forearms import forearm, wavy
from support.references.labels import near_reference

FOAM = hp.Soft(thickness=0.12, stiffness=3e4)


def _lying(shape: hp.Box | hp.Mesh) -> Result:
    scene = hp.Scene()
    scene.add_static("bed", shape, position=(0.0, 0.0, 0.2), soft=FOAM)
    motion = hp.Motion(np.tile([0.0, 0.0, 0.49], (12, 1)), np.zeros((12, 55, 3)), 30.0)
    return hp.simulate(motion, scene)


def _fine(box: hp.Box) -> hp.Mesh:
    corners, faces = box.triangles()
    return hp.Mesh(*subdivided(np.asarray(corners), np.asarray(faces), 0.1, 20_000))


def test_skin_is_labelled_however_deep_it_sinks_into_a_box_or_a_mesh():
    box = hp.Box((2.4, 4.0, 0.4))
    for shape in (box, _fine(box), hp.Mesh(*box.triangles())):
        result = _lying(shape)
        labels = contact_labels(result)
        body, touched = result.people[0].body, labels.people[0].scene > 0
        height = body.vertices(result.motion)[..., 2]
        assert height.min() < 0.33  # 7 cm and more under the surface
        threshold = labels.threshold_m
        assert np.array_equal(touched, height <= 0.4 + threshold)


def test_all_vertices_of_a_cushion_that_are_inside_the_skin_are_labelled():
    scene = hp.Scene(gravity=0.0)
    cushion = hp.Box((0.3, 0.3, 0.2))
    body = Body.default()
    lying = hp.Motion(np.tile([0.0, 0.0, 1.0], (4, 1)), np.zeros((4, 55, 3)), 30.0)
    top = body.vertices(lying, frames=[0])[0][:, 2].max()
    scene.add_object(
        "cushion",
        cushion,
        mass=20.0,
        position=(0.0, 0.0, top + 0.11),
        velocity=(0.0, 0.0, -1.2),
        soft=hp.Soft(thickness=0.08, stiffness=1e4),
    )
    result = hp.simulate(lying, scene)
    labels = contact_labels(result)
    track, surface, most = result.objects["cushion"], labels.objects[0].vertices, 0.0
    for frame in range(len(result)):
        skin = body.vertices(result.motion, frames=[frame])[0]
        world = rot.rotate(track.quaternion[frame], surface) + track.position[frame]
        depth = MeshQuery(skin, body.faces).depth(world)
        found = labels.object_ids(0, 0)[frame] > 0
        assert found[depth > 0.0].all()
        most = max(most, depth.max())
    assert most > 0.01


@pytest.mark.parametrize("reach", [0.002, 0.03])
def test_soft_things_are_near_as_plain_numpy_finds(reach):
    body, motion = forearm(), wavy(2)
    joints = body.joints(motion)
    scene = hp.Scene()
    block = hp.Mesh(*hp.Box((0.3, 0.3, 0.3)).triangles())
    scene.add_static("block", block, position=joints[0, 20], soft=FOAM)
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, soft=hp.Soft(thickness=0.05, stiffness=1e4))
    place = joints[:, 18] + np.array([0.02, 0.0, 0.0])
    tracks = {"ball": ObjectTrack(position=place, quaternion=[[1, 0, 0, 0]] * 2)}
    vertices, faces = covered(hp.Sphere(0.1), 0.03)
    surface = ObjectSurface(name="ball", vertices=0.5 * vertices, faces=faces, off=0.0)
    items = item_solids(scene, tracks)
    targets = [Target(item, reach, None if item.stands else surface) for item in items]
    for target, found in zip(targets, near(body, motion, targets), strict=True):
        assert (found[0].distance == 0.0).sum() > 100
        for mine, its in zip(found, near_reference(body, motion, target), strict=True):
            assert np.array_equal(mine.frame, its.frame)
            assert np.array_equal(mine.vertex, its.vertex)
            np.testing.assert_allclose(mine.distance, its.distance, rtol=0, atol=1e-12)
            np.testing.assert_allclose(mine.point, its.point, rtol=0, atol=1e-9)
    assert len(found[1]) > 5

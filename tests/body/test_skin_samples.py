"""Samples of the skin: areas sum to the skin's, and they lie as far apart as they should."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import halfphysics as hp
from halfphysics.body.skin_samples import (
    BALL,
    FINE,
    IN_A_FOLD,
    PITCH,
    reachable,
    skin_samples,
    vertex_areas,
)
from halfphysics.motion.joint_groups import JOINT_GROUPS
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from support.judges.triangle_soup import to_triangles


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


@pytest.fixture(scope="module")
def samples(body):
    return skin_samples(body)


def test_areas_sum_to_the_skin_of_every_part_that_is_in_no_fold(body, samples):
    area, _ = vertex_areas(body.rest_vertices, body.faces)
    own = np.bincount(body.weights.argmax(axis=1), area * reachable(body), 55)
    assert np.bincount(samples.part, samples.area, 55) == pytest.approx(own, rel=1e-12)
    assert area.sum() == pytest.approx(1.78, abs=0.02)  # of 1.73 m and 62 litres


def test_skin_is_in_a_fold_where_a_ball_on_it_meets_other_skin(body):
    """By distances from all triangles around, of every hundredth vertex and of the pelvis."""
    triangles = body.rest_vertices[body.faces]
    middles = cKDTree(triangles.mean(axis=1))
    part = body.weights.argmax(axis=1)
    some = np.union1d(np.arange(0, len(part), 100), np.flatnonzero(part == 0))
    names = np.array(JOINT_NAMES)[part[some]]
    hands_and_feet = np.isin(names, JOINT_GROUPS["hands"] + JOINT_GROUPS["feet"])
    _, way = vertex_areas(body.rest_vertices, body.faces)
    way = way[some] / np.linalg.norm(way[some], axis=1, keepdims=True)
    centre = body.rest_vertices[some] + BALL * way
    around = middles.query_ball_point(centre, 0.06)
    distance = np.array(
        [
            to_triangles(np.broadcast_to(c, (len(near), 3)), triangles[near]).min()
            for c, near in zip(centre, around, strict=True)
        ]
    )
    open_to = (distance >= (1.0 - IN_A_FOLD) * BALL) | hands_and_feet
    assert (reachable(body)[some] == open_to).mean() > 0.998  # left and right are one
    # Folds of the pelvis are on its middle, in the cleft.
    folds = np.flatnonzero(~reachable(body) & (part == 0))
    assert 0 < len(folds) < 0.2 * (part == 0).sum()
    assert np.abs(body.rest_vertices[folds, 0]).max() < 0.05


def test_samples_are_vertices_that_the_hulls_have(body, samples):
    assert np.isin(samples.vertex, body.skin_corners.vertex).all()
    assert len(np.unique(samples.vertex)) == len(samples)


def test_neighbours_are_one_to_two_pitches_apart(samples):
    own = samples.area[samples.part == JOINT_INDEX["left_hip"]]
    assert PITCH < np.sqrt(np.median(own)) < 2.0 * PITCH
    assert own.max() < (4.0 * PITCH) ** 2
    sole = samples.area[samples.part == JOINT_INDEX["left_ankle"]]
    assert FINE < np.sqrt(np.median(sole)) < 2.0 * FINE  # as the skin's own vertices


def test_normals_point_outward(body, samples):
    assert np.linalg.norm(samples.normal, axis=1) == pytest.approx(1.0)
    seat = samples.part == JOINT_INDEX["left_hip"]
    away = body.rest_vertices[samples.vertex[seat]] - body.rest_joints[JOINT_INDEX["left_hip"]]
    away[:, 1] = 0.0  # around the thigh, which hangs down at rest
    assert (np.einsum("ij,ij->i", away, samples.normal[seat]) > 0.0).mean() > 0.9


def test_they_are_made_once_per_body_and_the_same_every_time(body, samples):
    assert skin_samples(body) is samples
    again = skin_samples(hp.Body.default(betas=np.zeros(10)))
    assert np.array_equal(again.vertex, samples.vertex)


@pytest.mark.parametrize("betas", [None, [2.0, -1.0, 0.5]])
def test_samples_of_the_right_are_images_of_those_of_the_left(betas):
    body = hp.Body.default(betas)
    samples, image = skin_samples(body), body.symmetry.vertex
    at = {int(v): k for k, v in enumerate(samples.vertex)}
    other = np.array([at[int(image[v])] for v in samples.vertex])
    np.testing.assert_array_equal(samples.area, samples.area[other])
    np.testing.assert_array_equal(samples.normal, samples.normal[other] * [-1.0, 1.0, 1.0])

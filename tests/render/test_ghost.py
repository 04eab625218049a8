"""A ghost fades where it coincides with the body: by vertex in pictures, by part in a browser."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.render.ghost import PARTS, Separation, faded, opacity, parts
from halfphysics.render.look import GHOST_ALPHA
from halfphysics.render.rasterizer import Surface


def test_nothing_below_a_centimetre_everything_from_three():
    distances = np.array([0.0, 0.010, 0.020, 0.030, 1.0])
    expected = GHOST_ALPHA * np.array([0.0, 0.0, 0.5, 1.0, 1.0])
    np.testing.assert_allclose(opacity(distances), expected, atol=1e-12)


def strip(n=200):
    """A strip of length 1 and width 0.1, whose distance from the body grows to 5 cm."""
    x = np.linspace(0.0, 1.0, n)
    vertices = np.array([[a, b, 0.0] for a in x for b in (0.0, 0.1)])
    k = 2 * np.arange(n - 1)[:, None]
    faces = np.concatenate([k + [0, 2, 1], k + [1, 2, 3]])  # noqa: RUF005
    surface = Surface(vertices=vertices, faces=faces, alpha=GHOST_ALPHA, rim=0.4)
    return surface, 0.05 * vertices[:, 0]


def test_bands_follow_each_other_and_are_the_part_that_is_apart():
    surface, apart = strip()
    bands = faded(surface, apart)
    alphas = [band.alpha for band in bands]
    assert alphas == sorted(alphas)
    assert alphas[-1] == GHOST_ALPHA
    ends = [(b.vertices[:, 0].min(), b.vertices[:, 0].max()) for b in bands]
    assert ends[0][0] == pytest.approx(0.2)  # 1 cm
    assert ends[-1] == pytest.approx((0.6, 1.0))  # 3 cm
    for (_, end), (start, _) in itertools.pairwise(ends):
        assert end == pytest.approx(start)
    # The steps are those of the curve.
    middles = [0.05 * 0.5 * (a + b) for a, b in ends]
    np.testing.assert_allclose(alphas, opacity(np.array(middles)), atol=1e-12)


def test_a_ghost_on_the_body_is_not_drawn():
    surface, apart = strip()
    assert faded(surface, 0.0 * apart) == []
    assert len(faded(surface, 0.0 * apart + 0.2)) == 1


@pytest.fixture(scope="module")
def poses():
    """Two poses that differ by a turn of the left elbow, and a body."""
    rng = np.random.default_rng(4)
    rotations = np.zeros((2, N_JOINTS, 3))
    rotations[:, 1:22] = 0.3 * rng.normal(size=(21, 3))
    rotations[1, JOINT_INDEX["left_elbow"]] += [0.0, 0.2, 0.0]
    return Body.default(), Motion(np.zeros((2, 3)), rotations, 30.0)


def test_parts_are_the_whole_skin(poses):
    body = poses[0]
    found = parts(body)
    assert list(found) == list(PARTS)
    assert sorted(j for joints in PARTS.values() for j in joints) == list(range(N_JOINTS))
    total = sum(len(part.faces) for part in found.values())
    assert total >= len(body.faces)


def test_only_the_part_that_moved_is_apart(poses):
    body, motion = poses
    positions, quaternions = body.joint_frames(motion)
    apart = Separation(body).of((positions[0], quaternions[0]), (positions[1], quaternions[1]))
    moved = {name for name, distance in apart.items() if distance > 1e-9}
    assert moved == {"left-hand"}
    # About as far as the furthest vertex of the skin.
    one, other = body.vertices(motion)
    furthest = np.linalg.norm(one - other, axis=1).max()
    assert apart["left-hand"] == pytest.approx(furthest, rel=0.1)


def test_a_body_that_is_moved_is_apart_by_that(poses):
    body, motion = poses
    positions, quaternions = body.joint_frames(motion)
    aside = positions[0] + np.array([0.0, 0.03, 0.04])
    apart = Separation(body).of((positions[0], quaternions[0]), (aside, quaternions[0]))
    np.testing.assert_allclose(list(apart.values()), 0.05, atol=1e-12)

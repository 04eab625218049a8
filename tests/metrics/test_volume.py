"""Penetrating volume against closed forms: overlaps of a box, a ball and a body with a scene."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.body.mass import close_holes
from halfphysics.errors import InputError
from halfphysics.geometry.mesh_solids import solid_moments
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Shape, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from support.point_bodies import Ball, Cloud, Drift

SIZE = np.array([0.3, 0.4, 0.5])
TURNED = {"quaternion": (0.4, 0.3, 0.2, 0.7)}


def _block(size: np.ndarray = SIZE) -> Ball:
    """A body that is a box about the origin."""
    vertices, faces = Box(size.tolist()).triangles()
    return Ball(np.asarray(vertices), np.asarray(faces))


def _volume(*things: tuple[Shape, dict[str, Any]], body: Any = None, **options: Any) -> float:
    scene = Scene()
    for number, (shape, pose) in enumerate(things):
        scene.add_static(f"thing{number}", shape, **pose)
    still = Drift(np.zeros((1, 3)))
    return metrics.penetrating_volume(still, body or _block(), scene, **options).volume[0]


BALL = 4.0 / 3.0 * np.pi * 0.1**3


@pytest.mark.parametrize(
    ("things", "exact"),
    [
        ([(Plane(), {})], 0.5 * SIZE.prod()),
        ([(Plane((1.0, 2.0, 3.0)), {})], 0.5 * SIZE.prod()),
        ([(Plane((1.0, 0.0, 0.0), 0.05), {})], 0.2 / 0.3 * SIZE.prod()),
        ([(Plane(offset=-0.3), {})], 0.0),
        ([(Box((3.0, 3.0, 3.0)), TURNED)], SIZE.prod()),
        ([(Box((1.0, 1.0, 1.0)), {"position": (0.55, 0.6, 0.65)})], 0.1**3),
        ([(Sphere(0.1), {})], BALL),
        ([(Sphere(0.1), {"position": (0.15, 0.0, 0.0)})], 0.5 * BALL),
        ([(Capsule(0.05, 0.2), TURNED)], np.pi * 0.05**2 * (0.2 + 4.0 / 3.0 * 0.05)),
        ([(Capsule(0.05, 0.2), {})], np.pi * 0.05**2 * (0.2 + 4.0 / 3.0 * 0.05)),
        ([(Cylinder(0.05, 0.2), TURNED)], np.pi * 0.05**2 * 0.2),
        ([(Cylinder(0.05, 0.2), {"position": (0.0, 0.0, 0.25)})], np.pi * 0.05**2 * 0.1),
        ([(Sphere(0.1), {"position": (0.5, 0.0, 0.0)})], 0.0),
    ],
    ids=str,
)
def test_a_box_and_a_thing(things: list[tuple[Shape, dict[str, Any]]], exact: float) -> None:
    # Measured up to 0.08 % of a ball of 10 cm, 0.23 % of a disc of 5 cm.
    assert _volume(*things) == pytest.approx(1e6 * exact, rel=4e-3, abs=1e-6)


def test_what_things_share_counts_once() -> None:
    slab = Box((0.1, 1.0, 1.0))
    once = _volume((slab, {}))
    assert once == pytest.approx(1e6 * 0.1 * 0.4 * 0.5, rel=1e-3)
    assert _volume((slab, {}), (slab, {}), (Box((0.02, 0.05, 0.05)), TURNED)) == pytest.approx(once)
    apart = _volume((slab, {"position": (0.1, 0, 0)}), (slab, {"position": (-0.1, 0, 0)}))
    assert apart == pytest.approx(2 * once, rel=2e-3)
    # Two bodies in one skin that overlap.
    vertices, faces = Box((0.2, 0.2, 0.2)).triangles()
    double = Ball(np.concatenate([vertices] * 2), np.concatenate([faces, faces + len(vertices)]))
    assert _volume((Plane(offset=1.0), {}), body=double) == pytest.approx(8000.0, rel=2e-3)


@pytest.mark.parametrize("holes", [0, 7])
def test_meshes_closed_and_open(holes: int) -> None:
    vertices, faces = Sphere(0.1).triangles()
    whole = Mesh(vertices, faces)
    found = _volume((Mesh(vertices, faces[holes:]), TURNED))
    assert found == pytest.approx(1e6 * whole.volume, rel=2e-3)


def test_a_hollow_mesh_holds_nothing_in_its_middle() -> None:
    vertices, faces = Sphere(0.1).triangles()
    faces = np.concatenate([faces, faces[:, ::-1] + len(vertices)])
    hollow = Mesh(np.concatenate([vertices, 0.5 * vertices]), faces)
    assert _volume((hollow, {})) == pytest.approx(1e6 * hollow.volume, rel=2e-3)
    assert hollow.volume == pytest.approx(0.875 * Mesh(*Sphere(0.1).triangles()).volume)


@given(
    st.lists(st.floats(0.05, 0.6), min_size=3, max_size=3),
    st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=3),
)
@settings(max_examples=40, deadline=None)
def test_two_boxes_anywhere(size: list[float], at: list[float]) -> None:
    """Aligned boxes overlap by a product; rays that miss or hit an edge cause the error."""
    low = np.maximum(-0.5 * SIZE, np.array(at) - 0.5 * np.array(size))
    high = np.minimum(0.5 * SIZE, np.array(at) + 0.5 * np.array(size))
    side = np.maximum(high - low, 0.0)
    found = _volume((Box(size), {"position": at}))
    # Half a ray along the rim, of which about the square root does not average out.
    rim = 2.0 * (side[0] + side[1]) * side[2] * 0.004
    assert abs(found - 1e6 * side.prod()) <= 1e6 * 0.2 * rim + 1e-6


def test_the_error_is_told() -> None:
    """A plane cuts a ball at any place: the error has the reported size."""
    rng = np.random.default_rng(0)
    vertices, faces = Sphere(0.1).triangles()
    body = Ball(np.asarray(vertices), np.asarray(faces))
    frames = Drift(rng.uniform(-0.08, 0.08, (12, 3)) * [0.0, 0.0, 1.0])
    scene = Scene()
    scene.add_static("floor", Plane())
    fine = metrics.penetrating_volume(frames, body, scene, pitch=0.0015)
    usual = metrics.penetrating_volume(frames, body, scene)
    off = np.abs(usual.volume - fine.volume)
    assert (off <= 3.0 * usual.error + 1e-3 * fine.volume).all()
    assert usual.error.max() < 0.02 * usual.volume.max()
    assert usual.mean_cm3 == pytest.approx(usual.volume.mean())
    assert usual.max_cm3 == usual.volume.max()


def test_a_body_half_in_the_floor() -> None:
    """A body under a plane has its skin's volume; across it, the parts add up."""
    body = Body.default()
    rotations = np.zeros((2, 55, 3))
    rotations[1, 0] = [0.3, 0.2, 0.1]
    motion = Motion(np.zeros((2, 3)), rotations, 30.0)
    under, below, above = Scene(), Scene(), Scene()
    under.add_static("x", Plane(offset=5.0))
    below.add_static("x", Plane((0.2, 0.1, 1.0)))
    above.add_static("x", Plane((-0.2, -0.1, -1.0)))
    whole, low, high = (
        metrics.penetrating_volume(motion, body, s).volume for s in (under, below, above)
    )
    exact = [1e6 * solid_moments(*close_holes(v, body.faces))[0] for v in body.vertices(motion)]
    # Self-overlaps count once by rays, several times by faces: under a litre in sixty.
    np.testing.assert_allclose(whole, exact, rtol=0.005)
    np.testing.assert_allclose(low + high, whole, rtol=1e-9)
    assert (low > 0.2 * whole).all()


def test_objects_move_and_what_is_ignored_is_not_there() -> None:
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1.0)
    path = np.array([[0.0, 0, 0], [0.15, 0, 0], [2.0, 0, 0]])
    turn = rot.exp(np.array([[0.1, 0.2, 0.3]] * 3))
    track = SimpleNamespace(position=path, quaternion=turn)
    still = Drift(np.zeros((3, 3)))
    found = metrics.penetrating_volume(still, _block(), scene, objects={"ball": track}).volume
    np.testing.assert_allclose(found, 1e6 * BALL * np.array([1.0, 0.5, 0.0]), rtol=2e-3)
    scene.ignore("ball", "person")
    again = metrics.penetrating_volume(still, _block(), scene, objects={"ball": track})
    assert again.max_cm3 == 0.0


def test_impossible_volumes() -> None:
    still = Drift(np.zeros((2, 3)))
    with pytest.raises(InputError, match="pitch"):
        metrics.penetrating_volume(still, _block(), Scene(), pitch=0.0)
    with pytest.raises(InputError, match="body: expected one with faces"):
        metrics.penetrating_volume(still, Cloud(np.zeros((3, 3))), Scene())
    with pytest.raises(InputError, match=r"scene: expected a halfphysics\.Scene"):
        metrics.penetrating_volume(still, _block(), None)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no object 'bell'"):
        metrics.penetrating_volume(still, _block(), Scene(), objects={"bell": None})

"""The support in the scene: nodes hold the forces of `PersonResult.support`, frame by frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.support.skin_grid import PITCH
from halfphysics.viewer import support_overlay as overlay
from halfphysics.viewer.support_overlay import SupportFrames, SupportOverlay, level
from support.standing import ARMS_DOWN, raised, still

pytest.importorskip("viser")

BODY = hp.Body.default()
#: Arrows and points are sent in numbers of four bytes: their error [m].
SENT = 1e-6


def on_floor():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    return scene


@pytest.fixture(scope="module")
def result():
    """Two people who stand, the second 2 m ahead and held by nothing, 0.5 m above the floor."""
    standing = still(BODY, ARMS_DOWN)
    other = raised(standing, 0.5)
    other = hp.Motion(other.translation + np.array([2.0, 0.0, 0.0]), other.rotations, other.fps)
    settings = hp.Settings(weight=False)
    return hp.simulate([standing, other], on_floor(), settings=settings)


@pytest.fixture(scope="module")
def server():
    from halfphysics.viewer.server import close_server, open_server

    server = open_server("127.0.0.1", 0)
    yield server
    close_server(server)


@pytest.fixture
def stage(server, result):
    from halfphysics.viewer.stage import Stage

    return Stage(server, result)


def test_nothing_is_worked_out_until_it_is_shown(server, stage):
    made = SupportOverlay(server, stage)
    stage.show(3)
    assert made.frames is None
    assert not made.forces.handle.visible
    made.visible = True
    assert made.frames is not None
    assert made.forces.handle.visible
    made.visible = False
    nodes = [*made.discs, made.forces, made.missing, *made.points.values()]
    assert not any(node.handle.visible for node in nodes)
    kept = made.frames
    made.visible = True
    assert made.frames is kept


def test_arrows_of_who_stands_add_up_to_the_weight(server, stage, result):
    made = SupportOverlay(server, stage)
    made.visible = True
    stage.show(5)
    start, end = np.moveaxis(np.array(made.forces.handle.points, dtype=float), 1, 0)
    weight = result.people[0].support.weight
    assert (end - start).sum(axis=0) == pytest.approx([0, 0, overlay.SCALE * weight], abs=2e-3)
    # The arrow starts on the floor, between the outlines of the feet.
    feet = BODY.joints(result.motion[5])[[JOINT_INDEX[f"{s}_ankle"] for s in ("left", "right")]]
    assert start[0, 2] == pytest.approx(0.0, abs=5e-3)
    assert feet[:, 1].min() < start[0, 1] < feet[:, 1].max()
    # Nothing supplies what the second person would need.
    start, end = np.moveaxis(np.array(made.missing.handle.points, dtype=float), 1, 0)
    assert len(start) == 1
    np.testing.assert_allclose(start[0], result.people[1].support.com[5], atol=SENT)
    along = overlay.SCALE * result.people[1].support.residual[5, :3]
    np.testing.assert_allclose(end[0] - start[0], along, atol=SENT)
    assert along[2] == pytest.approx(overlay.SCALE * weight, rel=0.02)


def test_discs_lie_on_the_skin_and_carry_the_weight(server, stage, result):
    made = SupportOverlay(server, stage)
    made.visible = True
    stage.show(5)
    pressure = result.people[0].support.pressure
    pressure = pressure[pressure.frame == 5]
    here = made.frames.at(5)
    assert here.pressure.sum() * PITCH**2 == pytest.approx(
        result.people[0].support.weight, rel=0.02
    )
    shown = [d.handle for d in made.discs if d.handle.visible]
    assert len(shown) == len(np.unique(level(here.pressure)))
    positions = np.concatenate([np.array(h.batched_positions) for h in shown])
    turns = np.concatenate([np.array(h.batched_wxyzs, dtype=float) for h in shown])
    assert len(positions) == len(pressure.frame) > 10
    np.testing.assert_allclose(rot.rotate(turns, [0.0, 0.0, 1.0]), [[0.0, 0.0, 1.0]] * len(turns))
    wanted = pressure.position + 0.002 * pressure.normal
    np.testing.assert_allclose(np.sort(positions, axis=0), np.sort(wanted, axis=0), atol=SENT)


@pytest.mark.parametrize(
    "normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, -0.8), (0, -0.6, 0.8)]
)
def test_discs_face_along_the_normal(normal):
    (turn,) = overlay._facing(np.array([normal], dtype=float))
    np.testing.assert_allclose(rot.rotate(turn, [0.0, 0.0, 1.0]), normal, atol=1e-12)
    assert np.linalg.norm(turn) == pytest.approx(1.0)


def test_in_flight_there_is_no_centre_of_pressure_but_the_plumb_goes_on(result):
    support = result.people[0].support
    cop, force = support.cop.copy(), support.force.copy()
    cop[8:12], force[8:12] = np.nan, 0.0
    grounded = (support.pressure.frame < 8) | (support.pressure.frame >= 12)
    flying = replace(support, cop=cop, force=force, pressure=support.pressure[grounded])
    frames = SupportFrames([flying])
    assert len(frames.at(7).cop) == 1
    here = frames.at(9)
    assert len(here.cop) == len(here.forces) == len(here.pressure) == 0
    np.testing.assert_allclose(here.plumb[0, :2], support.com[9, :2], atol=1e-12)
    assert here.plumb[0, 2] == pytest.approx(0.0, abs=5e-3)


def test_who_never_touches_anything_has_no_plumb(result):
    here = SupportFrames([result.people[1].support]).at(4)
    assert len(here.plumb) == len(here.cop) == len(here.forces) == 0
    np.testing.assert_array_equal(here.com, result.people[1].support.com[4:5])


def test_arrows_are_linear_between_their_bounds():
    forces = np.array([[0, 0, 1.0], [0, 0, 10.0], [0, 0, 600.0], [0, -1200.0, 0], [9e3, 0, 0]])
    arrows = overlay._arrows(np.zeros((5, 3)), forces)
    lengths = np.linalg.norm(arrows[:, 1] - arrows[:, 0], axis=1)
    np.testing.assert_allclose(lengths, [overlay.SHORTEST, 0.6, 1.2, overlay.LONGEST])

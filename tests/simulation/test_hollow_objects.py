"""Hollows stay open: a hand through a ring, a foot under a chair, contact at the true surface."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.contact_pieces import joined
from halfphysics.geometry.shapes import Box, Mesh, Plane
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.judges.skin_judge import SkinJudge
from support.people import t_pose

trimesh = pytest.importorskip("trimesh")

#: The ring [m]: radius of the tube's centre line, radius of the tube. A flat hand is 16 cm across.
MAJOR, MINOR, SECTORS = 0.107, 0.012, 32
#: Position of its centre [m]; the left hand moves along y.
PLACE = np.array([0.0308, 0.56, 0.4638])
AROUND_X = rot.exp([np.pi / 2, 0.0, 0.0])
#: Untouched objects are unchanged to this [m].
UNTOUCHED = 1e-9
#: Clearance of the skin [m].
CLEARANCE = Settings().clearance


@pytest.fixture(scope="module")
def body():
    return Body.default()


def ring():
    return trimesh.creation.torus(MAJOR, MINOR, major_sections=SECTORS, minor_sections=12)


def sectors():
    """The ring as convex pieces: a prism over each of its straight sections."""
    mesh, pieces = ring(), []
    sector = np.round(np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]) / (2 * np.pi) * SECTORS)
    for k in range(SECTORS):
        ends = np.isin(sector.astype(int) % SECTORS, (k, (k + 1) % SECTORS))
        pieces.append(trimesh.convex.convex_hull(mesh.vertices[ends]))
    return pieces


def from_ring(points):
    """Signed distances (n,) of points (n, 3) to the torus, negative inside."""
    x, y, z = points.T
    return np.hypot(np.hypot(x, y) - MAJOR, z) - MINOR


def chair_boxes():
    """Seat, back and four legs; the seat's top at 0.46 m, its front at x = 0."""
    seat = Box((0.44, 0.5, 0.04)), (0.22, 0.0, 0.44)
    back = Box((0.03, 0.5, 0.44)), (0.425, 0.0, 0.68)
    legs = [(Box((0.04, 0.04, 0.42)), (x, y, 0.21)) for x in (0.02, 0.42) for y in (-0.23, 0.23)]
    boxes = []
    for box, at in (seat, back, *legs):
        vertices, faces = box.triangles()
        boxes.append(Mesh(vertices + np.array(at), faces))
    return boxes


def run(body, scene, path):
    """A person in T-pose along a path (T, 3), every substep recorded, and the judges' verdicts."""
    result = simulate(t_pose(path), scene, body=body, settings=Settings(record="substeps"))
    judge = SkinJudge(body, scene, samples=2000)
    return (
        result,
        judge.judge_result(result, every=8, coal_every=8),
        judge.penetration(result.motion, result.objects),
    )


def touched(result, name):
    """Parts that touch an object, and the points and frames of contact."""
    contacts = result.contacts
    rows = (contacts.person == 0) & (contacts.other == result.names.index(name))
    parts = {JOINT_NAMES[i] for i in contacts.part[rows]}
    return parts, contacts.position[rows], contacts.frame[rows]


def during(result, name, frame, point):
    """A world point in an object's frame at the substeps of a frame (n, 3)."""
    track = result.substeps.objects[name]
    n = (len(track.position) - 1) // (len(result) - 1)
    steps = slice((frame - 1) * n, frame * n + 1)
    return rot.rotate(rot.conjugate(track.quaternion[steps]), point - track.position[steps])


def along(direction, end, speed=0.5, fps=30.0):
    return np.outer(np.arange(0.0, end, speed / fps), direction)


def with_ring(pieces, position):
    scene = Scene(gravity=0.0)
    return scene, scene.add_object(
        "ring",
        ring(),
        mass=0.2,
        position=position,
        quaternion=AROUND_X,
        start="asleep",
        pieces=pieces,
    )


@pytest.fixture(params=["own", "coacd"])
def pieces(request):
    if request.param == "own":
        return sectors()
    pytest.importorskip("coacd")
    return "auto"


def test_a_hand_goes_through_a_ring_and_touches_nothing(body, pieces):
    scene, thing = with_ring(pieces, PLACE)
    assert len(thing.pieces) >= 8
    result, verdict, penetration = run(body, scene, along([0.0, 1.0, 0.0], 0.25))
    # The hand has passed: fingers beyond, the wrist before it, all of it within the hull.
    skin = body.vertices(result.motion)[-1]
    assert skin[:, 1].max() > PLACE[1] + 0.12
    local = rot.rotate(rot.conjugate(AROUND_X), skin - PLACE)
    assert thing.shape.hull.depth(local).max() > 0.9 * MINOR
    assert not touched(result, "ring")[0]
    track = result.objects["ring"]
    assert np.abs(track.position - PLACE).max() < UNTOUCHED
    assert np.abs(track.quaternion - AROUND_X).max() < UNTOUCHED
    assert verdict.clear, verdict
    assert verdict.gap > CLEARANCE
    assert penetration == (0.0, 0.0)


def test_a_hand_touches_the_ring_where_it_is(body, pieces):
    """The tube is in the way of the fingers: met there, not before, and pushed along."""
    at = PLACE + np.array([0.0, 0.0, MAJOR])
    scene, thing = with_ring(pieces, at)
    result, verdict, penetration = run(body, scene, along([0.0, 1.0, 0.0], 0.25))
    parts, where, frames = touched(result, "ring")
    assert parts
    assert all(part.startswith(("left_index", "left_middle", "left_ring", "left_wrist"))
               for part in parts)  # fmt: skip
    track = result.objects["ring"]
    # Finger tips reach the tube's near side, and no farther without contact.
    before = body.vertices(result.motion)[frames[0] - 1, :, 1].max()
    way = at[1] - MINOR - before
    assert 0.0 < way < 0.5 / 30.0 + 1e-3 * thing.decomposition.outside_mm + CLEARANCE
    assert (track.position[: frames[0]] == at).all()
    assert track.position[-1, 1] > at[1] + 0.05
    reach = 1e-3 * thing.decomposition.outside_mm + 2.0 * CLEARANCE
    for point, frame in zip(where, frames, strict=True):
        assert np.abs(from_ring(during(result, "ring", frame, point))).min() < reach
    assert verdict.clear, verdict
    # The pieces may miss the mesh by this much; the skin is no deeper in it.
    assert penetration[1] <= thing.decomposition.inside_mm


def test_a_foot_goes_under_a_chair_and_the_shin_meets_its_seat(body):
    boxes = chair_boxes()
    start = t_pose(np.zeros((2, 3)))
    skin = body.vertices(start)[0]
    floor = skin[:, 2].min()
    of = {side: body.joints(start)[0, JOINT_INDEX[f"{side}_ankle"]] for side in ("left", "right")}
    low = skin[skin[:, 2] < floor + 0.3]
    place = np.array([low[:, 0].max() + 0.05, 0.5 * (of["left"][1] + of["right"][1]), floor])
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, floor - CLEARANCE))
    scene.add_object("chair", joined(boxes), mass=4.0, pieces=boxes, position=place)
    chair = scene.objects["chair"]
    assert chair.decomposition.outside_mm == 0.0
    result, verdict, penetration = run(body, scene, along([1.0, 0.0, 0.0], 0.4))
    parts, where, frames = touched(result, "chair")
    assert parts <= {"left_knee", "right_knee", "left_hip", "right_hip"}
    assert parts
    track = result.objects["chair"]
    first = frames[0]
    # The toes were under the seat by then, and the chair did not move.
    toes = body.vertices(result.motion)[first - 1][skin[:, 2] < floor + 0.1, 0].max()
    assert toes > place[0] + 0.08
    assert np.abs(track.position[:first] - track.position[0]).max() < 1e-6
    # At the front of the seat, at the seat's height.
    seat = np.array([0.0, 0.0, 0.44]), np.array([np.inf, 0.25, 0.02]) + 2.0 * CLEARANCE
    for point in where[frames == first]:
        beside = np.abs(during(result, "chair", first, point) - seat[0])
        beside = beside[(beside <= seat[1]).all(axis=1), 0]
        assert beside.min() < 2.0 * CLEARANCE
    assert track.position[-1, 0] > place[0] + 0.05  # pushed along
    assert verdict.clear, verdict
    assert penetration == (0.0, 0.0)

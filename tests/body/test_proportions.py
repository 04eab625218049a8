"""Other bones for a body: joints met exactly, a skin that follows and stays a person's."""

from __future__ import annotations

import dataclasses
import json
import warnings
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

import halfphysics as hp
from halfphysics.body.body import Body
from halfphysics.body.match import check_match
from halfphysics.body.proportions import checked_bones, maps_of, proportioned
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.records import BodyRecord
from support.bones import elsewhere, own_bones, world_joints
from support.files.layouts import movement

# Rounding of double precision over chains of ten joints, a few metres from the origin.
ROUNDING = 1e-12
# The same over motions: metres, of joints that 55 rotations place.
PLACED = 1e-9
ARMS = [i for i, n in enumerate(JOINT_NAMES) if n[-5:] in ("elbow", "wrist")]
#: Of every joint the one of the other side.
OTHER = [
    JOINT_INDEX[{"l": "right", "r": "left"}[n[0]] + n[n.index("_") :] if "_" in n else n]
    for n in JOINT_NAMES
]


@pytest.fixture(scope="module")
def body() -> Body:
    return Body.default()


def solid(body: Body) -> trimesh.Trimesh:
    return trimesh.Trimesh(body.rest_vertices, body.faces, process=False)


def is_a_person(body: Body) -> None:
    """A closed skin with volume, parts that all have skin near their joint, and its mass."""
    mesh = solid(body)
    assert mesh.is_watertight
    assert mesh.volume > 0.0
    for part in body.variant.parts:
        assert len(part.vertices) >= 4
        assert part.mass > 0.0
    # Samples of the parts' masses add up to the volume inside the skin, to rounding.
    assert body.mass == pytest.approx(985.0 * mesh.volume, rel=1e-9)
    # As near its joint as before, but for the ratio of bones, and joints of elsewhere in the flesh.
    owner, plain = body.weights.argmax(axis=1), Body.default(body.betas)
    far, before = (
        np.linalg.norm(b.rest_vertices - b.rest_joints[owner], axis=1) for b in (body, plain)
    )
    assert (far < 1.4 * before + 0.15).all()


@pytest.mark.parametrize("make", [elsewhere, lambda: own_bones(Body.default([1.5, -1.0]))])
def test_given_bones_are_met_in_every_frame(make: Any) -> None:
    bones = make()
    person = Body.default(bones=bones)
    known = np.isfinite(bones[:, 0])
    assert np.abs(own_bones(person) - bones)[known].max() < ROUNDING
    motion = hp.Motion(*movement(8), 30.0)
    wanted = world_joints(bones, motion)
    assert np.nanmax(np.abs(person.joints(motion) - wanted)) < PLACED
    assert np.isfinite(wanted[:, known]).all()
    is_a_person(person)


@pytest.mark.parametrize("betas", [None, [2.0, -1.0, 1.0]])
def test_own_bones_change_nothing(betas: Any) -> None:
    plain = Body.default(betas)
    for bones in (own_bones(plain), np.full((55, 3), np.nan)):
        same = Body.default(betas, bones=bones)
        assert np.abs(same.rest_joints - plain.rest_joints).max() < ROUNDING
        assert np.abs(same.rest_vertices - plain.rest_vertices).max() < ROUNDING
        assert np.array_equal(same.betas, plain.betas)


@pytest.mark.parametrize("factor", [0.7, 1.15])
def test_even_bones_are_a_stature(body: Body, factor: float) -> None:
    even = Body.default(bones=factor * own_bones(body))
    scaled = Body.default(stature=factor * body.stature)
    assert np.abs(even.rest_vertices - scaled.rest_vertices).max() < ROUNDING
    assert np.abs(even.rest_joints - scaled.rest_joints).max() < ROUNDING
    assert even.mass == pytest.approx(factor**3 * body.mass, rel=1e-9)


@pytest.mark.parametrize("stature", [1.55, 1.72, 1.95])
@pytest.mark.parametrize("arms", [0.9, 1.0, 1.1])
def test_statures_with_arms_of_their_own(body: Body, stature: float, arms: float) -> None:
    bones = own_bones(body) * stature / body.stature
    bones[ARMS] *= arms
    person = Body.default(bones=bones)
    # Arms say a little about the girth of all: soles and crown move by millimetres.
    assert person.stature == pytest.approx(stature, abs=0.01)
    reach = np.ptp(person.rest_joints[ARMS, 0])
    assert reach == pytest.approx(
        np.ptp(body.rest_joints[ARMS, 0]) * stature / body.stature
        + 2.0
        * (arms - 1.0)
        * np.linalg.norm(own_bones(body)[ARMS[::2]], axis=1).sum()
        * stature
        / body.stature,
        abs=PLACED,  # arms are level to 1e-11 m
    )
    is_a_person(person)


bone_ratios = st.lists(st.floats(0.8, 1.25), min_size=55, max_size=55)


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(ratios=bone_ratios, hidden=st.sets(st.integers(0, 54), max_size=30))
def test_any_ratios_give_a_person(ratios: list[float], hidden: set[int]) -> None:
    body = Body.default()
    bones = own_bones(body) * np.array(ratios)[:, None]
    bones[0] = body.rest_joints[0]
    bones[list(hidden)] = np.nan
    person = Body.default(bones=bones)
    known = np.isfinite(bones[:, 0])
    assert np.abs(own_bones(person) - bones)[known].max() < ROUNDING
    is_a_person(person)


def test_both_sides_alike_stay_alike(body: Body) -> None:
    """A skin of mirror-symmetric bones is as symmetric as the body's own."""
    from scipy.spatial import cKDTree

    turn = np.array([-1.0, 1.0, 1.0])
    off, pair = cKDTree(body.rest_vertices).query(body.rest_vertices * turn)
    person = Body.default(bones=elsewhere())
    found = np.abs(person.rest_vertices[pair] - person.rest_vertices * turn).max()
    assert found < 3.0 * off.max() + 1e-9
    joints = person.rest_joints
    assert np.abs(joints[OTHER] - joints * turn).max() < 1e-9


def test_a_part_alone_changes_what_is_beyond(body: Body) -> None:
    bones = own_bones(body)
    bones[JOINT_INDEX["left_wrist"]] *= 1.2
    person = Body.default(bones=bones)
    share = body.weights[:, JOINT_INDEX["left_elbow"]]
    longer = np.ptp(person.rest_vertices[share > 1.0 - ROUNDING], axis=0)
    before = np.ptp(body.rest_vertices[share > 1.0 - ROUNDING], axis=0)
    size = maps_of(body.rest_joints, bones).girths[JOINT_INDEX["left_knee"]] ** 2
    assert longer[0] == pytest.approx(1.2 * before[0], rel=1e-6)  # not quite level
    assert longer[1] == pytest.approx(np.sqrt(1.2 * size) * before[1], rel=1e-6)
    assert 1.0 < size < 1.02
    assert person.variant.parts[18].mass > body.variant.parts[18].mass


def test_soles_stay_flat_wherever_the_toes_are(body: Body) -> None:
    """The toe joint may be higher, lower or aside: heel and toes are on one height."""
    for change in ((0.02, 0.02, 0.01), (-0.02, -0.02, 0.0), (0.05, -0.01, -0.02)):
        bones = own_bones(body)
        toe = JOINT_INDEX["left_foot"]
        bones[toe] += change
        person = Body.default(bones=bones)
        lows = [
            plain[body.weights.argmax(axis=1) == k, 1].min()
            for plain in (body.rest_vertices, person.rest_vertices)
            for k in (toe, JOINT_INDEX["left_ankle"])
        ]
        scale = (lows[2] - person.rest_joints[7, 1]) / (lows[0] - body.rest_joints[7, 1])
        # Soles carry a trace of the shank's weights.
        assert lows[2] - lows[3] == pytest.approx(scale * (lows[0] - lows[1]), abs=1e-3)


def test_the_trunk_keeps_its_form_where_joints_are_elsewhere(body: Body) -> None:
    """Of the skin of the trunk alone distances scale evenly, whatever spine and hips do."""
    maps = maps_of(body.rest_joints, elsewhere())
    person = Body.default(bones=elsewhere())
    trunk = [JOINT_INDEX[n] for n in ("pelvis", "spine1", "spine2", "spine3")]
    inner = np.flatnonzero(body.weights[:, trunk].sum(axis=1) > 1.0 - ROUNDING)[::3]
    before, after = (
        np.linalg.norm(b.rest_vertices[inner][:, None] - b.rest_vertices[inner], axis=-1)
        for b in (body, person)
    )
    assert len(inner) > 50
    assert np.abs(after - maps.girths[0] * before).max() < ROUNDING


def test_unknown_fingers_follow_the_hand(body: Body) -> None:
    bones = elsewhere()
    maps, own = maps_of(body.rest_joints, bones), own_bones(body)
    wrist = JOINT_INDEX["left_wrist"]
    for name in ("left_index1", "left_thumb1", "left_pinky1"):
        found = maps.joints[JOINT_INDEX[name]] - maps.joints[wrist]
        assert np.abs(found - maps.linear[wrist] @ own[JOINT_INDEX[name]]).max() < ROUNDING
    assert 0.8 < maps.girths[JOINT_INDEX["left_index3"]] < 1.2


def test_pose_blend_shapes_scale_with_their_skin(body: Body) -> None:
    rng = np.random.default_rng(0)
    shapes = rng.normal(size=(len(body.rest_vertices), 3, 486)) * 1e-3
    corrected = dataclasses.replace(body, posedirs=shapes)
    bones = elsewhere()
    maps = maps_of(body.rest_joints, bones)
    found = corrected._of_bones(bones).posedirs
    assert found is not None
    wanted = shapes * (body.weights @ maps.girths)[:, None, None]
    assert np.abs(found - wanted).max() < ROUNDING


def test_betas_come_first_and_mass_last() -> None:
    bones = elsewhere()
    plain, heavy = Body.default(bones=bones), Body.default([2.0], bones=bones, mass=90.0)
    assert heavy.mass == pytest.approx(90.0, rel=1e-12)
    assert np.abs(heavy.rest_joints[:22] - plain.rest_joints[:22]).max() < ROUNDING
    assert np.abs(heavy.rest_vertices - plain.rest_vertices).max() > 1e-3


def test_what_is_kept_of_a_body_is_by_its_bones(tmp_path: Any, monkeypatch: Any) -> None:
    from halfphysics.body import body_cache

    monkeypatch.setenv("HALFPHYSICS_CACHE", str(tmp_path))
    one, two = (Body.default(bones=elsewhere(f)) for f in (1.0, 1.01))
    assert body_cache._parts_key(one) != body_cache._parts_key(two)
    again = Body.default(bones=elsewhere())
    assert body_cache._parts_key(one) == body_cache._parts_key(again)
    assert one.mass != two.mass


def changed(joint: str, row: Any) -> np.ndarray:
    bones = elsewhere()
    bones[JOINT_INDEX[joint]] = row
    return bones


WRONG: dict[str, tuple[Any, str]] = {
    "shape": (np.zeros((24, 3)), r"bones: found shape \(24, 3\), expected \(55, 3\)"),
    "text": ("tall", "bones: .*expected"),
    "ragged": ([[1.0], [2.0, 3.0]], "bones: not numbers"),
    "infinite": (changed("neck", np.inf), "bones: neck: found .*three finite"),
    "half a row": (changed("head", [0.0, np.nan, 0.1]), "bones: head: found .*three NaN"),
    "half a pelvis": (changed("pelvis", [0.0, np.nan, 0.1]), "bones: pelvis: found"),
    "no length": (changed("left_knee", 0.0), "left_hip to left_knee: found 0 m, expected 0.099"),
    "millimetres": (changed("left_wrist", [250.0, 0, 0]), "left_elbow to left_wrist: .*metres?"),
    "ones": (np.ones((55, 3)), "bones: pelvis to .*found 1.73 m"),
    "z up": (elsewhere()[:, [2, 0, 1]], "bones: found a trunk turned by .* y up, z forward"),
    "sides swapped": (elsewhere() * [-1, 1, 1], "bones: found a trunk turned by 1.. degrees"),
    "a giant": (elsewhere(2.2), "bones: found those of a person of 3.* m, expected 0.4 to 2.8"),
}


@pytest.mark.parametrize("name", WRONG)
def test_impossible_bones(name: str) -> None:
    bones, message = WRONG[name]
    with pytest.raises(InputError, match=message):
        Body.default(bones=bones)


def test_bones_or_a_stature() -> None:
    with pytest.raises(InputError, match=r"bones and stature.*Leave out stature"):
        Body.default(stature=1.8, bones=elsewhere())


def test_a_person_of_given_bones_goes_with_a_motion_of_any_shape() -> None:
    motion = hp.Motion(np.zeros((2, 3)), np.zeros((2, 55, 3)), 30.0, betas=[1.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_match(motion, Body.default(bones=elsewhere()))


def test_what_a_result_file_has_of_a_body_makes_it_again() -> None:
    for bones in (elsewhere(), own_bones(Body.default([1.0]))):
        person = Body.default([0.5], bones=bones, mass=70.0)
        record = BodyRecord(json.loads(json.dumps(BodyRecord.of(person).data)), "a file")
        again = record.make()
        assert np.array_equal(again.rest_vertices, person.rest_vertices)
        assert np.array_equal(again.rest_joints, person.rest_joints)
        assert again.mass == person.mass


def test_the_pieces_are_what_the_whole_is(body: Body) -> None:
    """Without weights that blend, a part is carried by its own map."""
    bones = checked_bones(elsewhere(), body.rest_joints)
    rigid = np.eye(55)[body.weights.argmax(axis=1)]
    moved, maps = proportioned(body.rest_vertices, body.rest_joints, rigid, bones)
    for k in range(55):
        mine = rigid[:, k] > 0.0
        arm = (moved[mine] - maps.anchors[k]) @ np.linalg.inv(maps.linear[k]).T
        assert np.abs(arm + body.rest_joints[k] - body.rest_vertices[mine]).max() < ROUNDING


def test_such_a_body_stands_and_squats_on_a_floor() -> None:
    """A simulation runs through, and nothing of the person ends in the floor."""
    person = Body.default(bones=elsewhere())
    frames = 20
    rotations = np.zeros((frames, 55, 3))
    bend = 0.6 * np.sin(np.linspace(0.0, np.pi, frames))
    for hip, knee, ankle in ((1, 4, 7), (2, 5, 8)):
        rotations[:, hip, 0], rotations[:, knee, 0] = -bend, 2.0 * bend
        rotations[:, ankle, 0] = -bend
    upright = np.tile([np.pi / 2, 0.0, 0.0], (frames, 1))
    rotations[:, 0] = upright
    motion = hp.Motion(np.zeros((frames, 3)), rotations, 30.0).grounded(person)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    result = hp.simulate(motion, scene, body=person)
    assert len(result.motion) == frames
    assert len(result.breaches.frame) == 0
    low = person.vertices(result.motion)[..., 2].min()
    assert low > -1e-3

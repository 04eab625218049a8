"""Support of people who hold still, fall and jump: statics and MuJoCo's inverse dynamics."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.support import estimate
from halfphysics.support.support import Pressure
from support import standing
from support.people import FACING_X, t_pose

G = 9.81


@pytest.fixture(scope="module")
def body():
    return hp.Body.default(stature=1.75, mass=70.0)


def room(**boxes):
    """A floor and boxes, given by size and position."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    for name, (size, position) in boxes.items():
        scene.add_static(name, hp.Box(size), position=position)
    return scene


def cases(body):
    """Name -> a still motion and its scene."""
    seated, seat = standing.sitting(body)
    leaning, wall = standing.leaning(body)
    pelvis = body.joints(seated[0])[0]
    return {
        "standing": (standing.standing(body), room()),
        "squat": (standing.squat(body), room()),
        "one_leg": (standing.one_leg(body), room()),
        "sitting": (
            seated,
            room(box=((0.5, 0.6, seat), (pelvis[0], pelvis[1], 0.5 * seat))),
        ),
        "lying": (standing.lying(body), room()),
        "leaning": (leaning, room(wall=((0.2, 2.0, 3.0), (wall + 0.1, 0.0, 1.5)))),
    }


@pytest.fixture(scope="module")
def found(body):
    """Name -> motion and its support."""
    return {
        name: (motion, estimate(motion, scene, body=body))
        for name, (motion, scene) in cases(body).items()
    }


NAMES = ("standing", "squat", "one_leg", "sitting", "lying", "leaning")


@pytest.mark.parametrize("name", NAMES)
def test_forces_and_moments_balance(found, body, name):
    """Forces sum to the weight and moments about any point to 0, within 1 %."""
    motion, support = found[name]
    weight = 70.0 * G
    assert support.weight == pytest.approx(weight)
    gravity = np.array([0.0, 0.0, -weight])
    com = standing.centre_of_mass(body, motion)
    rows = support.pressure
    for t in (0, len(motion) // 2, len(motion) - 1):
        own = rows[rows.frame == t]
        assert np.linalg.norm(own.force.sum(axis=0) + gravity) < 0.01 * weight
        for point in (np.zeros(3), com, np.array([1.0, -2.0, 3.0])):
            moment = np.cross(own.position - point, own.force).sum(axis=0)
            moment += np.cross(com - point, gravity)
            assert np.linalg.norm(moment) < 0.01 * weight * 0.5, point
        assert support.total[t] == pytest.approx(own.force.sum(axis=0), abs=1e-3 * weight)
    assert np.abs(support.residual[:, :3]).max() < 0.01 * weight
    assert np.abs(support.weight_percent - 100.0).max() < 1.0
    assert not support.unsupported.any()
    assert not support.airborne.any()


@pytest.mark.parametrize("name", NAMES)
def test_forces_are_in_their_cones(found, name):
    rows = found[name][1].pressure
    along = np.einsum("ni,ni->n", rows.force, rows.normal)
    across = np.linalg.norm(rows.force - along[:, None] * rows.normal, axis=1)
    assert (along > 0.0).all()
    assert (across <= along * (1.0 + 1e-9) + 1e-9).all()


@pytest.mark.parametrize("name", NAMES)
def test_torques_are_those_of_inverse_dynamics(found, body, name):
    """MuJoCo's inverse dynamics with the forces applied: the same torques to 1 %."""
    motion, support = found[name]
    expected = inverse(body, motion, support)
    largest = np.abs(expected[1:]).max()
    assert np.abs(support.torque[5, 1:] - expected[1:]).max() < 0.01 * largest
    assert support.torque[5, 1:] == pytest.approx(expected[1:], abs=0.01 * largest)


def inverse(body, motion, support, frame=5):
    """Torques (55, 3) of `mj_inverse`, the forces of a frame applied to the parts."""
    from halfphysics.body.mjcf_person import to_mjcf

    model = mujoco.MjModel.from_xml_string(to_mjcf(body.variant))
    data = mujoco.MjData(model)
    model.opt.gravity[:] = (0.0, 0.0, -G)
    model.dof_armature[:] = 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) for name in JOINT_NAMES]
    x, q = body.joint_frames(motion[frame])
    data.qpos[:3], data.qpos[3:7] = x[0], q[0]
    for k in range(1, 55):
        at = model.jnt_qposadr[model.body_jntadr[ids[k]]]
        data.qpos[at : at + 4] = rot.exp(motion.rotations[frame, k])
    mujoco.mj_inverse(model, data)
    assert data.xpos[ids] == pytest.approx(x, abs=1e-6)
    force = np.zeros(model.nv)
    rows = support.pressure[support.pressure.frame == frame]
    for part, point, push in zip(rows.part, rows.position, rows.force, strict=True):
        mujoco.mj_applyFT(model, data, push, np.zeros(3), point, ids[part], force)
    torque = data.qfrc_inverse - force
    found = np.zeros((55, 3))
    for k in range(1, 55):
        at = model.jnt_dofadr[model.body_jntadr[ids[k]]]
        found[k] = torque[at : at + 3]
    return found


def test_a_squat_takes_the_knees_and_hips(found):
    torque = np.linalg.norm(found["squat"][1].torque[5], axis=-1)
    both = torque[[JOINT_INDEX[f"{s}_{j}"] for s in ("left", "right") for j in ("knee", "hip")]]
    assert both.min() > 20.0
    assert both.max() < 150.0
    upright = np.linalg.norm(found["standing"][1].torque[5], axis=-1)
    assert upright[JOINT_INDEX["left_knee"]] < 0.4 * both.max()


def test_surfaces_and_parts(found):
    _, support = found["sitting"]
    force, cop = support.surface("box")
    feet, _ = support.on("left_ankle", "left_foot", "right_ankle", "right_foot")
    assert 0.5 < force[5, 2] / support.weight < 1.0
    assert (force + feet)[5, 2] == pytest.approx(support.weight, rel=0.01)
    assert cop[5, 2] == pytest.approx(0.45, abs=0.15)
    with pytest.raises(hp.errors.InputError, match="no surface 'bax'; did you mean 'box'"):
        support.surface("bax")
    with pytest.raises(hp.errors.InputError, match="no part 'left_toe'"):
        support.on("left_toe")
    assert abs(force[5, 0]) < 0.1 * support.weight  # the feet do not press against the seat
    assert found["leaning"][1].surface("wall")[0][5, 0] < -20.0


def test_a_force_that_acts_nowhere_moves_no_centre_of_pressure(found):
    """What the filter leaves beside an impulse: it was taken to act at the world's origin."""
    support = found["standing"][1]
    shape = (len(support), 1, 3)
    trace = dataclasses.replace(
        support,
        names=(*support.names, "ball"),
        force=np.concatenate([support.force, np.full(shape, 5.0)], axis=1),
        cop=np.concatenate([support.cop, np.full(shape, np.nan)], axis=1),
    )
    np.testing.assert_array_equal(trace.total_cop, support.total_cop)
    alone = dataclasses.replace(trace, pressure=Pressure.none())
    alone = dataclasses.replace(alone, cop=np.full_like(trace.cop, np.nan))
    assert np.isnan(alone.total_cop).all()


@pytest.mark.parametrize("height", [-0.03, 0.01, 0.03])
def test_a_motion_that_floats_or_sinks_is_carried(body, height):
    motion = standing.standing(body)
    moved = standing.raised(motion, height)
    support = estimate(moved, room(), body=body)
    assert np.abs(support.weight_percent - 100.0).max() < 1.0
    assert np.nanmax(np.abs(support.cop[..., 2])) < 1e-9


def test_nothing_carries_who_floats(body):
    motion = standing.standing(body)
    moved = standing.raised(motion, 0.1)
    support = estimate(moved, room(), body=body)
    assert support.unsupported.all()
    assert support.unsupported_percent == 100.0
    assert support.residual_percent == pytest.approx(100.0)
    assert not support.force.any()


def test_without_surfaces_all_is_residual(body):
    support = estimate(standing.standing(body), hp.Scene(), body=body)
    assert support.names == ()
    assert support.force.shape == (20, 0, 3)
    assert np.isnan(support.total_cop).all()
    assert support.residual == pytest.approx(support.required)


def falling(frames=60, fps=60.0, up=3.0, height=1.5, spin=0.0):
    t = np.arange(frames) / fps
    path = np.zeros((frames, 3))
    path[:, 0], path[:, 2] = 0.5 * t, height + up * t - 0.5 * G * t**2
    motion = t_pose(path, fps)
    if not spin:
        return motion
    turns = motion.rotations.copy()
    turns[:, 0] = rot.log(rot.multiply(rot.exp(np.outer(t, [0.0, 0.0, spin])), rot.exp(FACING_X)))
    return hp.Motion(path, turns, fps)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_free_fall_needs_no_support(body, fps):
    support = estimate(falling(fps=fps, frames=int(fps)), hp.Scene(), body=body)
    assert np.abs(support.residual).max() < 1e-6 * support.weight
    assert np.abs(support.torque).max() < 1e-6 * support.weight
    assert support.airborne.all()
    assert not support.unsupported.any()


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_jump_is_airborne_between_standing(body, fps):
    """Who hops with stiff legs needs nothing in the air, and stands before and after it."""
    stand = standing.standing(body, frames=int(2.0 * fps), fps=fps)
    t = np.arange(len(stand)) / fps
    inside = np.clip(t - 0.8, 0.0, 0.4)
    path = stand.translation.copy()
    path[:, 2] += 0.5 * G * inside * (0.4 - inside)
    support = estimate(hp.Motion(path, stand.rotations, fps), room(), body=body)
    air = (t > 0.9) & (t < 1.1)
    assert support.airborne[air].all()
    assert not support.airborne[(t < 0.75) | (t > 1.25)].any()
    assert np.abs(support.residual[support.airborne][1:-1]).max() < 0.02 * support.weight
    assert not support.unsupported[support.airborne].any()
    rest = (t < 0.3) | (t > 1.7)
    assert np.abs(support.weight_percent[rest] - 100.0).max() < 5.0


def test_without_gravity_nothing_is_needed(body):
    support = estimate(t_pose(np.zeros((10, 3))), hp.Scene(gravity=0.0), body=body)
    assert not support.residual.any()
    assert np.isnan(support.weight_percent).all()
    assert not support.unsupported.any()


@pytest.mark.parametrize("frames", [2, 3, 4])
def test_short_clips_count_as_slow(body, frames):
    support = estimate(standing.standing(body, frames=frames), room(), body=body)
    assert len(support) == frames
    assert np.abs(support.weight_percent - 100.0).max() < 1.0


def test_arrays_are_read_only_and_the_same_each_time(body):
    motion = standing.squat(body)
    one, two = (estimate(motion, room(), body=body) for _ in range(2))
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(two, field.name)
        if isinstance(a, np.ndarray):
            assert np.array_equal(a, b, equal_nan=True)
            assert not a.flags.writeable
    assert np.array_equal(one.pressure.force, two.pressure.force)


@pytest.mark.parametrize("cutoff", [0.0, -6.0, np.nan, "fast"])
def test_impossible_cutoffs(body, cutoff):
    with pytest.raises(hp.errors.InputError, match="cutoff"):
        estimate(standing.standing(body), room(), body=body, cutoff=cutoff)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            {"motion": "walk.npz"},
            r"^motion: found 'walk\.npz', .*Motion\.load\('walk\.npz'\)",
        ),
        ({"scene": None}, r"scene: found None, expected a halfphysics\.Scene"),
        ({"body": 3}, r"body: found 3, expected a halfphysics\.Body"),
    ],
)
def test_what_is_estimated_is_checked(body, wrong, message):
    good = {"motion": standing.standing(body), "scene": room(), "body": body}
    with pytest.raises(hp.errors.InputError, match=message):
        estimate(**(good | wrong))

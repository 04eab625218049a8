"""Tensors of torch and arrays of jax are taken wherever arrays and numbers are."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.arrays import array_of, as_array, scalar_of
from halfphysics.labels.exporters import _hand
from halfphysics.metrics.contact_scores import hand_contact
from halfphysics.results.result import ObjectTrack
from support.tensors import JaxArray, OnlyDlpack, Tensor

T = 6


@pytest.mark.parametrize("kind", [Tensor, JaxArray, OnlyDlpack])
def test_numbers_and_type_are_those_of_the_tensor(kind):
    values = np.arange(6, dtype=np.float32).reshape(2, 3)
    found = as_array(kind(values))
    assert isinstance(found, np.ndarray)
    assert found.dtype == np.float32
    assert np.array_equal(found, values)


def test_what_numpy_has_is_not_touched():
    for value in (np.ones(3), [1.0, 2.0], (1, 2), 3.0, None, "text", {"a": 1}, Tensor):
        assert array_of(value) is value


def test_lists_may_hold_tensors():
    rows = [[Tensor(1.0), 2.0], (JaxArray(3.0), Tensor(4.0, requires_grad=False))]
    assert np.array_equal(as_array(rows), [[1.0, 2.0], [3.0, 4.0]])
    assert np.array_equal(as_array([Tensor([1, 2]), Tensor([3, 4])]), [[1, 2], [3, 4]])


def test_a_list_in_itself_ends():
    endless = []
    endless.append(endless)
    assert array_of(endless) is endless


def test_numbers_without_a_dimension():
    for value in (Tensor(0.5), JaxArray(0.5), np.array(0.5)):
        found = scalar_of(value)
        assert isinstance(found, float)
        assert found == 0.5
    assert scalar_of(Tensor(True)) is True
    whole = Tensor([1.0])
    assert scalar_of(whole) is whole


def test_half_precision_of_torch():
    assert np.array_equal(as_array(Tensor([0.5, 2.0], dtype="bfloat16")), [0.5, 2.0])


def test_half_precision_of_jax():
    other = pytest.importorskip("ml_dtypes", reason="numbers of jax")
    found = as_array(JaxArray(np.array([0.5, 2.0], dtype=other.bfloat16)))
    assert found.dtype == np.float32
    assert np.array_equal(found, [0.5, 2.0])


def test_a_tensor_without_numbers_is_refused_in_words():
    nothing = Tensor([1.0, 2.0, 3.0], device="meta")
    with pytest.raises(TypeError, match="no data"):
        as_array(nothing)
    with pytest.raises(hp.errors.InputError, match=r"position: expected 3 finite numbers"):
        hp.Scene().add_static("wall", hp.Box((1, 1, 1)), position=nothing)
    with pytest.raises(hp.errors.InputError, match=r"translation: not an array of numbers .*no da"):
        hp.Pose(nothing, np.zeros((55, 3)))


# -- every place where arrays enter ------------------------------------------------------------

rng = np.random.default_rng(0)
TRANSLATION = 0.01 * rng.normal(size=(T, 3)) + [0.0, 0.0, 0.9]
ROTATIONS = 0.05 * rng.normal(size=(T, 55, 3)) + np.eye(55, 1)[:, :1] * [np.pi / 2, 0.0, 0.0]
JOINTS = 0.02 * rng.normal(size=(T, 55, 3))
OTHER = JOINTS + 0.01 * rng.normal(size=JOINTS.shape)
FLAGS = rng.random((T, 4)) < 0.5
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float64)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
TURN = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
m = hp.metrics


def motion(t=np.asarray, **more):
    return hp.Motion(t(TRANSLATION), t(ROTATIONS), t(30.0), **more)


def loose(t):
    """What has the fields of a motion, as tensors."""
    made = motion()

    class Loose:
        translation, rotations, axes, fps = t(made.translation), t(made.rotations), t(np.eye(3)), 30

        def __len__(self):
            return T

    return Loose()


def ball(**options):
    scene = hp.Scene()
    return scene.add_object("ball", hp.Sphere(0.1), mass=1.0, **options)


def live(act):
    """Object velocities of a simulator after something was done to it."""
    scene = hp.Scene(gravity=0.0)
    scene.add_object("ball", hp.Sphere(0.1), mass=2.0, position=(3.0, 0.0, 1.0))
    simulator = hp.Simulator(scene, fps=30)
    simulator.reset(motion()[0])
    act(simulator)
    simulator.step(motion()[1])
    return np.concatenate([*simulator.velocity("ball"), simulator.world.stepper.qvel()])


ENTRIES = {
    "Motion": lambda t: motion(t).rotations,
    "Motion betas": lambda t: motion(betas=t(np.arange(3.0))).betas,
    "Motion axes": lambda t: motion(axes=t(np.eye(3))).axes,
    "Motion (T, 165)": lambda t: hp.Motion(t(TRANSLATION), t(ROTATIONS.reshape(T, -1)), 30).poses,
    "Motion stiffness_scale": lambda t: motion(stiffness_scale=t(JOINTS[..., 0] ** 2)),
    "Motion.with_frames": lambda t: motion().with_frames(t(TRANSLATION + 1), t(ROTATIONS)),
    "Motion.resample": lambda t: motion().resample(t(60.0)).translation,
    "Motion.grounded": lambda t: motion().grounded(hp.Body.default(), t(0.25)).translation,
    "from_smplx": lambda t: hp.Motion.from_smplx(
        fps=t(30.0),
        global_orient=t(ROTATIONS[:, 0]),
        transl=t(TRANSLATION),
        body_pose=t(ROTATIONS[:, 1:22].reshape(T, 63)),
        left_hand_pose=t(ROTATIONS[:, 25:40].reshape(T, 45)),
        betas=t(np.ones((T, 4))),
        hands_mean=t(np.full(90, 0.1)),
        expression=t(np.zeros((T, 10))),
    ),
    "Pose": lambda t: hp.Pose(t(TRANSLATION[0]), t(ROTATIONS[0].reshape(-1))),
    "Body betas": lambda t: hp.Body.default(betas=t(np.array([1.0, -0.5]))).rest_vertices,
    "Body stature, mass": lambda t: hp.Body.default(stature=t(1.8), mass=t(70.0)).mass,
    "Body bones": lambda t: (
        (
            hp.Body.default(
                bones=t(np.where(np.arange(55)[:, None] == 4, [0.0, -0.4, 0.0], np.nan))
            )
        ).rest_joints
    ),
    "Body.joints": lambda t: hp.Body.default().joints(loose(t)),
    "Body.vertices": lambda t: hp.Body.default().vertices(
        loose(t), frames=t(np.array([1, 3])), indices=t(np.array([5, 7, 9]))
    ),
    "Box": lambda t: hp.Box(t(np.array([1.0, 2.0, 3.0]))).size,
    "Box of numbers": lambda t: hp.Box((t(1.0), t(2.0), 3.0)).size,
    "Plane": lambda t: hp.Plane(t(np.array([0.0, 1.0, 1.0])), t(0.5)),
    "Sphere": lambda t: hp.Sphere(t(0.5)).radius,
    "Capsule": lambda t: hp.Capsule(t(0.5), t(1.0)).length,
    "Cylinder": lambda t: hp.Cylinder(t(0.5), t(1.0)).length,
    "Mesh": lambda t: hp.Mesh(t(CORNERS), t(FACES)).vertices,
    "Shape.depth": lambda t: [
        shape.depth(t(0.1 * JOINTS[0]))
        for shape in (
            hp.Plane(),
            hp.Box((1, 1, 1)),
            hp.Sphere(1),
            hp.Cylinder(1, 1),
            hp.Mesh(CORNERS, FACES),
        )
    ],
    "pieces": lambda t: (
        hp.Scene()
        .add_object(
            "a",
            hp.Mesh(CORNERS, FACES),
            mass=1,
            pieces=[type("", (), {"vertices": t(CORNERS), "faces": t(FACES)})()],
        )
        .com
    ),
    "mesh of another library": lambda t: (
        hp.Scene()
        .add_static("a", type("", (), {"vertices": t(CORNERS), "faces": t(FACES)})())
        .mesh()[0]
    ),
    "gravity": lambda t: hp.Scene(t(np.array([0.0, 0.0, -1.6]))).gravity,
    "gravity down": lambda t: hp.Scene(t(1.6)).gravity,
    "add_static": lambda t: (
        hp.Scene()
        .add_static("a", hp.Box((1, 1, 1)), position=t(CORNERS[1]), quaternion=t(TURN))
        .quaternion
    ),
    "add_object": lambda t: vars(
        ball(
            position=t(CORNERS[1]),
            quaternion=t(TURN),
            velocity=t(CORNERS[2]),
            angular_velocity=t(CORNERS[3]),
            com=t(0.01 * CORNERS[1]),
            friction=t(0.5),
            restitution=t(0.25),
        )
    ),
    "add_moving": lambda t: (
        hp.Scene()
        .add_moving("a", hp.Sphere(1), t(CORNERS), t(np.tile(TURN, (4, 1))), fps=t(30.0))
        .positions
    ),
    "KinematicObject.at": lambda t: (
        hp.Scene().add_moving("a", hp.Sphere(1), CORNERS, fps=30).at(t(np.array([0.01, 0.05])))
    ),
    "friction": lambda t: _friction(t(0.3)),
    "Scene.ray": lambda t: _hit(t(np.array([0.0, 0.0, 5.0])), t(np.array([0.0, 0.0, -1.0]))),
    "Settings": lambda t: hp.Settings(
        stiffness=t(0.5), recovery_rate=t(4.0), substeps=t(np.int64(4)), self_contact=t(np.True_)
    ),
    "Settings by joint": lambda t: dict(hp.Settings(stiffness={"arms": t(0.5)}).stiffness),
    "baselines.Torque": lambda t: hp.baselines.Torque(frequency=t(50.0)),
    "simulate stiffness": lambda t: _simulated(t(0.5)),
    "simulate stiffness over time": lambda t: _simulated(t(np.linspace(0.5, 1.0, T))),
    "simulate stiffness by joint": lambda t: _simulated([t(np.full((T, 55), 0.5))]),
    "Simulator.set_stiffness": lambda t: live(lambda s: s.set_stiffness(t(np.full(55, 0.5)))),
    "Simulator.set_velocity": lambda t: live(
        lambda s: s.set_velocity("ball", t(CORNERS[1]), t(CORNERS[2]))
    ),
    "Simulator.apply_impulse": lambda t: live(
        lambda s: s.apply_impulse("ball", t(CORNERS[1]), t(CORNERS[2]), t(CORNERS[3]))
    ),
    "Simulator.step": lambda t: live(
        lambda s: s.step(hp.Pose(t(TRANSLATION[1]), t(ROTATIONS[1])), dt=t(0.02))
    ),
    "ObjectTrack": lambda t: ObjectTrack(position=t(CORNERS), quaternion=t(np.tile(TURN, (4, 1)))),
    "wa_mpjpe": lambda t: m.wa_mpjpe(t(JOINTS), t(OTHER)),
    "w_mpjpe": lambda t: m.w_mpjpe(t(JOINTS), t(OTHER)),
    "rte": lambda t: m.rte(t(JOINTS[:, 0]), t(OTHER[:, 0])),
    "world_foot_sliding": lambda t: m.world_foot_sliding(t(JOINTS[:, :4]), t(0.1 * JOINTS[:, :4])),
    "phc_success": lambda t: m.phc_success(t(JOINTS), t(OTHER)),
    "jitter": lambda t: m.jitter(t(JOINTS), 30.0),
    "acceleration_error": lambda t: m.acceleration_error(t(JOINTS), t(OTHER), 30.0),
    "gmd_skating_ratio": lambda t: m.gmd_skating_ratio(t(JOINTS), 30.0),
    "foot_sliding_mm": lambda t: m.foot_sliding_mm(t(JOINTS)),
    "foot_skate_from_height": lambda t: m.foot_skate_from_height(t(JOINTS), 30.0),
    "foot_skate_ratio": lambda t: m.foot_skate_ratio(t(JOINTS), 30.0),
    "foot_skate_from_contacts": lambda t: m.foot_skate_from_contacts(t(JOINTS), 30.0, t(FLAGS)),
    "foot_contact_consistency": lambda t: m.foot_contact_consistency(t(JOINTS), 30.0, t(FLAGS)),
    "scene_contact": lambda t: m.scene_contact(t(JOINTS[..., 0])),
    "contact_scores": lambda t: m.contact_scores(t(FLAGS[:, 0]), t(FLAGS[:, 1])),
    "hand_contact": lambda t: hand_contact(t(JOINTS[:, :2, 0])),
    "mpjpe": lambda t: m.mpjpe(loose(t), motion(), hp.Body.default()),
    "success": lambda t: m.success(loose(t), motion()),
    "labels' hands": lambda t: _hand({"left": t(np.array([3, 4]))}, "left", 9),
}


def _friction(mu):
    scene = hp.Scene()
    scene.add_static("a", hp.Plane())
    scene.friction("a", "person", mu)
    return scene.friction_of("a", "person")


def _hit(origin, direction):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    return scene.ray(origin, direction).distance


def _simulated(stiffness):
    scene = hp.Scene()
    front = hp.Body.default().joints(motion()[0])[0] + [0.0, -0.5, 0.1]
    scene.add_object("ball", hp.Sphere(0.1), mass=3.0, position=front, velocity=(0.0, 4.0, 0.0))
    result = hp.simulate(motion(), scene, stiffness=stiffness)
    assert (result.contacts.person == 0).any()  # without contact stiffness changes nothing
    return result.motion.rotations


def numbers(value):
    """All numbers in a result, in one list."""
    if isinstance(value, np.ndarray):
        return value.ravel().tolist()
    if isinstance(value, bool | int | float | np.generic):
        return [value]
    if isinstance(value, dict):
        return [n for one in value.values() for n in numbers(one)]
    if isinstance(value, list | tuple):
        return [n for one in value for n in numbers(one)]
    return numbers(vars(value)) if hasattr(value, "__dict__") else []


@pytest.mark.parametrize("kind", [Tensor, JaxArray])
@pytest.mark.parametrize("name", ENTRIES)
def test_every_entry_takes_tensors(name, kind):
    """The result is the same to the last bit as that of numpy's arrays."""
    entry = ENTRIES[name]
    plain = numbers(entry(lambda value: value))
    assert plain
    assert numbers(entry(kind)) == plain

"""Many worlds side by side in the core: motors, and what is looked at."""

import mujoco
import numpy as np
import pytest

from halfphysics import _native
from halfphysics.simulation.compiled_model import joint_arrays, model_arrays

#: Rounding of positions of about a metre.
EXACT = 1e-12
#: Substeps of a motor's step response, against its closed form: first order in h = 1/4800 s.
CLOSED = 2e-3

ARM = """
<mujoco><worldbody>
<body name="arm" pos="0 0 1"><joint name="turn" axis="0 1 0" stiffness="40" damping="4"/>
  <geom type="capsule" fromto="0 0 0 .5 0 0" size=".03" mass="2"/>
  <body name="tool" pos=".5 0 0"><joint name="slide" type="slide" axis="1 0 0" stiffness="500"
    damping="60"/><geom size=".04" mass=".5"/></body>
</body></worldbody></mujoco>"""

SLIDER = """
<mujoco><worldbody>
<body name="cart"><joint name="x" type="slide" axis="1 0 0" stiffness="100" damping="0"/>
  <geom size=".1" mass="4"/></body></worldbody></mujoco>"""


def stepper_of(xml):
    model = mujoco.MjModel.from_xml_string(xml)
    stepper = _native.Stepper()
    stepper.set_model(**model_arrays(model))
    stepper.set_joint_forces(**joint_arrays(model))
    stepper.set_pairings(*(np.zeros((1, 1)) for _ in range(3)))
    stepper.set_drive(time_constant=0.02, recovery_rate=8.0, recover_root=False, root_speed=1.0)
    stepper.set_contact(
        clearance=1e-3,
        clearance_range=0.05,
        depenetration_speed=0.5,
        tolerance=1e-6,
        max_sweeps=50,
        gravity=np.array([0.0, 0.0, -9.81]),
    )
    stepper.finish([])
    return model, stepper


class Side:
    """Worlds of one model side by side."""

    def __init__(self, xml, count=1, threads=1, effort=np.inf):
        self.count = count
        made = [stepper_of(xml) for _ in range(count)]
        model = made[0][0]
        self.steppers = [stepper for _, stepper in made]
        self.motors, self.bodies = model.njnt, model.nbody - 1
        self.fleet = _native.Fleet(count, threads, bodies=self.bodies, motors=self.motors, groups=1)
        none = np.zeros(0, np.int32)
        for i, stepper in enumerate(self.steppers):
            stepper.reset(model.qpos0.copy(), np.zeros(model.nv))
            self.fleet.put(
                i,
                stepper,
                bodies=np.arange(1, model.nbody, dtype=np.int32),
                motors=np.arange(model.njnt, dtype=np.int32),
                effort=np.full(model.njnt, float(effort)),
                shape_group=none,
                static_group=none,
            )
        self.poses = np.zeros((count, 7 * self.bodies))
        self.states = np.zeros((count, 2 * self.motors))
        self.impulses = np.zeros((count, 4))

    def frame(self, rests, dt, substeps, active=None, rates=None):
        self.fleet.frame(
            active=np.ones(self.count, np.int32) if active is None else active,
            targets=np.zeros((self.count, 0)),
            rests=np.ascontiguousarray(rests, dtype=float),
            rates=np.zeros(np.shape(rests)) if rates is None else np.array(rates, dtype=float),
            dt=dt,
            substeps=substeps,
            poses=self.poses,
            states=self.states,
            impulses=self.impulses,
        )


def test_a_motor_goes_where_it_is_told_and_bears_its_own_weight():
    """No sag: a tree with motors has no gravity, so the spring rests exactly where it is told."""
    side = Side(ARM)
    for _ in range(300):
        side.frame([[0.4, 0.05]], 1 / 30, 8)
    assert side.states[0, :2] == pytest.approx([0.4, 0.05], abs=1e-9)
    assert side.states[0, 2:] == pytest.approx([0.0, 0.0], abs=1e-8)
    tool = np.array([0.55 * np.cos(0.4), 0.0, 1.0 - 0.55 * np.sin(0.4)])
    assert side.poses[0, 7:10] == pytest.approx(tool, abs=1e-8)


def test_a_motor_exerts_its_effort_at_most():
    """From far off it pushes a cart with constant force: v = F t / m."""
    side = Side(SLIDER, effort=6.0)
    for _ in range(30):
        side.frame([[100.0]], 1 / 60, 10)
    assert side.states[0, 1] == pytest.approx(6.0 * 0.5 / 4.0, rel=1e-3)


@pytest.mark.parametrize("substeps", [4, 8, 80])
@pytest.mark.parametrize(
    ("mass", "stiffness", "damping", "effort"), [(36.0, 4000, 900, 120.0), (0.1, 1500, 60, 25.0)]
)
def test_a_motor_at_its_effort_exerts_all_of_it(mass, stiffness, damping, effort, substeps):
    """However stiff and damped it is: v = F t / m, of a base and of a finger."""
    joint = f'<joint type="slide" axis="1 0 0" stiffness="{stiffness}" damping="{damping}"/>'
    body = f'<body>{joint}<geom size=".1" mass="{mass}"/></body>'
    side = Side(f"<mujoco><worldbody>{body}</worldbody></mujoco>", effort=effort)
    side.frame([[100.0]], 1 / 30, substeps)
    assert side.states[0, 1] == pytest.approx(effort / 30 / mass, rel=1e-9)


def test_a_light_motor_of_great_effort_comes_to_rest_where_it_is_told():
    """What it would exert at a step's end decides: its effort throws it beyond in no step."""
    joint = '<joint type="slide" axis="1 0 0" stiffness="1500" damping="60"/>'
    body = f'<body>{joint}<geom size=".1" mass="0.1"/></body>'
    side = Side(f"<mujoco><worldbody>{body}</worldbody></mujoco>", effort=25.0)
    path = []
    for _ in range(60):
        side.frame([[0.05]], 1 / 30, 4)
        path.append(side.states[0, 0])
    assert max(path) < 0.0501
    assert (np.diff(path) > -1e-12).all()
    assert path[-1] == pytest.approx(0.05, abs=1e-6)


def test_a_motor_follows_a_rest_that_moves():
    """Its damping is against the rest's velocity: no lag but that of the steps of the rest."""
    side = Side(ARM)
    for k in range(1, 91):
        side.frame([[0.5 * k / 30, 0.0]], 1 / 30, 8, rates=[[0.5, 0.0]])
    assert side.states[0, 2] == pytest.approx(0.5, rel=0.05)
    assert side.states[0, 0] == pytest.approx(1.5, abs=0.5 / 30)


def test_a_motor_within_its_effort_is_a_spring():
    side = Side(SLIDER)
    for _ in range(12):
        side.frame([[0.01]], 1 / 60, 80)
    assert side.states[0, 0] == pytest.approx(0.01 * (1 - np.cos(5.0 * 0.2)), rel=5 * CLOSED)


def test_every_world_is_for_itself_whatever_the_threads():
    def run(count, threads):
        side = Side(ARM, count, threads)
        told = np.random.default_rng(4).uniform(-0.5, 0.5, (20, 7, 2))
        for rests in told:
            side.frame(rests[:count], 1 / 30, 8)
        return np.hstack([side.poses, side.states])

    one = run(7, 1)
    assert np.array_equal(one, run(7, 2))
    assert np.array_equal(one, run(7, 8))
    assert np.array_equal(one[:3], run(3, 2))


def test_only_active_worlds_move_and_are_looked_at():
    side = Side(ARM, 2)
    before = side.steppers[1].qpos()
    side.frame([[0.3, 0.0], [0.3, 0.0]], 1 / 30, 8, np.array([1, 0], np.int32))
    assert np.array_equal(side.steppers[1].qpos(), before)
    assert side.poses[0].any()
    assert not side.poses[1].any()
    side.frame([[0.3, 0.0], [0.3, 0.0]], 1 / 30, 0)
    assert np.array_equal(side.steppers[1].qpos(), before)
    assert side.poses[1, :3] == pytest.approx([0.0, 0.0, 1.0], abs=EXACT)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"motors": np.array([0], np.int32), "effort": np.ones(1)}, "bad number"),
        ({"effort": np.array([1.0, np.nan])}, "efforts"),
        ({"bodies": np.array([1, 9], np.int32)}, "no such body"),
        ({"motors": np.array([0, 5], np.int32)}, "hinges and slides"),
    ],
)
def test_what_does_not_fit_is_refused(change, words):
    side = Side(ARM)
    none = np.zeros(0, np.int32)
    given = {
        "bodies": np.array([1, 2], np.int32),
        "motors": np.array([0, 1], np.int32),
        "effort": np.ones(2),
        "shape_group": none,
        "static_group": none,
    }
    with pytest.raises(ValueError, match=words):
        side.fleet.put(0, side.steppers[0], **(given | change))


def test_wrong_sizes_of_a_frame_are_refused():
    side = Side(ARM, 2)
    with pytest.raises(ValueError, match="one row per world"):
        side.frame(np.zeros((1, 2)), 1 / 30, 8)
    with pytest.raises(ValueError, match="bad shape"):
        side.frame(np.zeros((2, 3)), 1 / 30, 8)


def test_a_motor_without_effort_does_nothing():
    side = Side(SLIDER, effort=0.0)
    side.frame([[1.0]], 1 / 30, 8)
    assert side.states[0, 1] == 0.0

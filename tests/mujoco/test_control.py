"""People in a user's own MuJoCo world, stepped by `Control`."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsWarning, InputError
from support.as_it_is import as_it_is
from support.mujoco_worlds import HEIGHT, WRIST, spec_of, t_pose
from support.people import along_x


def sweep(model: mujoco.MjModel, data: mujoco.MjData, step, seconds: float, to: float) -> list:
    """Turn the arm about its yaw joint to `to` [rad], slowly; the results of `step`."""
    out = []
    count = round(seconds / model.opt.timestep)
    for i in range(count):
        data.ctrl[0] = to * min(1.0, 2.0 * (i + 1) / count)
        out.append(step())
    return out


def test_robot_moves_as_without_the_person_where_nothing_touches():
    alone = spec_of(x=3.0, rub=1).compile()
    data = mujoco.MjData(alone)
    spec = spec_of(x=3.0, rub=1)
    human = hp.attach(spec)
    model = spec.compile()
    ours = mujoco.MjData(model)
    control = human.bind(model, ours)
    pose = t_pose()
    control.reset(pose)
    path = sweep(alone, data, lambda: (mujoco.mj_step(alone, data), data.qpos.copy())[1], 1.0, 1.2)
    mine = sweep(model, ours, lambda: (control.step(pose), ours.qpos[:2].copy())[1], 1.0, 1.2)
    # Sums of masses in another order: rounding, over 500 steps.
    np.testing.assert_allclose(mine, path, rtol=0.0, atol=1e-12)
    assert ours.time == pytest.approx(1.0)


def test_motion_is_followed_exactly_where_nothing_touches():
    spec = spec_of(x=3.0, rub=1)
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    model.opt.timestep = 1.0 / 480.0
    control = human.bind(model, data, settings=as_it_is())
    sequence = hp.scenarios.load("walk_into_wall")
    motion = sequence.motion[:20]
    control.reset(motion[0])
    for i in range(1, 20):
        control.step(motion[i], dt=1.0 / motion.fps)
        np.testing.assert_allclose(control.pose.translation, motion[i].translation, atol=1e-12)
        apart = rot.log(
            rot.multiply(
                rot.conjugate(rot.exp(control.pose.rotations)), rot.exp(motion[i].rotations)
            )
        )
        assert np.abs(apart).max() < 1e-12


#: Frame rates of cameras, tracking systems and headsets [1/s].
RATES = (24.0, 30.0, 60.0, 120.0, 29.97)


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("timestep", [None, 0.0017, 0.004])
def test_any_frame_rate_with_any_timestep(fps, timestep):
    """Person and world are where they belong at each frame; None: MuJoCo's default of 2 ms."""
    spec = mujoco.MjSpec.from_string("""<mujoco><worldbody>
      <body name="ball" pos="3 0 9"><freejoint/><geom size="0.1" mass="1"/></body>
    </worldbody></mujoco>""")
    human = hp.attach(spec)
    model = spec.compile()
    model.opt.timestep = timestep or model.opt.timestep
    given = model.opt.timestep
    data = mujoco.MjData(model)
    control = human.bind(model, data, settings=as_it_is())
    motion = hp.scenarios.load("walk_into_wall", fps=fps).motion[:8]
    control.reset(motion[0])
    times = []
    mujoco.set_mjcb_control(lambda _, data: times.append(data.time))
    try:
        for i in range(1, 8):
            control.step(motion[i], dt=1.0 / fps)
            assert data.time == pytest.approx(i / fps, abs=1e-13)
            np.testing.assert_allclose(control.pose.translation, motion[i].translation, atol=1e-12)
            back = rot.conjugate(rot.exp(control.pose.rotations))
            apart = rot.log(rot.multiply(back, rot.exp(motion[i].rotations)))
            assert np.abs(apart).max() < 1e-12
            # Semi-implicit Euler: v = -g t to rounding, whatever the length of the steps.
            assert data.qvel[2] == pytest.approx(-9.81 * i / fps, abs=1e-11)
    finally:
        mujoco.set_mjcb_control(None)
    steps = np.diff([*times, 7.0 / fps])
    assert steps.max() <= given * (1.0 + 1e-6)
    assert np.ptp(steps) < 1e-13
    assert model.opt.timestep == given


@pytest.mark.parametrize("fps", RATES)
def test_momentum_is_balanced_at_any_frame_rate(fps):
    _, data, control, pose = thrown("parts", timestep=0.002)
    met = 0.0
    for _ in range(round(0.15 * fps)):
        before = data.qvel[:3].copy()
        control.step(pose, dt=1.0 / fps)
        got = control.contacts.impulse.sum(axis=0)
        np.testing.assert_allclose(0.5 * (data.qvel[:3] - before), -got, atol=1e-12)
        met += np.linalg.norm(got)
    assert met > 0.5  # [N s]; the ball has 3


def test_a_step_that_fails_leaves_the_timestep():
    model, _, control, pose = thrown("parts")
    given = model.opt.timestep

    def fails(*_):
        raise RuntimeError("of the host")

    mujoco.set_mjcb_control(fails)
    try:
        with pytest.raises(RuntimeError, match="of the host"):
            control.step(pose, dt=1.0 / 30.0)
    finally:
        mujoco.set_mjcb_control(None)
    assert model.opt.timestep == given


#: The arm's swing: some centimetres beyond its contact with the forearm [rad].
SWING = 0.8


class Push:
    """The arm swings from the person's front and meets the right forearm."""

    def __init__(self, settings: hp.Settings, force: float) -> None:
        spec = spec_of(x=-1.1, y=-0.45, force=force)
        human = hp.attach(spec)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.pose = t_pose()
        self.control = human.bind(self.model, self.data, settings=settings)
        self.data.qpos[0] = self.data.ctrl[0] = -0.5 * np.pi
        self.control.reset(self.pose)
        self.touches, self.parts, self.turned, self.torque = 0, set(), 0.0, 0.0
        steps = round(1.0 / self.model.opt.timestep)
        for i in range(steps):
            self.data.ctrl[0] = -0.5 * np.pi + SWING * min(1.0, 1.2 * i / steps)
            self.control.step(self.pose)
            touched = self.control.contacts
            self.touches += len(touched.part) > 0
            self.parts |= {
                (hp.JOINT_NAMES[p], self.control.names[o])
                for p, o in zip(touched.part, touched.other, strict=True)
            }
            self.turned = max(self.turned, self.turn())
            self.torque = max(self.torque, abs(float(self.data.actuator_force[0])))

    def turn(self) -> float:
        """Largest turn of a joint, not the root, away from the pose [degrees]."""
        now, asked = rot.exp(self.control.pose.rotations), rot.exp(self.pose.rotations)
        away = rot.log(rot.multiply(rot.conjugate(asked), now))
        return float(np.degrees(np.linalg.norm(away[1:], axis=-1).max()))

    @property
    def moved(self) -> float:
        """Of the pelvis [m]."""
        return float(np.linalg.norm(self.control.pose.translation - self.pose.translation))


def test_arm_pushes_a_limp_arm_aside():
    push = Push(as_it_is(stiffness=0.0), force=200.0)
    assert push.parts == {("right_elbow", "fore")}
    assert push.turned > 10.0
    assert push.moved < 1e-3


def test_firm_person_is_displaced_whole():
    push = Push(as_it_is(stiffness=10.0), force=200.0)
    assert push.parts == {("right_elbow", "fore")}
    assert push.turned < 2.0
    assert push.moved > 1e-3


def test_weak_robot_stalls_at_its_force_limit():
    push = Push(as_it_is(stiffness=10.0), force=2.0)
    assert push.torque == 2.0
    # It stays at the contact with the arm, far from its target.
    assert push.data.qpos[0] - push.data.ctrl[0] < -0.15
    assert push.turned < 2.0


BALL = """
<mujoco>
  <option timestep="0.004" gravity="0 0 0"/>
  <worldbody>
    <body name="ball" pos="-0.55 -0.5 {z}">
      <freejoint/><geom name="ball" size="0.08" mass="0.5" friction="0.3"/>
    </body>
  </worldbody>
</mujoco>
"""


def thrown(
    contact: str, timestep: float | None = None
) -> tuple[mujoco.MjModel, mujoco.MjData, object, hp.Pose]:
    """A ball that flies at the person's right forearm at 6 m/s."""
    spec = mujoco.MjSpec.from_string(BALL.format(z=HEIGHT + WRIST))
    human = hp.attach(spec, prefix="p/")
    model = spec.compile()
    model.opt.timestep = timestep or model.opt.timestep
    data = mujoco.MjData(model)
    control = human.bind(model, data, settings=hp.Settings(contact=contact))
    data.qvel[:3] = (0.0, 6.0, 0.0)
    pose = t_pose()
    control.reset(pose)
    return model, data, control, pose


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_what_the_person_gets_the_ball_loses(contact):
    model, data, control, pose = thrown(contact)
    geom = model.geom("ball").id
    met, nearest = 0, np.inf
    for _ in range(60):
        before = data.qvel[:3].copy()
        control.step(pose)
        got = control.contacts.impulse.sum(axis=0)
        np.testing.assert_allclose(0.5 * (data.qvel[:3] - before), -got, atol=1e-12)
        met += np.linalg.norm(got) > 0.0
        if contact == "parts":
            mujoco.mj_kinematics(model, data)
            for part in ("p/right_elbow", "p/right_shoulder", "p/right_wrist"):
                other = model.geom(part).id
                apart = mujoco.mj_geomDistance(model, data, geom, other, 1.0, None)
                nearest = min(nearest, apart)
    assert met > 0
    assert control.names == ("ball", "p")
    # MuJoCo measures meshes in single precision.
    assert nearest > -1e-5


def test_state_resumes_bit_for_bit():
    model, data, control, pose = thrown("skin")
    for _ in range(15):
        control.step(pose)
    assert repr(control) == "Control('p', 1 geom around: running)"
    kept = control.get_state()
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_INTEGRATION)
    world = np.empty(size)
    mujoco.mj_getState(model, data, world, mujoco.mjtState.mjSTATE_INTEGRATION)

    def go_on() -> list[tuple[np.ndarray, np.ndarray]]:
        path = []
        for _ in range(20):
            control.step(pose)
            path.append((data.qpos.copy(), data.qvel.copy()))
        return path

    first = go_on()
    mujoco.mj_setState(model, data, world, mujoco.mjtState.mjSTATE_INTEGRATION)
    control.set_state(kept)
    for (qpos, qvel), (qpos0, qvel0) in zip(go_on(), first, strict=True):
        np.testing.assert_array_equal(qpos, qpos0)
        np.testing.assert_array_equal(qvel, qvel0)


@pytest.mark.parametrize("kind", ["mjSTATE_FULLPHYSICS", "mjSTATE_INTEGRATION"])
def test_a_state_leaves_no_force_of_what_came_after_it(kind):
    """MuJoCo's smaller states do not have `xfrc_applied`: forces of now are taken back then."""
    model, data, control, pose = thrown("skin")
    own = np.array([0.0, 0.25, 0.0, 0.0, 0.0, 0.0])
    body = model.body("ball").id
    data.xfrc_applied[body] = own
    while not len(control.contact):
        control.step(pose)
    what = getattr(mujoco.mjtState, kind)
    kept, world = control.get_state(), np.empty(mujoco.mj_stateSize(model, what))
    mujoco.mj_getState(model, data, world, what)

    def go_on(steps: int) -> np.ndarray:
        path = []
        for _ in range(steps):
            control.step(pose)
            path.append(np.concatenate([data.qpos, data.qvel]))
        return np.array(path)

    first = go_on(3)
    assert np.abs(data.xfrc_applied[body] - own).max() > 1.0
    assert control.torques.any()
    mujoco.mj_setState(model, data, world, what)
    control.set_state(kept)
    assert not len(control.contact)
    assert not len(control.contacts.part)
    assert not control.torques.any()
    np.testing.assert_array_equal(go_on(3), first)
    go_on(60)
    assert not len(control.contact)
    np.testing.assert_array_equal(data.xfrc_applied[body], own)


def test_firmness_and_torques_are_those_of_our_own_world():
    """A wall that a person walks into, once as a MuJoCo geom and once as a static of a scene."""
    story = hp.scenarios.load("walk_into_wall")
    motion, wall = story.motion[25:60], story.scene.statics["wall"]
    text = """<mujoco><option timestep="{h}"/><worldbody>
      <geom name="wall" type="box" size="{0} {1} {2}" pos="{3} {4} {5}"/>
      <geom name="floor" type="plane" size="9 9 0.1"/></worldbody></mujoco>"""
    spec = mujoco.MjSpec.from_string(
        text.format(*(0.5 * np.array(wall.shape.size)), *wall.position, h=1.0 / motion.fps / 8)
    )
    human = hp.attach(spec)
    model = spec.compile()
    settings = hp.Settings(stiffness=0.5, substeps=8)
    control = human.bind(model, mujoco.MjData(model), settings=settings)
    simulator = hp.Simulator(story.scene, body=human.body, settings=settings, fps=motion.fps)
    with pytest.raises(InputError, match=r"set_stiffness: .*call reset\(pose\) first"):
        control.set_stiffness(1.0)
    largest, pressed = 0.0, []
    for again in range(2):  # reset goes back to the settings' firmness
        control.reset(motion[0])
        simulator.reset(motion[0])
        assert not control.torque.any()
        for t in range(1, len(motion) if not again else 12):
            if t == 20:
                for one in (control, simulator):
                    one.set_stiffness({"legs": 0.0, "hands": 3.0})
            pose = motion[t]
            if t > 30:
                pose = dataclasses.replace(pose, stiffness_scale=np.linspace(1.0, 5.0, 55))
            control.step(pose, dt=1.0 / motion.fps)
            frame = simulator.step(pose)
            np.testing.assert_allclose(control.torque, frame.torque, rtol=0.0, atol=1e-6)
            largest = max(largest, np.abs(frame.torque).max())
            pressed.append(len(frame.contacts.part) > 0)
    assert largest > 10.0
    assert not pressed[0]
    assert any(pressed)
    with pytest.raises(InputError, match="set_stiffness"):
        control.set_stiffness({"tail": 1.0})


def test_mistakes_say_what_was_expected():
    with pytest.raises(InputError, match=r"expected a mujoco.MjSpec"):
        hp.attach("robot.xml")
    spec = spec_of()
    human = hp.attach(spec)
    with pytest.raises(InputError, match="another prefix"):
        hp.attach(spec)
    model = spec.compile()
    control = human.bind(model, mujoco.MjData(model))
    with pytest.raises(InputError, match=r"call reset\(pose\) first"):
        control.step(t_pose())
    with pytest.raises(InputError, match=r"expected a halfphysics.Pose"):
        control.reset(np.zeros(165))
    with pytest.warns(HalfPhysicsWarning, match="inside upper"):  # of this spec's arm
        control.reset(t_pose())
    for wrong in (0.0, -1.0 / 30.0, np.nan, np.inf, "1/30", True):
        with pytest.raises(InputError, match=r"step: dt: found .*, expected a time above 0"):
            control.step(t_pose(), dt=wrong)
    control.step(t_pose(), dt=np.array(0.01))  # a number of any library
    with pytest.raises(InputError, match="expected one that get_state gave"):
        control.set_state(control.get_state()[:-8])
    with pytest.raises(InputError, match="found nobody, expected people of different prefixes"):
        hp.bind(model, mujoco.MjData(model), [])
    with pytest.raises(InputError, match="found 2 poses, expected one per person: human"):
        control.step([t_pose(), t_pose()])
    with pytest.raises(InputError, match="found person 1, expected 0 to 0"):
        control.set_stiffness(1.0, person=1)
    alone = spec_of().compile()
    with pytest.raises(InputError, match="no person with prefix"):
        human.bind(alone, mujoco.MjData(alone))
    # The core would write beyond the end of data of a smaller model.
    with pytest.raises(InputError, match="data is of another model"):
        human.bind(model, mujoco.MjData(alone))
    with pytest.raises(InputError, match=r"expected a mujoco\.MjModel and its"):
        human.bind(model, None)
    with pytest.raises(InputError, match="at most 1e"):
        control.step(t_pose(), dt=1e9)
    model.opt.timestep = 0.0
    with pytest.raises(InputError, match="timestep is 0 s, expected one above 0"):
        control.step(t_pose(), dt=0.1)
    for wrong in ("", "a\0", 3):
        with pytest.raises(InputError, match="prefix: found"):
            hp.attach(spec_of(), prefix=wrong)


def test_a_mocap_body_that_collides_is_refused():
    box = '<body name="m" mocap="true"><geom name="tool" size="0.1"/></body>'
    spec = spec_of(more=box)
    human = hp.attach(spec)
    model = spec.compile()
    with pytest.raises(InputError, match="'tool' is on a mocap body"):
        human.bind(model, mujoco.MjData(model))


def test_a_start_inside_a_robot_is_warned_of():
    """The hinge gives way to nothing: hundreds of kN, without a word."""
    spec = mujoco.MjSpec.from_string(
        "<mujoco><worldbody><body name='arm' pos='0 -0.4 1.5'><joint type='hinge' axis='0 0 1'/>"
        "<geom name='link' type='capsule' fromto='0 0 0 0.6 0 0' size='0.05' mass='5'/></body>"
        "</worldbody></mujoco>"
    )
    human = hp.attach(spec)
    model = spec.compile()
    control = human.bind(model, mujoco.MjData(model))
    start = along_x(0.0, 2, start=0.0, z=1.5)[0]
    with pytest.warns(HalfPhysicsWarning, match=r"pelvis \d+ mm inside link.*whatever force"):
        control.reset(start)


CART = """<mujoco><option timestep="0.002"/><worldbody>
  <body name="cart" pos="0 0 -0.1" gravcomp="1"><joint type="slide" axis="1 0 0"/>
  <joint type="hinge" axis="0 1 0" stiffness="20000" damping="200"/>
  <geom name="plate" type="box" size="1 1 .1" mass="60"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("frame", [None, 1.0 / 30.0])
def test_a_cart_that_rolls_under_somebody_is_slowed_down_by_friction(frame):
    """By mu m g, which is among MuJoCo's forces and the person's contacts, until it stops."""
    mu, mass = 0.3, 60.0
    spec = mujoco.MjSpec.from_string(f"""<mujoco><option timestep="0.002"/><worldbody>
      <body pos="0 0 -0.1"><joint type="slide" axis="1 0 0"/>
      <geom type="box" size="2 2 .1" mass="{mass}" friction="{mu}"/></body></worldbody></mujoco>""")
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    control = human.bind(model, data)
    control.reset(t_pose())
    for _ in range(100):
        control.step(t_pose())
    data.qvel[0] = 0.5
    force = mu * sum(part.mass for part in hp.Body.default().variant.parts) * 9.81
    for _ in range(3):
        before, began = data.qvel[0], data.time
        control.step(t_pose(), dt=frame)
        slowing = (before - data.qvel[0]) / (data.time - began)
        assert slowing == pytest.approx(force / mass, rel=1e-3)
        assert data.xfrc_applied[1, 0] == pytest.approx(-force, rel=1e-3)
        points = control.contact
        on_person = np.einsum("nk,nkx->x", points.force[:, :3], points.frame.reshape(-1, 3, 3))
        assert on_person[0] == pytest.approx(force, rel=1e-3)
    for _ in range(150):
        control.step(t_pose())
    assert abs(data.qvel[0]) < 1e-9


def test_a_state_resumes_where_the_world_was_elsewhere_meanwhile():
    """Who stands weighs on the cart where it is now, whatever MuJoCo last worked out of it."""
    spec = mujoco.MjSpec.from_string(CART)
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    control = human.bind(model, data, settings=hp.Settings(contact="parts"))
    control.reset(t_pose())
    data.qvel[0] = 0.5
    for _ in range(100):
        control.step(t_pose())
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_INTEGRATION)
    world, kept = np.empty(size), control.get_state()
    mujoco.mj_getState(model, data, world, mujoco.mjtState.mjSTATE_INTEGRATION)

    def go_on() -> np.ndarray:
        path = []
        for _ in range(40):
            control.step(t_pose())
            path.append(np.concatenate([data.qpos, data.qvel]))
        return np.array(path)

    first = go_on()
    assert data.xfrc_applied[1, 2] < -500.0
    data.qpos[0] = 1.0
    mujoco.mj_forward(model, data)
    mujoco.mj_setState(model, data, world, mujoco.mjtState.mjSTATE_INTEGRATION)
    control.set_state(kept)
    np.testing.assert_array_equal(go_on(), first)


def test_states_of_other_worlds_are_refused():
    kept = [thrown(contact)[2].get_state() for contact in ("skin", "parts")]
    control = thrown("skin")[2]
    before = control.get_state()
    for state in (kept[1], kept[0][:-16] + bytes(8) + kept[0][-8:], kept[0][8:], bytes(32)):
        with pytest.raises(InputError, match="set_state"):
            control.set_state(state)
    assert control.get_state() == before
    control.set_state(kept[0])

"""A person in a `MjSpec`: seen, and nothing of the model's own is changed."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from support.mujoco_worlds import HEIGHT, spec_of, t_pose

#: MuJoCo keeps meshes in single precision; the person's chest is this far from its joint [m].
CHEST = 0.3


def test_model_keeps_its_joints_masses_and_keyframes():
    alone = spec_of().compile()
    spec = spec_of(more='<body name="tool"><freejoint/><geom size="0.1" mass="1"/></body>')
    key = spec.add_key(name="home")
    key.qpos = [0.3, -0.2, 2.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    hp.attach(spec)
    model = spec.compile()
    assert (model.nq, model.nv) == (alone.nq + 7, alone.nv + 6)
    assert model.nmocap == 55
    assert model.body_mass.sum() == pytest.approx(alone.body_mass.sum() + 1.0)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    assert data.qpos[0] == 0.3


def test_person_weighs_what_it_weighs_whatever_the_compiler_does():
    """`inertiafromgeom` would make a person of water of hulls."""
    spec = spec_of(x=3.0)
    human = hp.attach(spec)
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    model = spec.compile()
    control = human.bind(model, mujoco.MjData(model))
    wanted = np.array([part.mass for part in human.body.variant.parts])
    core = np.asarray(control._host.masses)[control.people[0].bodies]
    np.testing.assert_array_equal(core, wanted)
    mirrors = [model.body(f"human/{name}").id for name in hp.JOINT_NAMES]
    assert not model.body_mass[mirrors].any()


def test_person_stands_until_it_is_bound():
    spec = spec_of(x=3.0)
    hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.body("human/head").xpos[2] > 1.4
    mesh = [g for g in range(model.ngeom) if model.geom(g).name.startswith("human/")]
    low = min(data.geom_xpos[g][2] - model.geom_rbound[g] for g in mesh)
    assert -0.1 < low < 0.1


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_rays_meet_the_person_where_it_is(contact):
    """A rangefinder looks at the chest; the person steps back by 0.2 m."""
    spec = mujoco.MjSpec.from_string(f"""<mujoco><worldbody>
      <site name="eye" pos="0 -1 {HEIGHT + 0.3}" zaxis="0 1 0"/>
      </worldbody><sensor><rangefinder site="eye"/></sensor></mujoco>""")
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    control = human.bind(model, data, settings=hp.Settings(contact=contact))
    start = t_pose()
    control.reset(start)
    first = float(data.sensordata[0])
    assert 1.0 - CHEST < first < 1.0
    for i in range(1, 41):
        back = hp.Pose(start.translation + np.array([0.0, 0.005 * i, 0.0]), start.rotations)
        control.step(back, dt=1.0 / 40.0)
    # MuJoCo's sensors are of the beginning of the last timestep: 2 ms at 0.2 m/s.
    assert data.sensordata[0] == pytest.approx(first + 0.2 - 0.2 * 0.002, abs=2e-4)
    mujoco.mj_forward(model, data)
    assert data.sensordata[0] == pytest.approx(first + 0.2, abs=2e-5)
    part = data.body("human/right_wrist").xpos
    np.testing.assert_allclose(part[1], start_of("right_wrist", start)[1] + 0.2, atol=1e-6)


def start_of(name: str, pose: hp.Pose) -> np.ndarray:
    body = hp.Body.default()
    return body.joints(pose)[hp.JOINT_NAMES.index(name)]


def test_a_default_class_of_the_spec_does_not_change_the_person():
    """A robot's file may say that its meshes are in millimetres, and turn its geoms."""
    floor = '<worldbody><geom type="plane" size="1 1 1"/></worldbody>'
    default = '<default><mesh scale="2 0.1 3" maxhullvert="6"/><geom euler="1 2 3"/></default>'
    found = []
    for text in (floor, default + floor):
        spec = mujoco.MjSpec.from_string(f"<mujoco>{text}</mujoco>")
        hp.attach(spec)
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        found.append((model.mesh_vert.copy(), data.geom_xpos[1:].copy(), data.geom_xmat[1:].copy()))
    for plain, changed in zip(*found, strict=True):
        np.testing.assert_array_equal(changed, plain)


@pytest.mark.parametrize("discard", [False, True])
def test_a_person_whose_geoms_the_compiler_discards_is_warned_of(discard, recwarn):
    spec = spec_of(x=3.0)
    spec.compiler.discardvisual = discard
    human = hp.attach(spec)
    model = spec.compile()
    human.bind(model, mujoco.MjData(model))
    said = [str(w.message) for w in recwarn if "discardvisual = False" in str(w.message)]
    assert len(said) == discard
    assert not discard or "'human/'" in said[0]

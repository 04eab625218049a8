"""The robots: inverse kinematics against MuJoCo's, motors that the models have."""

import mujoco
import numpy as np
import pytest

from halfphysics.envs.robots import ARM, ARM_XML, BASE_EFFORT, BASE_XML, HOLDER_XML, efforts

#: Rounding of positions of a metre.
EXACT = 1e-12


def test_the_arm_reaches_the_points_that_it_is_asked_for():
    model = mujoco.MjModel.from_xml_string(ARM_XML)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(2)
    points = rng.uniform([0.45, -0.35, 0.75], [0.75, 0.35, 1.2], (40, 3))
    for point, angles in zip(points, ARM.reach(points), strict=True):
        for name, angle in zip(ARM.joints, angles, strict=True):
            low, high = model.joint(name).range
            assert low <= angle <= high
            data.joint(name).qpos = angle
        mujoco.mj_kinematics(model, data)
        hand = data.body("hand")
        ahead = hand.xmat.reshape(3, 3)[:, 2]
        assert hand.xpos + ARM.hand * ahead == pytest.approx(point, abs=EXACT)
        assert ahead[2] == pytest.approx(0.0, abs=EXACT)  # level
        outwards = point[:2] / np.linalg.norm(point[:2])
        assert ahead[:2] == pytest.approx(outwards, abs=EXACT)


def test_what_is_out_of_reach_is_approached():
    angles = ARM.reach(np.array([[3.0, 0.0, 0.9], [0.12, 0.0, 0.85]]))
    assert np.isfinite(angles).all()


@pytest.mark.parametrize(
    ("xml", "effort"), [(ARM_XML, ARM.effort), (BASE_XML, BASE_EFFORT), (HOLDER_XML, BASE_EFFORT)]
)
def test_every_motor_is_a_joint_with_a_spring(xml, effort):
    model = mujoco.MjModel.from_xml_string(xml)
    assert [model.joint(i).name for i in range(model.njnt)] == list(effort)
    for i in range(model.njnt):
        assert np.ravel(model.jnt_stiffness[i])[0] > 0.0
    assert list(efforts("it", effort)) == [f"it/{name}" for name in effort]

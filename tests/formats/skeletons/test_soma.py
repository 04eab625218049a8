"""The SOMA skeleton: order, parents and T-pose as documented, written out a second time."""

from __future__ import annotations

import numpy as np

from halfphysics.formats.skeletons.soma import SOMA, is_soma
from support.files.soma_files import NAMES, PARENTS, THIRTY, THIRTY_PARENTS

ROUNDED = 1.5e-3  # metres: places are in whole millimetres


def test_order_and_parents():
    assert list(SOMA) == [77, 30]
    assert list(SOMA[77].names) == NAMES
    assert list(SOMA[77].parents) == PARENTS
    assert list(SOMA[30].names) == [NAMES[joint] for joint in THIRTY]
    assert list(SOMA[30].parents) == THIRTY_PARENTS
    assert np.array_equal(SOMA[30].rest, SOMA[77].rest[THIRTY])


def test_the_mean_person_stands_in_a_t():
    soma = SOMA[77]
    at = dict(zip(soma.names, soma.rest, strict=True))
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        arm = np.diff([at[side + part] for part in ("Arm", "ForeArm", "Hand")], axis=0)
        assert np.abs(arm[:, 1:]).max() < ROUNDED
        assert (sign * arm[:, 0] > 0.25).all()
        hip, knee, ankle = (at[side + part] for part in ("Leg", "Shin", "Foot"))
        leg = np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee)
        assert abs(leg - 0.8545) < ROUNDED
        toe = at[f"{side}ToeBase"] - ankle
        assert toe[2] > 0.1
        assert abs(toe[0]) < ROUNDED
    assert abs(at["HeadEnd"][1] - at["LeftToeEnd"][1] - 1.764) < ROUNDED
    for name, place in at.items():
        if name.startswith("Left"):
            other = at[name.replace("Left", "Right")]
            assert np.array_equal(other, place * [-1.0, 1.0, 1.0])


def test_told_by_its_names():
    assert is_soma(["Root", *NAMES])
    assert not is_soma(NAMES[1:])

"""Settings of the baselines refuse options of other modes."""

from __future__ import annotations

import mujoco
import pytest

import halfphysics as hp
from halfphysics.baselines import from_options
from halfphysics.baselines.options import MODES
from halfphysics.errors import InputError


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


@pytest.mark.parametrize("mode", ["kinematic", "positions", "interpolated"])
@pytest.mark.parametrize(
    "other",
    [
        {"root": "recover"},
        {"self_contact": True},
        {"strength": "human"},
        {"internal_forces": True},
        {"joint_damping": 1.0},
    ],
    ids=lambda other: next(iter(other)),
)
def test_senseless_settings(mode, other):
    with pytest.raises(InputError, match=next(iter(other))):
        from_options({"mode": mode, **other})
    assert MODES[mode].paper().drive == MODES[mode]().drive


@pytest.mark.parametrize("mode", ["kinematic", "positions", "interpolated", "engine_kinematic"])
def test_not_in_somebody_elses_world(body, mode):
    spec = mujoco.MjSpec()
    human = hp.attach(spec, body)
    model = spec.compile()
    with pytest.raises(InputError, match="a person is driven"):
        human.bind(model, mujoco.MjData(model), settings=MODES[mode]())

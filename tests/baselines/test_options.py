"""Flat options of the command line, sweeps and result files, and the resulting settings."""

from __future__ import annotations

import dataclasses

import pytest

import halfphysics as hp
from halfphysics.baselines import Ablation, Torque, from_options, options_of, with_options
from halfphysics.baselines.options import MODES, OPTIONS
from halfphysics.errors import InputError
from halfphysics.settings import HALF_PHYSICS
from support.people import along_x

SETTINGS = [
    hp.Settings(stiffness={"legs": 0.5}, strength="human"),
    Ablation(internal_forces=True),
    Ablation(joint_damping=0.5, drive_time=None),
    Torque(),
    Torque(frequency=20.0, damping=0.5, joint_damping=0.1),
    *(kind(substeps=3) for kind in MODES.values()),
]


@pytest.mark.parametrize("settings", SETTINGS, ids=lambda s: type(s).__name__)
def test_there_and_back(settings):
    options = options_of(settings)
    assert tuple(options) == OPTIONS
    assert from_options(options) == settings
    assert with_options(settings, {}) is settings
    assert with_options(settings, {"clearance": 0.002}) == dataclasses.replace(
        settings, clearance=0.002
    )


def test_half_physics_is_plain_settings():
    assert type(from_options({})) is hp.Settings
    assert type(from_options({"mode": "velocity", "joint_damping": 0.0})) is hp.Settings
    assert hp.Settings().drive is HALF_PHYSICS
    assert all(kind().drive != HALF_PHYSICS for kind in MODES.values() if kind is not hp.Settings)


def test_options_of_torques_count_with_torques_alone():
    """Files from before the baselines had own settings always contain them."""
    assert from_options({"torque_frequency": 50.0}) == hp.Settings()
    assert from_options({"mode": "torque", "torque_frequency": 50.0}) == Torque(frequency=50.0)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"mode": "torqe"}, "mode is 'torqe'; expected 'velocity' or"),
        ({"mode": ["kinematic"]}, r"mode is \['kinematic'\]; expected 'velocity' or"),
        ({"stifness": 1.0}, "found .'stifness'"),
        ({"mode": "kinematic", "joint_damping": 1.0}, "joint_damping is 1.0 with mode='kinematic'"),
        ({"mode": "engine_velocity", "internal_forces": True}, "internal_forces is True with"),
        ({"joint_damping": 1.0, "strength": "human"}, "Ablation.strength is 'human'"),
    ],
)
def test_what_does_not_go_together_is_refused(options, said):
    with pytest.raises(InputError, match=said):
        from_options(options)


@pytest.mark.parametrize("settings", [Torque(contact="parts"), MODES["engine_velocity"]()])
def test_a_result_file_says_which_baseline_it_was(settings, tmp_path):
    result = hp.simulate(along_x(0.5, 4, start=0.0), settings=settings)
    result.save(tmp_path / "result.npz")
    assert hp.Result.load(tmp_path / "result.npz").settings == settings

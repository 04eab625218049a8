"""A simulator in use can be copied and sent to another process, and goes on bit for bit."""

from __future__ import annotations

import copy
import multiprocessing
import pickle

import pytest

import halfphysics as hp
from support import small_results as small

BEFORE, AFTER = 8, 12
METHODS = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "deepcopy": copy.deepcopy,
}


def running(settings=None):
    """Two people among objects, a platform and a door that is being pushed."""
    simulator = hp.Simulator(
        small.scene(), body=[hp.Body.default()] * 2, settings=settings, fps=30.0
    )
    motions = small.motions()
    simulator.reset([motion[0] for motion in motions])
    for t in range(1, BEFORE):
        simulator.step([motion[t] for motion in motions])
    return simulator


def go_on(simulator):
    """All that the next frames give, as bytes."""
    motions, found = small.motions(), []
    for t in range(BEFORE, BEFORE + AFTER):
        frame = simulator.step([motion[t] for motion in motions])
        found.append((simulator.world.stepper.qpos().tobytes(), frame.contacts.impulse.tobytes()))
    return found, simulator.get_state().numbers


def started(_):
    pass


def made_softer(simulator):
    simulator.set_stiffness({"arms": 0.2}, person=1)


def holding(simulator):
    simulator.attach("crate", "left_wrist", 1)


def changed(simulator):
    simulator.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0.5, 0.6, 1.9))
    simulator.remove_object("crate")
    simulator.set_velocity("box", (0.0, 1.0, 0.0))


@pytest.mark.parametrize(
    ("use", "method"),
    [
        (started, "deepcopy"),
        (made_softer, "pickle"),
        (holding, "pickle"),
        (holding, "deepcopy"),
        (changed, "pickle"),
    ],
)
def test_a_copy_goes_on_bit_for_bit(use, method):
    """Held objects, changed stiffness and objects that came and went are part of the copy."""
    simulator = running()
    use(simulator)
    again = METHODS[method](simulator)
    assert again.held == simulator.held
    assert again.names == simulator.names
    ours = go_on(simulator)
    assert len(set(ours[0])) == AFTER  # something moves
    assert go_on(again) == ours


def test_a_copy_starts_anew_as_the_original_does():
    simulator = running()
    again = METHODS["pickle"](simulator)
    poses = [motion[0] for motion in small.motions()]
    for one in (simulator, again):
        one.reset(poses)
    assert again.get_state().numbers == simulator.get_state().numbers


class Noted(hp.Simulator):
    """As a user writes one."""

    def __init__(self, *given, **options):
        super().__init__(*given, **options)
        self.notes = ["made"]


@pytest.mark.parametrize("method", METHODS)
def test_what_a_subclass_adds_is_in_the_copy(method):
    again = METHODS[method](Noted(small.scene(), fps=30.0))
    assert type(again) is Noted
    assert again.notes == ["made"]


def test_a_copy_before_the_first_pose():
    again = METHODS["pickle"](hp.Simulator(small.scene(), fps=60.0))
    assert again.dt == 1.0 / 60.0
    with pytest.raises(hp.errors.InputError, match="call reset"):
        again.step(small.motions()[0][0])


def test_what_is_added_to_the_scene_later_is_not_in_the_copy():
    """As it is not in the simulator."""
    scene = small.scene()
    simulator = hp.Simulator(scene, fps=30.0)
    scene.add_static("late", hp.Box((1.0, 1.0, 1.0)), position=(9.0, 0.0, 0.0))
    assert METHODS["pickle"](simulator).names == simulator.names


def test_another_process_goes_on():
    simulator = running(hp.Settings(contact="parts"))
    with multiprocessing.get_context("fork").Pool(1) as pool:
        there = pool.apply(go_on, (simulator,))
    assert there == go_on(simulator)

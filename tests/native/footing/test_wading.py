"""Who walks over soft layers stays on the path; who stands there sinks alike at every rate."""

import functools

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.simulation.simulator import Simulator
from support.mats import crossed, crossing, forces, mat, soles, stood

BODY = hp.Body.default()
#: Mats that are walked over: material and thickness [m].
WALKS = [("mat", 0.02), ("mat", 0.05), ("mat", 0.10), ("mattress", 0.10)]
#: A walk over one is off its path by less than this on the way, and at the end [m]; the pelvis is
#: upright within so much [degrees].
ON_PATH, AT_END, UPRIGHT = 0.05, 0.005, 2.0
#: Contacts press with more than two body weights for no longer than this [s].
IMPACT = 0.05
#: A foot is beside its reference by less than this; in stance it moves by less in a frame [m].
FEET, SLIDE = 0.03, 0.01
#: Depths at all frame rates and substeps agree within this [m], and carry the weight [its share].
SAME, CARRIED = 1e-3, 0.002


@functools.cache
def walked(material, thickness, fps=30.0):
    result = crossed(BODY, material, thickness, fps)
    return result, crossing(result, thickness)


@pytest.mark.parametrize(("material", "thickness"), WALKS)
def test_a_walk_over_a_mat_stays_on_its_path(material, thickness):
    _, figures = walked(material, thickness)
    assert figures.off_path < ON_PATH
    assert figures.end < AT_END
    assert figures.tilt < UPRIGHT
    assert figures.heavy < IMPACT
    assert figures.slide < SLIDE


@pytest.mark.parametrize(("material", "thickness"), WALKS)
def test_swinging_feet_pass_over_the_surface(material, thickness):
    _, figures = walked(material, thickness)
    assert figures.clear > 0.0
    assert figures.feet_off < FEET


def test_a_mattress_of_20_cm_is_waded_through():
    _, figures = walked("mattress", 0.20)
    assert figures.off_path < ON_PATH
    assert figures.end < AT_END
    assert figures.tilt < UPRIGHT


def test_nobody_is_lower_than_the_frame_has_them():
    """Not by more than legs give way: a person does not fold up over a layer that is at its end."""
    for material, thickness in WALKS:
        assert walked(material, thickness)[1].sunk < 0.05


@pytest.mark.parametrize(("material", "thickness"), [("mattress", 0.20), ("mat", 0.10)])
def test_who_stands_sinks_alike_at_every_rate(material, thickness):
    steps = [(30.0, 4), (30.0, 16), (60.0, 8), (120.0, 4)]
    depths = []
    for fps, substeps in steps:
        result = stood(BODY, material, thickness, fps, substeps)
        low = soles(result)[1][-1]
        depths.append(thickness - low)
        carried = forces(result)[-round(0.2 * fps) :, 2].mean()
        assert carried == pytest.approx(1.0, abs=CARRIED), (fps, substeps)
        moved = (result.motion.translation - result.reference.translation)[-1, :2]
        assert np.linalg.norm(moved) < SAME
    assert np.ptp(depths, axis=0).max() < SAME


def test_a_saved_state_goes_on_with_the_same_bits():
    result, _ = walked("mat", 0.10)
    motion = result.reference
    simulator = Simulator(mat("mat", 0.10), body=BODY, fps=motion.fps)
    simulator.reset(motion[0])
    for t in range(1, 75):
        simulator.step(motion[t])
    state = simulator.world.stepper.save()
    ends = []
    for _ in range(2):
        simulator.world.stepper.load(state)
        for t in range(75, 85):
            frame = simulator.step(motion[t])
        ends.append(np.concatenate([frame.pose.translation, np.ravel(frame.pose.rotations)]))
    np.testing.assert_array_equal(ends[0], ends[1])

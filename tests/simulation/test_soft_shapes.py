"""What the core is told of soft things, and what comes of it: sinks, pressures, files, copies."""

from __future__ import annotations

import copy
import warnings

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.results.layer_pressure import pressures
from halfphysics.simulation.soft_shapes import INNER, object_samples

#: A box at rest on a layer is as deep as k says to this share, and its force is its weight to that.
SINK, WEIGHT = 0.01, 0.001
MASS, STIFFNESS = 10.0, 1e5
LAYER = hp.Soft(0.1, STIFFNESS, damping=2e4, law="linear")  # comes to rest within a second
DEPTH = MASS * 9.81 / (STIFFNESS * 0.04)


def rested(static, top, layer=LAYER, soft=None, frames=60, **place):
    """A box of 10 kg after two seconds on a static whose surface is at `top` [m]."""
    scene = hp.Scene()
    scene.add_static("bed", static, soft=layer, **place)
    at = (0.0, 0.0, top + 0.1)
    scene.add_object("box", hp.Box((0.2, 0.2, 0.2)), mass=MASS, position=at, soft=soft)
    simulator = hp.Simulator(scene, body=[])
    simulator.reset([])
    for _ in range(frames):
        frame = simulator.step([])
    return simulator, frame


@pytest.mark.parametrize(
    ("static", "top"),
    [
        (hp.Plane(), 0.0),
        (hp.Box((1.0, 1.0, 0.5)), 0.25),
        (trimesh.creation.box((1.0, 1.0, 0.5)), 0.25),
    ],
    ids=["plane", "box", "mesh"],
)
def test_a_box_sinks_as_deep_as_its_weight_asks(static, top):
    _, frame = rested(static, top)
    assert top + 0.1 - frame.objects["box"][0][2] == pytest.approx(DEPTH, rel=SINK)
    rows = frame.soft_contacts
    assert rows.force.sum(axis=0) == pytest.approx([0, 0, MASS * 9.81], rel=WEIGHT, abs=0.1)
    assert rows.area.sum() == pytest.approx(0.04, rel=1e-6)
    assert rows.pressure == pytest.approx(STIFFNESS * DEPTH, rel=SINK)
    assert set(rows.part) == set(rows.vertex) == {-1}


def test_a_soft_box_sinks_into_itself_on_a_hard_floor():
    _, frame = rested(hp.Plane(), 0.0, layer=None, soft=hp.Soft(0.05, STIFFNESS, 2e4, "linear"))
    assert 0.1 - frame.objects["box"][0][2] == pytest.approx(DEPTH, rel=SINK)


def test_a_soft_lift_carries_what_stands_on_it():
    """At rest for a second, then up at half a metre per second."""
    scene = hp.Scene()
    way = [(0.0, 0.0, z) for z in (0.0, 0.0, 0.5, 1.0)]
    scene.add_moving("lift", hp.Box((1.0, 1.0, 0.4)), way, fps=1.0, soft=LAYER)
    scene.add_object("box", hp.Box((0.2, 0.2, 0.2)), mass=MASS, position=(0, 0, 0.3))
    simulator = hp.Simulator(scene, body=[])
    simulator.reset([])
    for _ in range(75):
        frame = simulator.step([])
    assert frame.objects["lift"][0][2] > 0.7
    sunk = frame.objects["lift"][0][2] + 0.3 - frame.objects["box"][0][2]
    assert sunk == pytest.approx(DEPTH, rel=SINK)
    assert frame.soft_contacts.force.sum(axis=0)[2] == pytest.approx(MASS * 9.81, rel=SINK)


def test_nothing_soft_has_no_pressures_and_no_samples():
    simulator, frame = rested(hp.Plane(), 0.0, layer=None, frames=1)
    assert frame.soft_contacts is None
    assert simulator.world.soft is False


def test_a_copy_and_a_state_go_on_with_the_same_bits():
    simulator, _ = rested(hp.Plane(), 0.0, layer=hp.Soft.named("pillow"), frames=5)
    twin, state = copy.deepcopy(simulator), simulator.get_state()
    first = [simulator.step([]) for _ in range(5)][-1]
    other = [twin.step([]) for _ in range(5)][-1]
    simulator.set_state(state)
    again = [simulator.step([]) for _ in range(5)][-1]
    for frame in (other, again):
        assert np.array_equal(frame.objects["box"][0], first.objects["box"][0])
        assert np.array_equal(frame.soft_contacts.pressure, first.soft_contacts.pressure)


def test_objects_brought_and_taken_away_change_no_bit_of_what_is_pressed():
    """A box that bounces on foam, and what the foam remembers of it."""
    layer, ball = hp.Soft.named("pillow"), hp.Sphere(0.1)
    left, changed = (rested(hp.Plane(), 0.0, layer=layer, frames=6)[0] for _ in range(2))
    for t in range(30):
        if t == 3:
            changed.add_object("ball", ball, mass=1.0, position=(5, 0, 0.1), soft="pillow")
        if t == 12:
            changed.remove_object("ball")
        one, other = left.step([]), changed.step([])
        for k in (0, 1):
            assert np.array_equal(one.objects["box"][k], other.objects["box"][k])
        pressed = other.soft_contacts
        mine = pressed[pressed.other == changed.names.index("box")]
        assert np.array_equal(one.soft_contacts.pressure, mine.pressure)


def test_a_result_with_pressures_comes_back_from_its_file(tmp_path):
    scene = hp.Scene()
    scene.add_static("bed", hp.Plane(offset=-0.5), soft=LAYER)
    scene.add_object("box", hp.Box((0.2, 0.2, 0.2)), mass=MASS, position=(1, 0, -0.4))
    body = hp.Body.default()
    motion = hp.Motion(np.tile([0.0, 0.0, 2.0], (20, 1)), np.zeros((20, 55, 3)), 30.0)
    result = hp.simulate(motion, scene, body=body, settings=hp.Settings(weight=False))
    assert len(result.soft_contacts) > 100
    result.save(tmp_path / "r.npz")
    loaded = hp.Result.load(tmp_path / "r.npz")
    for name in result.soft_contacts.columns():
        one, other = (getattr(r.soft_contacts, name) for r in (result, loaded))
        assert np.array_equal(one, other)
    assert loaded.scene.statics["bed"].soft == LAYER
    (pair,) = pressures(loaded)
    assert (pair.layer, pair.other) == ("bed", "box")
    assert "box: pressed on bed in" in result.summary()
    (many,) = hp.simulate_many([motion], scene, body=body, settings=hp.Settings(weight=False))
    assert np.array_equal(many.soft_contacts.pressure, result.soft_contacts.pressure)


def test_very_many_pressures_are_kept_of_every_second_frame(monkeypatch):
    scene = hp.Scene()
    scene.add_static("bed", hp.Plane(offset=-0.5), soft=LAYER)
    scene.add_object("box", hp.Box((0.2, 0.2, 0.2)), mass=MASS, position=(1, 0, -0.42))
    motion = hp.Motion(np.tile([0.0, 0.0, 2.0], (20, 1)), np.zeros((20, 55, 3)), 30.0)
    settings = hp.Settings(weight=False)
    whole = hp.simulate(motion, scene, settings=settings).soft_contacts
    monkeypatch.setattr("halfphysics.simulation.recording.MOST_PRESSED", len(whole) // 3)
    with pytest.warns(hp.HalfPhysicsWarning, match="of one frame in 4:"):
        some = hp.simulate(motion, scene, settings=settings).soft_contacts
    assert np.array_equal(some.pressure, whole[whole.frame % 4 == 0].pressure)


def test_baselines_of_another_engine_refuse_what_is_soft():
    scene = hp.Scene()
    scene.add_static("bed", hp.Plane(), soft="mat")
    motion = hp.Motion(np.tile([0.0, 0.0, 2.0], (3, 1)), np.zeros((3, 55, 3)), 30.0)
    with pytest.raises(hp.errors.InputError, match="'bed' is soft; this baseline"):
        hp.simulate(motion, scene, settings=hp.baselines.EngineVelocity())


def test_samples_of_several_pieces_lie_on_the_surface_of_all_of_them():
    """An L of two boxes that share a face: nothing inside, and the area of the L."""
    tall, flat = trimesh.creation.box((0.1, 0.1, 0.3)), trimesh.creation.box((0.2, 0.1, 0.1))
    tall.apply_translation((0.05, 0.05, 0.15))
    flat.apply_translation((0.2, 0.05, 0.05))
    whole = trimesh.util.concatenate([tall, flat])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        item = hp.Scene().add_object("L", whole, mass=1.0, pieces=[tall, flat])
    samples = object_samples(item)
    assert len(samples) == 2
    # Less the shared face, from both sides.
    want = tall.area + flat.area - 2.0 * 0.01
    assert sum(s.areas.sum() for s in samples) == pytest.approx(want, rel=0.02)
    for own, other in ((0, 1), (1, 0)):
        outside = samples[own].points + INNER * samples[own].normals
        assert item.pieces[other].depth(outside).max() == 0.0

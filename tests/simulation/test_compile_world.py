"""Compiled worlds: complete, the same bytes each time, written whole or not at all."""

from __future__ import annotations

import ast

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import _native
from halfphysics.errors import FileError, InputError
from halfphysics.simulation import compile_world as compile_world_module
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.call_recorder import CALLS, Call, CallRecorder
from halfphysics.simulation.compile_world import MOST_SUBSTEPS, MOST_SWEEPS
from halfphysics.simulation.world_file import world_bytes
from support.paths import ROOT

REST = hp.Pose((0, 0, 1.0), np.zeros((55, 3)))


def scene():
    made = hp.Scene()
    made.add_static("floor", hp.Plane())
    made.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(1, 0, 0.101))
    return made


def test_the_same_input_gives_the_same_bytes(tmp_path):
    sim = hp.Simulator(scene())
    sim.save_world(tmp_path / "world.hpw")
    data = hp.compile_world(scene())
    assert data == hp.compile_world(scene(), body=hp.Body.default(), settings=hp.Settings())
    assert (tmp_path / "world.hpw").read_bytes() == data


def test_a_simulator_goes_on_as_if_it_had_not_been_saved(tmp_path):
    saved, other = hp.Simulator(scene()), hp.Simulator(scene())
    for sim in (saved, other):
        sim.reset(REST)
        sim.step(REST)
    saved.save_world(tmp_path / "world.hpw")
    assert np.array_equal(saved.step(REST).objects["ball"][0], other.step(REST).objects["ball"][0])
    assert saved.get_state().numbers == other.get_state().numbers


def test_objects_added_later_are_in_it(tmp_path):
    sim = hp.Simulator(scene())
    sim.add_object("box", hp.Box((0.1, 0.1, 0.1)), mass=1.0, position=(2, 0, 0.2))
    sim.save_world(tmp_path / "world.hpw")
    assert b"box\0" in (tmp_path / "world.hpw").read_bytes()


def test_soft_things_are_in_it():
    soft = scene()
    soft.add_static("bed", hp.Box((1, 1, 0.4)), soft="mattress", position=(1, 0, -0.1))
    soft.add_object(
        "pillow", hp.Box((0.4, 0.3, 0.15)), mass=1.0, position=(1, 2, 0.3), soft="pillow"
    )
    other = hp.Simulator(soft, body=[])
    other.reset([])
    for _ in range(20):
        frame = other.step([])
    assert len(frame.soft_contacts) > 0
    data = hp.compile_world(soft, body=[])
    assert np.array_equal(_native.run_world(data, 20), other.world.stepper.qpos())


def test_every_call_that_builds_a_core_is_known():
    """A call that simulation/ makes of a core and that no file could have would fail here."""
    used = set()
    for name in (
        "build_world",
        "collision_shapes",
        "core_settings",
        "pairing",
        "person_shapes",
        "self_contact",
        "soft_shapes",
    ):
        path = ROOT / "src" / "halfphysics" / "simulation" / f"{name}.py"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "core":
                used.add(node.attr)
    assert used == {*CALLS, "add_skin_shapes", "add_mesh", "pair_gaps"}


def test_a_call_that_files_do_not_have_is_noticed():
    with pytest.raises(AttributeError, match="has no place in world files"):
        CallRecorder(_native.Stepper(), hp.Scene()).set_moon(1)


def test_mistakes(tmp_path):
    with pytest.raises(InputError, match="runs in Python only"):
        hp.compile_world(scene(), settings=hp.baselines.EngineKinematic())
    with pytest.raises(InputError, match="expected a halfphysics"):
        hp.compile_world("room")
    with pytest.raises(FileError, match="does not exist"):
        hp.Simulator(scene()).save_world(tmp_path / "none" / "world.hpw")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("what", "most"), [("substeps", MOST_SUBSTEPS), ("max_sweeps", MOST_SWEEPS)]
)
def test_what_a_reader_would_wait_for_too_long_is_not_written(what, most):
    """The bounds of the reader: a file at the bound is read, one over it is not written."""
    data = hp.compile_world(body=[], settings=hp.Settings(**{what: most}))
    assert np.isfinite(_native.run_world(data, 1)).all()
    with pytest.raises(InputError, match=f"{what}={most + 1}, expected at most"):
        hp.compile_world(body=[], settings=hp.Settings(**{what: most + 1}))


@pytest.mark.parametrize(
    "given",
    ["root_speed", "recovery_rate", "clearance_range", "depenetration_speed", "drive_time"],
)
def test_whole_numbers_are_as_good_as_others(given):
    whole, real = (hp.compile_world(scene(), settings=hp.Settings(**{given: n})) for n in (1, 1.0))
    assert whole == real
    _native.run_world(whole, 2)


def test_feet_of_nobody_are_refused():
    """A file from a stranger: a footing without legs, or with another person's."""
    at = np.eye(3)
    recorder = CallRecorder(_native.Stepper(), scene())
    world = build_world(
        [hp.Body.default()] * 2, scene(), hp.Settings(contact="parts"), {}, core=recorder
    )
    compile_world_module._label(recorder, world, [at] * 2)
    calls = list(recorder.calls)
    _native.run_world(world_bytes(calls), 2)
    feet = [call for call in calls if call.name == "set_footing"]
    none = {"joints": np.zeros((0, 3), np.int32), "soles": np.zeros(0, np.int32)}
    for changes in (none, {"joints": feet[1].arguments["joints"]}):
        forged = [Call(c.name, {**c.arguments, **changes}) if c is feet[0] else c for c in calls]
        with pytest.raises(ValueError, match="set_footing"):
            _native.run_world(world_bytes(forged), 2)

"""What clients may bring into a scene."""

from __future__ import annotations

import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.live import bounds, schema
from halfphysics.live.session import Session


def add(name="new", shape="box:0.2:0.2:0.2", mass=1.0, position=(5.0, 5.0, 1.0), **options):
    return schema.Add(name, shape, mass, position, **options)


def state(session):
    world = session.simulator.world
    return world.stepper.qpos().tolist(), world.stepper.qvel().tolist(), list(world.scene.objects)


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (add(shape="sphere:1e15"), "extent of the shape"),
        (add(shape="box:0.2:0.2:20.1"), "0.001 to 20"),
        (add(shape="sphere:0.0004"), "extent of the shape"),
        (add(shape="box:0.0009:1:1"), "extent of the shape"),
        (add(shape="capsule:1:18.5"), "found 20.5"),
        (add(shape="cylinder:10.1:1"), "found 20.2"),
        (add(mass=1e15), "add: mass"),
        (add(mass=0.0009), "0.001 to 10000"),
        (add(mass=float("nan")), "add: mass"),
        (add(position=(0.0, 101.0, 1.0)), "add: position"),
        (add(velocity=(80.0, 80.0, 0.0)), "add: velocity"),
        (add(velocity=(1e200, 1e200, 0.0)), "add: velocity"),
        (add(friction=1e9), "add: friction"),
        (schema.Mass("ball", 10_001.0), "mass of 'ball'"),
        (schema.Friction("floor", 11.0), "friction of 'floor'"),
        (schema.Drag("ball", (0.0, 0.0, 500.0)), "drag: position"),
        (schema.Drag("ball", (0.0, 0.0, 1.0), (500.0, 0.0, 0.0)), "drag: position"),
        (schema.Impulse("ball", (101.0, 0.0, 0.0)), "speed of 'ball'"),
        (schema.Impulse("ball", (1e300, 0.0, 0.0)), "impulse"),
        (schema.Impulse("ball", (50.0, 0.0, 0.0), (1.0, 90.0, 0.1)), "spin of 'ball'"),
    ],
)
def test_what_is_out_of_bounds_is_refused_and_changes_nothing(session, action, said):
    before = state(session)
    with pytest.raises(InputError, match=said):
        session._editor.do(action, "a")
    assert state(session) == before


@pytest.mark.parametrize(
    "action",
    [
        add(shape="sphere:0.0005", mass=0.001),
        add(shape="box:20:20:20", mass=10_000.0, position=(90.0, 0.0, 10.0)),
        add(position=(-100.0, 100.0, 100.0), velocity=(0.0, 100.0, 0.0)),
        schema.Mass("ball", 10_000.0),
        schema.Impulse("ball", (99.0, 0.0, 0.0)),
    ],
)
def test_what_is_at_the_bounds_is_simulated(session, action):
    session._editor.do(action, "a")
    session.step()
    assert np.isfinite(session.simulator.world.stepper.qpos()).all()


@pytest.mark.parametrize(
    ("position", "inside"),
    [
        ((1.0, 1.0, 0.25), "ball"),
        ((2.0, 1.5, 1.0), "wall"),
        ((0.0, 3.0, 0.05), "floor"),
        ((0.0, 0.0, 1.0), "person0"),
    ],
)
def test_what_overlaps_something_is_refused(session, position, inside):
    before = state(session)
    with pytest.raises(InputError, match=f"inside {inside}, expected"):
        session._editor.do(add(position=position), "a")
    assert state(session) == before


def test_what_only_touches_is_added(session):
    """On the floor, beside the wall, and on each other."""
    for k, position in enumerate([(1.8, 1.8, 0.1), (1.8, 1.8, 0.3), (1.8, 1.8, 0.5)]):
        session._editor.do(add(f"box{k}", position=position), "a")
    frame = session.step()
    assert frame.objects["box2"][0][2] == pytest.approx(0.5, abs=0.005)


def test_overlaps_are_those_of_now(session):
    """Where the ball was when the session began there is room, once it has been dragged away."""
    session._editor.do(schema.Drag("ball", (1.0, 1.0, 0.1)), "a")
    for k in range(60):
        session._editor.do(schema.Drag("ball", (1.0, 1.0 + 0.02 * k, 0.2)), "a")
        session.step()
    session._editor.do(add(position=(1.0, 1.0, 0.1)), "a")
    with pytest.raises(InputError, match="inside ball"):
        session._editor.do(add("other", position=tuple(session.newest.objects["ball"][0])), "a")


def test_a_client_does_not_stop_the_session_by_overlapping_boxes(scene):
    """60 boxes in one place took 0.8 s a step; one is added, and a step takes milliseconds."""
    session = Session(scene, body=[hp.Body.default()])
    answers = []
    for k in range(60):
        place = (3.0 + 0.02 * (k % 8), 0.02 * (k // 8), 0.5)
        session.edit(add(f"box{k}", position=place), answers.append)
    for _ in range(8):
        session.step()
    assert len(answers) == 60
    assert sum(answer is None for answer in answers) == 1
    begun = time.process_time()
    for _ in range(10):
        session.step()
    assert time.process_time() - begun < 10 * 0.1


def test_what_clients_added_is_counted(session):
    for k in range(bounds.MOST_ADDED):
        session._editor.do(add(f"box{k}", position=(5.0 + 0.5 * (k % 8), 0.5 * (k // 8), 1.0)), "a")
    with pytest.raises(InputError, match="40 objects that clients added"):
        session._editor.do(add("more", position=(5.0, -5.0, 1.0)), "another")
    session._editor.do(schema.Remove("ball"), "a")  # the scene's own
    with pytest.raises(InputError, match="40 objects that clients added"):
        session._editor.do(add("more", position=(5.0, -5.0, 1.0)), "a")
    session._editor.do(schema.Remove("box7"), "a")
    session._editor.do(add("more", position=(5.0, -5.0, 1.0)), "a")


def test_clients_are_told():
    said = schema.hello(server="s", fps=90.0, people=[], statics=[], objects=[], clock=0.0).limits
    assert said.items() >= bounds.LIMITS.items()
    assert (said["object_size"], said["object_mass"], said["object_position"]) == (20.0, 1e4, 100.0)

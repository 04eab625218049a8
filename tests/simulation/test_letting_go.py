"""Released objects; states of holds, and invalid calls."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.held import (
    HAND,
    PARTS,
    SHOULDER,
    STICK,
    corners,
    holding,
    in_front,
    pointing,
    same,
)

DOOR = """
<mujoco><worldbody><body name="leaf"><joint type="hinge" axis="0 0 1"/>
<geom type="box" size="0.4 0.02 1" mass="20"/></body></worldbody></mujoco>
"""


@pytest.fixture(scope="module")
def body():
    return Body.default()


# -- let go --------------------------------------------------------------------------------


def test_let_go_it_flies_on_as_a_free_body(body):
    """With the material velocity of the part: as an object that starts so by itself, to 1e-9 m."""
    swing = 0.6 * np.sin(np.arange(20) * 0.5)
    motion = pointing(20, swing=swing)
    options = {"mass": 0.7, "com": (0.1, 0.02, 0.0), "out": 0.6}
    simulator = holding(body, motion, **options)
    for t in range(1, 12):
        frame = simulator.step(motion[t])
    position, quat = frame.objects["stick"]
    # The shoulder turns at one rate within a frame.
    v, w = simulator.velocity("stick")
    x = body.joints(frame.pose)[SHOULDER]
    rate = (swing[11] - swing[10]) * 30
    np.testing.assert_allclose(w, [0, 0, rate], atol=1e-9)
    np.testing.assert_allclose(v, np.cross(w, position - x), atol=1e-9)
    simulator.release("stick")
    np.testing.assert_allclose(simulator.velocity("stick"), (v, w), atol=1e-12)
    alone = Scene()
    alone.add_object(
        "stick",
        STICK,
        mass=0.7,
        com=(0.1, 0.02, 0.0),
        position=position,
        quaternion=quat,
        velocity=v,
        angular_velocity=w,
    )
    free = Simulator(alone, body=[])
    free.reset([])
    for _ in range(12, 20):
        x, y = simulator.step(motion[11]), free.step([])
        np.testing.assert_allclose(x.objects["stick"][0], y.objects["stick"][0], atol=1e-9)
        np.testing.assert_allclose(x.objects["stick"][1], y.objects["stick"][1], atol=1e-9)
    assert dict(simulator.held) == {}


@pytest.mark.parametrize("contact", ["parts", "skin"])
def test_let_go_in_the_hand_it_comes_out_gently(body, contact):
    """A ball through the palm: its depth never increases, it does not jump, and it ends outside."""
    motion = pointing(40)
    scene = Scene(gravity=0.0)
    scene.add_object(
        "ball", Sphere(0.05), mass=0.3, position=body.joints(motion[0])[HAND] + [0.08, 0.0, 0.0]
    )
    simulator = Simulator(scene, body=body, settings=as_it_is(contact=contact))
    simulator.reset(motion[0])
    simulator.attach("ball")
    for t in range(1, 5):
        frame = simulator.step(motion[t])
        assert len(frame.inside.person) == 0
    before, joints = frame.objects["ball"][0], body.joints(frame.pose)
    simulator.release("ball")
    depth = np.inf
    for t in range(5, 40):
        frame = simulator.step(motion[t])
        inside = frame.inside.depth.max(initial=0.0)
        assert inside <= depth + 1e-6
        depth = inside
        moved = np.linalg.norm(frame.objects["ball"][0] - before)
        assert moved < 0.85 / 30  # the person is not thrown
        assert np.abs(body.joints(frame.pose) - joints).max() < 0.85 / 30
        before, joints = frame.objects["ball"][0], body.joints(frame.pose)
    assert depth == 0.0


def test_let_go_against_a_wall_it_stays_out(body):
    """Pressed to a wall, then released: it falls along it."""
    path = np.zeros((60, 3))
    path[:, 0] = np.minimum(1.0 * np.arange(60) / 30, 0.6)
    motion = pointing(path=path)
    scene = Scene()
    tip = body.joints(motion[0])[HAND, 0] + 0.55 + 0.3
    scene.add_static("wall", Box((1, 8, 8)), position=(tip + 0.3 + 0.5, 0, 0))
    scene.add_static("floor", Plane(offset=-1.5))
    settings = as_it_is(contact="parts", record="substeps")
    simulator = holding(body, motion, scene=scene, settings=settings)
    for t in range(1, 60):
        if t == 30:
            simulator.release("stick")
        frame = simulator.step(motion[t])
        place = simulator.world.objects[0]
        for q in frame.substeps:
            points = corners(STICK.size, place.pose(q))
            assert points[:, 0].max() < tip + 0.3
            assert points[:, 2].min() > -1.5
    assert points[:, 2].max() < -1.0


# -- states, and added and removed objects -------------------------------------------------


def states(body):
    """A run with a wall, other objects, two holds and a release; frames, states."""
    path = np.zeros((36, 3))
    path[:, 0] = 1.2 * np.arange(36) / 30
    motion = pointing(path=path, swing=0.2 * np.sin(np.arange(36) * 0.5))
    scene = Scene()
    tip = body.joints(motion[0])[HAND, 0] + 0.55 + 0.3
    scene.add_static("wall", Box((1, 8, 8)), position=(tip + 0.2 + 0.5, 0, 0))
    scene.add_object("ball", Sphere(0.1), mass=0.5, position=(tip + 0.05, -0.5, 0.3))
    scene.add_object(
        "cube", Box((0.1, 0.1, 0.1)), mass=0.5, position=(0.0, 1.2, 0.4), start="asleep"
    )
    scene.add_object("stick", STICK, **in_front(body, motion[0]))
    settings = as_it_is(contact="parts", strength="human", stiffness={"hands": 0.5})
    simulator = Simulator(scene, body=body, settings=settings)
    simulator.reset(motion[0])
    kept, frames = [], []
    for t in range(1, 36):
        if t == 4:
            simulator.attach("stick")
        if t == 12:
            simulator.attach("cube", "left_wrist")
        if t == 20:
            simulator.set_stiffness({"right_wrist": 0.2})
        if t == 24:
            simulator.release("stick")
        kept.append(simulator.get_state())
        frames.append(simulator.step(motion[t]))
    return simulator, motion, kept, frames


def test_a_state_says_who_holds_what_and_goes_on_bit_by_bit(body):
    simulator, motion, kept, frames = states(body)
    assert max(len(f.contacts.part) for f in frames) > 0
    assert dict(simulator.held) == {"cube": (0, "left_wrist")}
    other = Simulator(simulator.world.scene, body=body, settings=simulator.settings)
    for t in (14, 2, 30, 8, 22):
        for one in (simulator, other):
            one.set_state(kept[t])
            expected = {"stick"} if 3 <= t < 11 else {"stick", "cube"} if t < 23 else {"cube"}
            assert set(one.held) == (expected if t >= 3 else set())
            # Until a person takes or releases an object.
            for k in range(t, min(t + 8, next((c for c in (3, 11, 19, 23) if c > t), 35))):
                same(one.step(motion[k + 1]), frames[k])


def test_twice_the_same(body):
    for a, b in zip(states(body)[3], states(body)[3], strict=True):
        same(a, b)


def test_a_reset_lets_go(body):
    motion = pointing(10)
    simulator = holding(body, motion)
    simulator.step(motion[1])
    first = simulator.reset(motion[0])
    assert dict(simulator.held) == {}
    fresh = Simulator(simulator.world.scene, body=body, settings=PARTS)
    same(first, fresh.reset(motion[0]))
    for t in range(1, 10):
        same(simulator.step(motion[t]), fresh.step(motion[t]))


def test_things_come_and_go_while_something_is_held(body):
    motion = pointing(20, swing=0.2 * np.sin(np.arange(20) * 0.4))
    simulator, alone = holding(body, motion, mass=2.0), holding(body, motion, mass=2.0)
    for t in range(1, 20):
        if t == 6:
            simulator.add_object("lamp", Sphere(0.1), mass=1.0, position=(0, 30, 0))
        if t == 12:
            simulator.remove_object("lamp")
        a, b = simulator.step(motion[t]), alone.step(motion[t])
        np.testing.assert_allclose(a.objects["stick"][0], b.objects["stick"][0], atol=1e-12)
        np.testing.assert_allclose(a.torque, b.torque, atol=1e-9)
    simulator.remove_object("stick")
    assert dict(simulator.held) == {}
    frame = simulator.step(motion[0])
    assert frame.objects == {}
    simulator.add_object("stick", STICK, **in_front(body, motion[0]))
    assert dict(simulator.held) == {}


def test_what_sleeps_or_lies_somewhere_is_picked_up(body):
    path = np.zeros((30, 3))
    path[:, 2] = np.maximum(0.0, np.arange(30) - 5) / 30
    motion = pointing(path=path)
    at = body.joints(motion[0])[HAND] + [0.5, 0.0, 0.0]
    scene = Scene()
    scene.add_static("table", Box((0.4, 0.4, 0.1)), position=at - [0.0, 0.0, 0.1])
    scene.add_object("box", Box((0.1, 0.1, 0.1)), mass=1.0, position=at, start="asleep")
    scene.add_object("lid", Box((0.1, 0.1, 0.02)), mass=0.2, position=at + np.array([0, 0, 0.06]))
    simulator = Simulator(scene, body=body, settings=PARTS)
    simulator.reset(motion[0])
    for t in range(1, 5):
        simulator.step(motion[t])
    simulator.attach("box")
    for t in range(5, 30):
        frame = simulator.step(motion[t])
    np.testing.assert_allclose(frame.objects["box"][0], at + path[-1], atol=1e-3)
    np.testing.assert_allclose(
        frame.objects["lid"][0] - frame.objects["box"][0], [0, 0, 0.06], atol=3e-3
    )
    names = {simulator.names[k] for k in frame.contacts.subject} | {
        simulator.names[k] for k in frame.contacts.other
    }
    assert names == {"box", "lid"}


def test_a_ray_and_a_velocity_find_it(body):
    motion = pointing(10)
    simulator = holding(body, motion)
    frame = simulator.step(motion[1])
    at = frame.objects["stick"][0]
    hit = simulator.ray(at + np.array([0.0, 0.0, 1.0]), (0, 0, -1))
    assert hit.name == "stick"
    np.testing.assert_allclose(simulator.velocity("stick"), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("do", "says"),
    [
        (lambda s: s.attach("stik"), "attach: there is no object called 'stik'; did you mean"),
        (lambda s: s.attach("wall"), "no object called 'wall'"),
        (lambda s: s.attach("stick", "hand"), "part: found 'hand', expected a joint's name"),
        (lambda s: s.attach("stick", "right_writs"), "did you mean 'right_wrist'"),
        (lambda s: s.attach("stick", "right_hand"), "did you mean 'right_wrist'"),
        (lambda s: s.attach("stick", 3), "part: found 3"),
        (lambda s: s.attach("stick", person=1), "person: found 1, expected 0 to 0"),
        (lambda s: s.attach("stick", person=-1), "person: found -1"),
        (lambda s: s.attach("stick", person=True), "person: found True"),
        (lambda s: s.attach("stick", person="me"), "person: found 'me'"),
        (lambda s: s.attach("cup"), "the left_wrist of 'person' holds it already"),
        (lambda s: s.attach("lift"), "moves along its trajectory"),
        (lambda s: s.attach("door"), "'door' is articulated"),
        (lambda s: s.attach("door/leaf"), "'door/leaf' is articulated"),
        (lambda s: s.release("stick"), "'stick' is not held. Held: cup"),
        (lambda s: s.release("cu"), "release: there is no object called 'cu'"),
        (lambda s: s.release(["cup"]), r"release: there is no object called \['cup'\]"),
        (lambda s: s.attach(["cup"]), r"attach: there is no object called \['cup'\]"),
        (lambda s: s.release("door"), "'door' is articulated"),
        (lambda s: s.apply_impulse("cup", (0, 0, 1)), "left_wrist of 'person' holds 'cup'"),
        (lambda s: s.set_velocity("cup", (0, 0, 1)), "release\\('cup'\\) it first"),
    ],
)
def test_what_is_wrong_is_said_and_changes_nothing(body, do, says):
    motion = pointing(2)
    scene = Scene()
    scene.add_static("wall", Box((1, 1, 1)), position=(9, 0, 0))
    scene.add_object("stick", STICK, **in_front(body, motion[0]))
    scene.add_object("cup", Sphere(0.05), mass=0.3, position=(0, 2, 0))
    scene.add_moving("lift", Box((1, 1, 1)), [[9, 9, 9]], fps=30)
    scene.add_articulated("door", DOOR, position=(0, -9, 0))
    simulator = Simulator(scene, body=body, settings=PARTS)
    with pytest.raises(InputError, match="reset"):
        simulator.attach("stick")
    with pytest.raises(InputError, match="reset"):
        simulator.release("stick")
    simulator.reset(motion[0])
    simulator.attach("cup", "left_wrist")
    held, state = dict(simulator.held), simulator.get_state()
    with pytest.raises(InputError, match=says):
        do(simulator)
    assert dict(simulator.held) == held
    assert simulator.get_state().numbers == state.numbers
    empty = Simulator(scene, body=[])
    empty.reset([])
    with pytest.raises(InputError, match="there are no people"):
        empty.attach("stick")

"""Objects alone: closed forms of free flight, rest, sliding, bouncing, colliding, spinning."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import rotations as rot
from halfphysics.scene import Scene
from halfphysics.settings import Settings
from halfphysics.shapes import Box, Cylinder, Plane, Sphere
from halfphysics.simulator import Simulator

G = 9.81


def run(scene, seconds, fps=30.0, settings=None):
    """Positions and quaternions per frame, by name."""
    simulator = Simulator(scene, body=[], settings=settings, fps=fps)
    frames = [simulator.reset([])]
    frames += [simulator.step([]) for _ in range(round(seconds * fps))]
    return {
        name: (
            np.array([f.objects[name][0] for f in frames]),
            np.array([f.objects[name][1] for f in frames]),
        )
        for name in scene.objects
    }, frames


def test_free_fall_is_exact_up_to_the_integrator():
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0, 0, 10), velocity=(1, 2, 3))
    tracks, _ = run(scene, 1.0)
    t, h = np.arange(31) / 30.0, 1.0 / 240.0
    x = tracks["ball"][0]
    # Symplectic Euler falls g t (t + h) / 2: first order, and exactly that.
    np.testing.assert_allclose(x[:, 2], 10 + 3 * t - 0.5 * G * t * (t + h), atol=1e-12)
    np.testing.assert_allclose(x[:, :2], np.outer(t, [1, 2]), atol=1e-12)


@pytest.mark.parametrize("shape", [Sphere(0.11), Box((0.2, 0.3, 0.22)), Cylinder(0.1, 0.22)])
def test_what_rests_on_the_floor_does_not_move(shape):
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("thing", shape, mass=0.43, position=(0.3, 0.2, 0.11))
    tracks, frames = run(scene, 5.0)
    position, quaternion = tracks["thing"]
    # One point of contact is solved exactly; on four redundant ones friction creeps by its share
    # of the solver's tolerance.
    still = 1e-9 if isinstance(shape, Sphere) else 1e-6
    assert np.abs(position - position[0]).max() < still
    assert np.abs(quaternion - quaternion[0]).max() < still
    # The floor carries the weight: impulse over a frame = m g dt.
    total = frames[-1].contacts.impulse.sum(axis=0)
    np.testing.assert_allclose(total, [0, 0, 0.43 * G / 30], atol=1e-5)  # m tolerance / h: 1e-4


@pytest.mark.parametrize("on", ["plane", "box", "mesh"])
def test_rest_on_every_kind_of_static(on):
    scene = Scene()
    if on == "plane":
        scene.add_static("floor", Plane())
    elif on == "box":
        scene.add_static("floor", Box((2, 2, 0.1)), position=(0, 0, -0.05))
    else:
        import trimesh

        scene.add_static("floor", trimesh.creation.box((2, 2, 0.1)), position=(0, 0, -0.05))
    scene.add_object("box", Box((0.2, 0.3, 0.22)), mass=2.0, position=(0.3, 0.2, 0.11))
    tracks, _ = run(scene, 3.0)
    position, _ = tracks["box"]
    assert np.abs(position - position[0]).max() < 1e-6  # the solver's tolerance


@pytest.mark.parametrize(("angle", "slides"), [(0.99, False), (1.01, True)])
def test_the_friction_angle(angle, slides):
    """A block on an incline at 0.99 and 1.01 of the friction angle."""
    mu = 0.5
    tilt = np.arctan(mu) * angle
    turn = rot.exp([0.0, tilt, 0.0])
    scene = Scene()
    scene.add_static("slope", Plane(), quaternion=turn, friction=1.0)
    scene.add_object(
        "block",
        Box((0.2, 0.2, 0.1)),
        mass=1.0,
        friction=mu,
        position=rot.rotate(turn, [0, 0, 0.05]),
        quaternion=turn,
    )
    tracks, _ = run(scene, 2.0)
    way = np.linalg.norm(tracks["block"][0][-1] - tracks["block"][0][0])
    expected = 0.5 * G * (np.sin(tilt) - mu * np.cos(tilt)) * 4.0
    if slides:
        assert way == pytest.approx(expected, rel=0.02)
    else:
        assert way < 5e-4  # the solver may leave 1 micrometre a substep, 480 of them


def test_sliding_distance_on_the_floor():
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object(
        "block",
        Box((0.3, 0.3, 0.1)),
        mass=2.0,
        friction=0.4,
        position=(0, 0, 0.05),
        velocity=(2, 0, 0),
    )
    tracks, _ = run(scene, 2.0)
    assert tracks["block"][0][-1, 0] == pytest.approx(2.0**2 / (2 * 0.4 * G), rel=0.02)


def test_a_sliding_ball_ends_rolling():
    """v = 5/7 of its start once it rolls without slip."""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object(
        "ball", Sphere(0.1), mass=1.0, friction=0.5, position=(0, 0, 0.1), velocity=(3, 0, 0)
    )
    tracks, _ = run(scene, 2.0)
    x = tracks["ball"][0][:, 0]
    assert (x[-1] - x[-2]) * 30 == pytest.approx(3.0 * 5 / 7, rel=0.02)


def test_bounce_height():
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("ball", Sphere(0.1), mass=1.0, restitution=0.5, position=(0, 0, 1.1))
    tracks, _ = run(scene, 0.85, fps=240.0)
    z = tracks["ball"][0][:, 2] - 0.1
    landed = int(np.argmax(np.diff(z) > 0.0)) + 1
    # Height falls by e^2; the bounce starts up to one substep's way (18 mm) above the floor.
    assert z[landed:].max() == pytest.approx(0.25, abs=0.02)


def test_two_balls_exchange_momentum():
    scene = Scene(gravity=0.0)
    scene.add_object("a", Sphere(0.1), mass=1.0, position=(0, 0, 0), velocity=(2, 0, 0))
    scene.add_object("b", Sphere(0.1), mass=3.0, position=(0.5, 0, 0))
    tracks, _ = run(scene, 1.0)
    speed = {n: (x[-1] - x[-2]) * 30 for n, (x, _) in tracks.items()}
    momentum = speed["a"] + 3.0 * speed["b"]
    np.testing.assert_allclose(momentum, [2, 0, 0], atol=1e-9)
    # e = 0: they go on together.
    np.testing.assert_allclose(speed["a"], speed["b"], atol=1e-3)


def test_a_spinning_asymmetric_body_keeps_energy_and_angular_momentum():
    """30 rad/s near the unstable axis for 10 s, no force on it."""
    scene = Scene(gravity=0.0)
    scene.add_object(
        "t", Box((0.1, 0.2, 0.4)), mass=1.0, position=(0, 0, 0), angular_velocity=(0.5, 30.0, 0.3)
    )
    simulator = Simulator(scene, body=[], fps=30)
    simulator.reset([])
    inertia = np.array(scene.objects["t"].inertia)

    def energy_and_momentum():
        turn = rot.to_matrix(simulator.world.stepper.qpos()[3:7])
        w = simulator.world.stepper.qvel()[3:6]
        return 0.5 * w @ inertia @ w, turn @ inertia @ w

    e0, l0 = energy_and_momentum()
    tumbled = 0.0
    for _ in range(300):
        simulator.step([])
        e, l = energy_and_momentum()
        assert e == pytest.approx(e0, rel=0.01)
        assert np.linalg.norm(l - l0) <= 0.01 * np.linalg.norm(l0)
        tumbled = max(tumbled, abs(simulator.world.stepper.qvel()[3]))
    assert tumbled > 3.0  # it did leave the axis: the case is not the easy one


def test_a_fast_ball_does_not_pass_a_thin_wall():
    for speed in (5.0, 20.0, 60.0):
        scene = Scene(gravity=0.0)
        scene.add_static("wall", Box((0.01, 2, 2)), position=(1, 0, 0))
        scene.add_object(
            "ball", Sphere(0.05), mass=1.0, position=(0, 0, 0), velocity=(speed, 0.3, 0)
        )
        tracks, _ = run(scene, 1.0)
        x = tracks["ball"][0][:, 0]
        assert x.max() <= 0.995 - 0.05
        assert x[-1] > 0.9


def test_a_stack_stands():
    scene = Scene()
    scene.add_static("floor", Plane())
    for i in range(3):
        scene.add_object(f"box{i}", Box((0.3, 0.3, 0.2)), mass=1.0, position=(0, 0, 0.1 + 0.2 * i))
    tracks, _ = run(scene, 3.0)
    for position, _ in tracks.values():
        assert np.abs(position - position[0]).max() < 1e-3


def test_what_touches_at_the_start_is_not_lifted_by_the_clearance():
    """A ball set down half a millimetre above the floor keeps its own distance."""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0, 0, 0.1005))
    tracks, _ = run(scene, 2.0)
    np.testing.assert_allclose(tracks["ball"][0][:, 2], 0.1005, atol=1e-9)


def test_two_runs_are_equal_to_the_last_bit():
    def once():
        scene = Scene()
        scene.add_static("floor", Plane())
        for i in range(4):
            scene.add_object(
                f"b{i}",
                Box((0.1, 0.2, 0.3)),
                mass=1.0,
                position=(0.05 * i, 0.02 * i, 0.3 + 0.4 * i),
            )
        tracks, _ = run(scene, 2.0)
        return b"".join(x.tobytes() + q.tobytes() for x, q in tracks.values())

    assert once() == once()


def test_a_state_resumes_bit_for_bit():
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object(
        "box", Box((0.1, 0.2, 0.3)), mass=1.0, position=(0, 0, 0.4), velocity=(1, 0, 0)
    )
    a = Simulator(scene, body=[], settings=Settings(), fps=30)
    a.reset([])
    for _ in range(10):
        a.step([])
    state = a.get_state()
    ahead = [a.step([]).objects["box"] for _ in range(10)]
    b = Simulator(scene, body=[], settings=Settings(), fps=30)
    b.set_state(state)
    for expected in ahead:
        got = b.step([]).objects["box"]
        assert got[0].tobytes() == expected[0].tobytes()
        assert got[1].tobytes() == expected[1].tobytes()


def test_an_elastic_thing_gains_no_energy():
    """A tumbling hull that bounces with e = 1, without friction: on a floor and off a wall."""
    import trimesh

    for seed in range(6):
        rng = np.random.default_rng(seed)
        scene = Scene()
        scene.add_static("floor", Plane(), restitution=1.0)
        hull = trimesh.convex.convex_hull(0.1 * rng.normal(size=(12, 3)))
        scene.add_object(
            "thing",
            hull,
            mass=1.0,
            friction=0.0,
            restitution=1.0,
            position=(0.0, 0.0, 1.0),
            velocity=(0.0, 0.0, -4.0),
            angular_velocity=10.0 * rng.normal(size=3),
        )
        simulator = Simulator(scene, body=[], fps=60)
        simulator.reset([])
        stepper, inertia = simulator.world.stepper, np.array(scene.objects["thing"].inertia)
        energy = []
        for _ in range(60):
            v = stepper.qvel()
            energy.append(
                0.5 * v[:3] @ v[:3] + 0.5 * v[3:] @ inertia @ v[3:] + G * stepper.qpos()[2]
            )
            simulator.step([])
        # Free flight alone drifts by g h v / 2 of the integrator; 2 g h v came with every bounce.
        assert max(energy) <= energy[0] * 1.01


def test_a_person_inside_a_box_does_not_stop_the_clock():
    """Hundreds of contacts that cannot be met: the work of a frame is bounded, nothing flies."""
    from people import t_pose

    from halfphysics.body import Body

    body = Body.default()
    scene = Scene()
    scene.add_static("box", Box((3, 3, 3)), position=(0, 0, 1))
    pose = t_pose(np.zeros((2, 3)))[0]
    simulator = Simulator(scene, body=body)
    simulator.reset(pose)
    frame = simulator.step(pose)
    assert frame.diagnostics["contacts"] <= 300
    assert np.abs(simulator.world.stepper.qvel()).max() < 100.0


def test_a_thing_may_have_any_name():
    scene = Scene()
    scene.add_object("world", Sphere(0.1), mass=1.0, position=(0, 0, 1))
    tracks, _ = run(scene, 0.1)
    assert tracks["world"][0][-1, 2] < 1.0

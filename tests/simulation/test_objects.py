"""Objects alone: rest, thin walls, repeatable runs; closed forms are in test_closed_forms.py."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator

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


@pytest.mark.parametrize("shape", [Sphere(0.11), Box((0.2, 0.3, 0.22)), Cylinder(0.1, 0.22)])
def test_what_rests_on_the_floor_does_not_move(shape):
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("thing", shape, mass=0.43, position=(0.3, 0.2, 0.11))
    tracks, frames = run(scene, 5.0)
    position, quaternion = tracks["thing"]
    # One contact point is solved exactly; on four redundant ones friction creeps by its share
    # of the solver's tolerance.
    still = 1e-9 if isinstance(shape, Sphere) else 1e-6
    assert np.abs(position - position[0]).max() < still
    assert np.abs(quaternion - quaternion[0]).max() < still
    # The floor carries the weight: impulse over a frame = m g dt.
    total = frames[-1].contacts.impulse.sum(axis=0)
    np.testing.assert_allclose(total, [0, 0, 0.43 * G / 30], atol=1e-5)  # m tolerance / h: 1e-4


@pytest.mark.parametrize(
    ("shape", "high"),
    [
        (Sphere(0.005), 0.005),
        (Sphere(0.02), 0.02),
        (Sphere(0.11), 0.11),
        (Cylinder(0.04, 0.12), 0.04),
        (Capsule(0.04, 0.12), 0.04),
    ],
)
def test_what_is_round_stays_on_a_thing_that_may_move(shape, high):
    """Where the contact lags behind the lowest point, rounding grows to a roll of 0.1 m/s."""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("table", Box((2.0, 2.0, 0.1)), mass=50.0, position=(0, 0, 0.051))
    lying = (np.sqrt(0.5), np.sqrt(0.5), 0, 0)
    scene.add_object("thing", shape, mass=0.3, position=(0, 0, 0.102 + high), quaternion=lying)
    tracks, _ = run(scene, 6.0)
    assert np.abs(tracks["thing"][0][:, :2]).max() < 1e-6


def test_a_ball_that_rolls_on_a_thing_keeps_its_pace():
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("table", Box((2.0, 2.0, 0.1)), mass=50.0, position=(0, 0, 0.051))
    rolls = {"velocity": (0.05, 0, 0), "angular_velocity": (0, 2.5, 0)}
    scene.add_object("ball", Sphere(0.02), mass=0.3, position=(-0.1, 0, 0.122), **rolls)
    tracks, _ = run(scene, 4.0)
    assert np.diff(tracks["ball"][0][:, 0]) * 30.0 == pytest.approx(0.05, rel=0.02)


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
        h, energy = 1.0 / 240.0, []
        for _ in range(60):
            v = stepper.qvel()
            # The invariant of symplectic Euler's free fall: half a substep of gravity off.
            fall = G * stepper.qpos()[2] - 0.5 * G * h * v[2]
            energy.append(0.5 * v[:3] @ v[:3] + 0.5 * v[3:] @ inertia @ v[3:] + fall)
            simulator.step([])
        assert max(energy) <= energy[0] * (1 + 1e-6)
        assert min(energy) >= energy[0] * (1 - 1e-3)


def test_a_person_inside_a_box_does_not_stop_the_clock():
    """Hundreds of contacts without solution: the work per frame is bounded, no body flies off."""
    from halfphysics.body.body import Body
    from support.people import t_pose

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

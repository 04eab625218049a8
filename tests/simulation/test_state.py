"""Runs and states under attack: independence of resumed runs, and states they must refuse."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.judges.person_hulls import CONTACTS
from support.people import along_x, follow, violent

#: One step a frame, Algorithm 1: steps are long, so that many are shortened and split.
COARSE = Settings(drive_time=None, stiffness=1.0, substeps=1)
FRAMES = 50


@pytest.fixture(scope="module")
def body():
    return Body.default()


def crossing():
    """Two people walk into each other and a wall; a resting box aside."""
    there = along_x(1.5, FRAMES, start=-1.0, z=0.95)
    back = there.with_frames(
        there.translation * (-1.0, 1.0, 1.0) + (0.0, 0.25, 0.0), there.rotations
    )
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -0.5))
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.9, 0.0, 0.0))
    scene.add_object("box", Box((0.4, 0.4, 0.4)), mass=5.0, position=(0.0, 0.1, 1.5))
    return [there, back], scene


def beside():
    """A violent motion between a wall and a falling ball: occasional contacts."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -1.3))
    scene.add_static("wall", Box((0.01, 3.0, 3.0)), position=(0.9, 0.0, 0.0))
    scene.add_object("ball", Sphere(0.2), mass=0.4, position=(-0.7, 0.0, 0.3))
    return [violent(FRAMES)], scene


@pytest.mark.parametrize("make", [crossing, beside])
def test_every_state_resumes_on_a_fresh_simulator_bit_for_bit(body, make):
    """The simulator's earlier use has no effect: the whole next state is the same."""
    motions, scene = make()
    people = [body] * len(motions)

    def fresh():
        return Simulator(scene, body=people, settings=COARSE, fps=30.0)

    first = fresh()
    first.reset([m[0] for m in motions])
    states = [first.get_state()]
    for t in range(1, FRAMES):
        first.step([m[t] for m in motions])
        states.append(first.get_state())
    assert all(np.isfinite(np.frombuffer(s.numbers)).all() for s in states)
    for t in range(FRAMES - 1):
        again = fresh()
        again.set_state(states[t])
        assert again.get_state().numbers == states[t].numbers
        again.step([m[t + 1] for m in motions])
        assert again.get_state().numbers == states[t + 1].numbers, f"frame {t + 1}"


def wall(finer):
    import trimesh

    mesh = trimesh.creation.box((0.02, 4.0, 4.0))
    for _ in range(finer):
        mesh = mesh.subdivide()
    scene = Scene()
    scene.add_static("wall", mesh, position=(0.5, 0.0, 0.0))
    return scene


def test_a_state_of_another_scene_is_refused(body):
    """Same names, same coordinates: but its planes refer to triangles that do not exist."""
    motion = along_x(1.5, 30, start=-0.4)
    fine, coarse = (Simulator(wall(n), body=body, settings=as_it_is()) for n in (3, 0))
    fine.reset(motion[0])
    for t in range(1, len(motion)):
        frame = fine.step(motion[t])
    assert len(frame.contacts.part) > 0
    state = fine.get_state()
    with pytest.raises(InputError, match="another simulator"):
        coarse.set_state(state)
    for cut in (0, 8, 4000, len(state.numbers) - 8):
        with pytest.raises(InputError, match="not whole"):
            fine.set_state(dataclasses.replace(state, numbers=state.numbers[:cut]))
    # After the refusal the run continues unchanged; and other settings may continue from it.
    assert fine.get_state().numbers == state.numbers
    stiffer = Simulator(wall(3), body=body, settings=as_it_is(stiffness=10.0))
    stiffer.set_state(state)


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("seed", [5, 6])
def test_without_clearance_nobody_gets_into_a_mesh(body, seed, contact):
    """A vertex inside within the solver's tolerance counts as inside: a mesh would not stop it."""
    pytest.importorskip("coal")
    import trimesh

    from support.judges.clear_judge import Judge

    motion = violent(40, seed=seed)
    x = body.vertices(motion, frames=[0])[0][:, 0].max() + 0.02
    corners = [[x, -3.0, -3.0], [x, 3.0, -3.0], [x, 3.0, 3.0], [x, -3.0, 3.0]]
    scene = Scene()
    scene.add_static("sheet", trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False))
    settings = Settings(contact=contact, clearance=0.0, record="substeps")
    frames, _, simulator = follow(motion, scene, body, settings)
    start = simulator.world.start([motion[0]])[0]
    verdict = Judge(simulator).judge(start, frames[1:])
    assert verdict.clear
    assert 0.0 < verdict.gap < 1e-4

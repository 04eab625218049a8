"""Models joined from trees equal those that MuJoCo compiles whole, to the last bit."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.simulation.compiled_model import (
    armature_of,
    compile_model,
    joint_arrays,
    model_arrays,
)
from halfphysics.simulation.holding import Hold
from halfphysics.simulation.joined_model import join_model, object_inertia
from halfphysics.simulation.names import Names
from halfphysics.simulation.simulator import Simulator

DOOR = """<mujoco><worldbody><body name="frame" pos="1 0 0"><body name="leaf" pos="0 0.4 1">
<joint name="hinge" axis="0 0 2" pos="0 -0.4 0" range="0 90" damping="0.3" stiffness="0.1"
  springref="10"/>
<geom type="box" size="0.02 0.4 1" mass="9"/>
<body name="handle" pos="0.05 0.3 0"><joint name="turn" axis="1 0 0" range="-40 0"/>
<geom type="capsule" size="0.01 0.06" mass="0.2"/></body></body></body>
<body name="ball" pos="2 0 1"><freejoint/><geom size="0.1" mass="1"/></body>
<body name="lamp" pos="2 1 2"><joint type="ball"/><geom size="0.1" mass="1"/></body>
</worldbody></mujoco>"""


def room():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    rng = np.random.default_rng(5)
    for i in range(6):
        quaternion = rng.normal(size=4)
        size = rng.uniform(0.01, 0.4, size=3)
        place = {"position": rng.normal(size=3), "quaternion": quaternion}
        scene.add_object(f"box{i}", hp.Box(size), mass=rng.uniform(1e-3, 50.0), **place)
    scene.add_object("mug", hp.Cylinder(0.04, 0.1), mass=0.3, com=(0.0, 0.01, 0.02))
    scene.add_moving("lift", hp.Box((1.0, 1.0, 0.1)), [(4, 0, 0), (4, 0, 1)], fps=1.0)
    scene.add_articulated("door", DOOR, position=(1.0, 2.0, 0.0), quaternion=(0.8, 0.1, 0.0, 0.5))
    scene.add_articulated("other", DOOR, position=(5.0, 2.0, 0.0), joints={"hinge": 0.3})
    return scene


def same(mine, theirs):
    for arrays in (model_arrays, joint_arrays):
        for name, array in arrays(mine).items():
            assert np.array_equal(array, arrays(theirs)[name]), name
    assert (mine.nq, mine.nv, mine.nbody, mine.njnt) == (
        theirs.nq,
        theirs.nv,
        theirs.nbody,
        theirs.njnt,
    )
    assert [mine.body(i).name for i in range(mine.nbody)] == [
        theirs.body(i).name for i in range(theirs.nbody)
    ]
    assert [mine.joint(i).name for i in range(mine.njnt)] == [
        theirs.joint(i).name for i in range(theirs.njnt)
    ]


@pytest.mark.parametrize("people", [0, 1, 2])
def test_equal_to_the_whole_model(people):
    scene = room()
    bodies = [hp.Body.default(), hp.Body.default(stature=1.9)][:people]
    armature = armature_of(np.linspace(0.1, 3.0, 55))
    names = Names.of(scene, people).people
    given = (bodies, names, scene, {}, armature)
    for _ in range(2):  # the second time from what is kept
        same(join_model(*given), compile_model(*given))


def test_held_objects():
    story = scenarios.load("lift_suitcase")
    simulator = Simulator(story.scene, body=list(story.bodies))
    simulator.reset([motion[0] for motion in story.motions])
    simulator.attach(next(iter(story.scene.objects)), "left_wrist")
    same(simulator.world.joined, simulator.world.model)
    assert isinstance(simulator.world.model, mujoco.MjModel)


@pytest.mark.parametrize("seed", range(4))
def test_any_holds(seed):
    """Several objects, one after the other on one part too, of any person, at any pose."""
    scene, rng = room(), np.random.default_rng(seed)
    bodies = [hp.Body.default(), hp.Body.default(stature=1.9)]
    held = {}
    for name in ("box1", "box3", "box4", "mug"):
        quaternion = rot.normalize(rng.normal(size=4))
        place = tuple(map(float, rng.normal(size=3)))
        joint = int(rng.choice([0, 15, 20, 21, 54]))
        held[name] = Hold(int(rng.integers(2)), joint, place, tuple(map(float, quaternion)))
    given = (bodies, Names.of(scene, 2).people, scene, held, armature_of(np.ones(55)))
    same(join_model(*given), compile_model(*given))


def test_a_name_that_is_not_there():
    model = join_model([], (), hp.Scene(), {}, np.zeros(55))
    with pytest.raises(KeyError):
        model.body("nothing")
    with pytest.raises(AttributeError):
        _ = model.geom_size


def test_what_mujoco_refuses_stays_refused():
    flat = np.diag([1e-16, 1e-3, 1e-3])
    with pytest.raises(InputError, match="inertia"):
        object_inertia(1.0, flat.tobytes())
    with pytest.raises(InputError, match="inertia"):
        object_inertia(1.0, np.diag([1.0, 1.0, 3.0]).tobytes())


def test_changes_of_an_articulated_object_are_seen():
    scene = room()
    given = ([], (), scene, {}, np.zeros(55))
    join_model(*given)
    joint = scene.articulated["door"].links[1].joints[0]
    joint.axis.setflags(write=True)  # nobody should, but what is kept must not be stale
    joint.axis[:] = (0.0, 1.0, 0.0)
    same(join_model(*given), compile_model(*given))

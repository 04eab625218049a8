"""What starts inside something: which pairs that are, and that all others stay clear."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Capsule, Mesh, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.people import t_pose

#: Height of the table's top, radius of what lies in it, and how deep [m].
TOP, RADIUS, DEEP = 0.2, 0.1, 0.04
#: Accuracy of depths: exits are found to 0.1 mm, and leave half a millimetre [m].
FOUND = 1e-3
SHAPES = {
    "sphere": Sphere(RADIUS),
    "capsule": Capsule(RADIUS, 0.2),
    "box": Box((0.2, 0.2, 2.0 * RADIUS)),
}


@pytest.fixture(scope="module")
def body():
    return Body.default()


def frames(body, shape, deep):
    """A second of a thing that starts so deep in a table of triangles, its middle above the top."""
    scene = Scene()
    table = Mesh(*Box((0.8, 0.8, TOP)).triangles())
    scene.add_static("table", table, position=(0.0, 0.0, 0.5 * TOP))
    # A capsule lies.
    turn = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0) if isinstance(shape, Capsule) else (1, 0, 0, 0)
    scene.add_object(
        "it", shape, mass=1.0, position=(0.05, 0.02, TOP + RADIUS - deep), quaternion=turn
    )
    motion = t_pose(np.tile([3.0, 3.0, 3.0], (31, 1)), fps=30.0)
    simulator = Simulator(scene, body=body, fps=30.0)
    return simulator, [
        simulator.reset(motion[0]),
        *(simulator.step(motion[t]) for t in range(1, len(motion))),
    ]


@pytest.mark.parametrize("kind", SHAPES)
def test_a_thing_whose_middle_is_outside_the_triangles_is_inside_all_the_same(body, kind):
    """Of a rounded shape the unrounded one may be clear of the mesh: its points, its segment."""
    simulator, run = frames(body, SHAPES[kind], DEEP)
    told = run[0].inside
    assert [simulator.world.names[k] for k in (*told.subject, *told.other)] == ["it", "table"]
    assert told.depth == pytest.approx(DEEP, abs=FOUND)
    depths = [float(f.inside.depth.max(initial=0.0)) for f in run]
    assert (np.diff(depths) <= 1e-9).all()
    assert depths[-1] == 0.0
    height = run[-1].objects["it"][0][2]
    assert height == pytest.approx(TOP + RADIUS, abs=2.0 * simulator.settings.clearance)
    assert not any(len(f.breaches) for f in run)


@pytest.mark.parametrize("kind", SHAPES)
def test_what_touches_is_not_inside(body, kind):
    _, run = frames(body, SHAPES[kind], 0.0)
    assert not any(len(f.inside) for f in run)
    assert run[-1].objects["it"][0][2] == pytest.approx(TOP + RADIUS, abs=1e-4)

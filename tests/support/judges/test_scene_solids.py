"""The judges check collision shapes: pieces of objects and links, not their hulls."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.contact_pieces import joined
from halfphysics.geometry.shapes import Box, Mesh, Sphere
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.judges.coal_scene import Watch
from support.judges.scene_solids import fixed_links, owners, solids_of
from support.judges.skin_judge import SkinJudge
from support.people import t_pose
from support.starts.objects_judge import ObjectJudge
from support.starts.solids import box

#: Accuracy of coal's distances [m].
COAL = 1e-6
TURN = rot.exp([0.3, -0.2, 0.8])
PLACE = np.array([0.3, -0.1, 0.2])

#: A fixed case, 2 cm thick, and a drawer of a bottom and a front on a rail.
CABINET = """
<mujoco><worldbody>
  <geom type="box" size="0.3 0.2 0.01" pos="0 0 -0.05"/>
  <body name="drawer">
    <joint name="rail" type="slide" axis="1 0 0" range="0 0.3"/>
    <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
    <geom type="box" size="0.2 0.15 0.005"/>
    <geom type="box" size="0.005 0.15 0.05" pos="0.2 0 0.05"/>
  </body>
</worldbody></mujoco>"""


def slab(size, at):
    vertices, faces = Box(size).triangles()
    return Mesh(vertices + np.array(at), faces)


def gate():
    """Two posts and a bar over them: 0.6 m between the posts."""
    posts = [slab((0.1, 0.1, 1.0), (0.0, y, 0.5)) for y in (-0.35, 0.35)]
    return [*posts, slab((0.1, 0.8, 0.1), (0.0, 0.0, 1.05))]


def with_gate(pieces=None, **options):
    scene = Scene(gravity=0.0)
    parts = gate()
    scene.add_object("gate", joined(parts), mass=5.0, pieces=pieces or parts, **options)
    return scene


def standing(position, turn, frames):
    return ObjectTrack(
        position=np.tile(position, (frames, 1)), quaternion=np.tile(turn, (frames, 1))
    )


def watched(scene):
    simulator = Simulator(scene, body=[])
    simulator.reset([])
    return Watch(simulator), simulator.world.start([])[0]


def test_a_ball_in_a_gate_is_as_far_as_the_posts_are():
    scene = with_gate(position=PLACE, quaternion=TURN)
    ball = PLACE + rot.rotate(TURN, np.array([0.0, 0.25, 0.6]))
    scene.add_object("ball", Sphere(0.04), mass=1.0, position=ball)
    watch, start = watched(scene)
    gap, pair = watch.gap(start)
    assert gap == pytest.approx(0.01, abs=COAL)
    assert set(pair) == {"gate", "ball"}


def test_a_ball_in_a_drawer_is_as_far_as_its_front_is():
    scene = Scene()
    scene.add_articulated("it", CABINET, position=PLACE, quaternion=TURN, joints={"rail": 0.1})
    assert fixed_links(scene) == {"it/world"}
    assert owners(scene) == {"it/world": "it", "it/drawer": "it"}
    assert len(solids_of(scene, "it/drawer")) == 2
    # In the drawer's corner, 5 mm from the front and 8 mm over the bottom.
    at = np.array([0.1 + 0.2 - 0.005 - 0.02 - 0.005, 0.0, 0.005 + 0.02 + 0.008])
    scene.add_object("ball", Sphere(0.02), mass=0.1, position=PLACE + rot.rotate(TURN, at))
    # Under the fixed case.
    at = np.array([0.1, 0.0, -0.06 - 0.02 - 0.003])
    scene.add_object("under", Sphere(0.02), mass=0.1, position=PLACE + rot.rotate(TURN, at))
    watch, start = watched(scene)
    gaps = sorted(d for d, *pair in watch.gaps(start) if set(pair) == {"ball", "it"})
    np.testing.assert_allclose(gaps[:2], [0.005, 0.008], atol=COAL)
    gaps = [d for d, *pair in watch.gaps(start) if set(pair) == {"under", "it"}]
    assert min(gaps) == pytest.approx(0.003, abs=COAL)
    # Its own links are no pair.
    assert not [pair for _, *pair in watch.gaps(start) if set(pair) == {"it"}]


@pytest.fixture(scope="module")
def body():
    return Body.default()


def test_a_person_in_a_gate_is_clear_and_in_its_hull_is_not(body):
    """The skin's judge uses pieces; the penetration metric uses the mesh itself."""
    motion = t_pose(np.zeros((3, 3)))
    skin = body.vertices(motion)[0]
    # Upside down: the bar under the feet, the posts beside the legs, the hands over them.
    turn = rot.exp([np.pi, 0.0, 0.0])
    position = np.array([0.0, skin[:, 1].mean(), skin[:, 2].min() + 0.98])
    track = standing(position, turn, 3)
    for pieces in (None, "hull"):
        scene = with_gate(pieces)
        thing = scene.objects["gate"]
        verdict = SkinJudge(body, scene, samples=2000).judge_motion(
            motion, {"gate": (track.position, track.quaternion)}
        )
        inside = thing.shape.depth(rot.rotate(rot.conjugate(turn), skin - position)) > 0.0
        assert inside.any() == (pieces == "hull")
        assert verdict.clear == (pieces is None)
        # The collision shape is the hull, the visible shape is the gate.
        found = metrics.penetration(motion, body, scene, objects={"gate": track})
        assert found.depth_max_mm == 0.0


def test_penetration_is_of_the_mesh_that_pieces_stand_for(body):
    """Pieces lack a post, or fill the gate: the skin penetrates the post."""
    motion = t_pose(np.zeros((2, 3)))
    skin = body.vertices(motion)[0]
    hip = body.joints(motion)[0, 1]
    position = hip - np.array([0.0, 0.35, 0.6])  # the post at y = 0.35 is in the left thigh
    post = np.minimum(0.05 - np.abs(skin - position - [0.0, 0.35, 0.5])[:, :2].max(axis=1), 0.05)
    within = np.abs(skin[:, 2] - position[2] - 0.5) < 0.5
    expected = 1000.0 * post[within].max()
    assert expected > 20.0
    track = standing(position, [1.0, 0.0, 0.0, 0.0], 2)
    found = []
    for pieces in (gate(), "hull"):
        scene = with_gate(pieces)
        found.append(metrics.penetration(motion, body, scene, objects={"gate": track}))
    assert found[0].depth_max_mm == found[1].depth_max_mm
    assert found[0].depth_max_mm == pytest.approx(expected, rel=0.2)


def test_what_starts_inside_is_judged_by_its_pieces(body):
    """A gate over a box: clear between its posts, 2 cm deep where a post stands in it."""
    motion = t_pose(np.array([[0.0, 0.0, 5.0], [0.0, 0.0, 5.0]]))
    depths = []
    for y in (0.0, 0.22):
        scene = with_gate()
        scene.add_static("box", Box((0.2, 0.2, 0.2)), position=(0.0, y, 0.5))
        solid = box("box", [-0.1, y - 0.1, 0.4], [0.1, y + 0.1, 0.6])
        simulator = Simulator(scene, body=body, settings=Settings(record="substeps"), fps=30.0)
        simulator.reset(motion[0])
        frames = [simulator.step(motion[1])]
        depths.append(ObjectJudge(simulator, [solid]).judge(motion, frames)["depth"])
    np.testing.assert_allclose(depths, [0.0, 0.1 + 0.22 - 0.3], atol=COAL)

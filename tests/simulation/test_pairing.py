"""The table of material pairs, against the rule for one pair at a time."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.baselines.settings import Kinematic
from halfphysics.scene.material_pairs import PERSON, of_person
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.simulation.names import Names
from halfphysics.simulation.pairing import set_pairings

DOOR = """<mujoco><worldbody><body name="frame"><body name="leaf" pos="0 0.4 1">
<joint axis="0 0 1"/><geom type="box" size="0.02 0.4 1" mass="9"/></body></body>
</worldbody></mujoco>"""


class Core:
    def set_pairings(self, *tables):
        self.tables = tables


def one_by_one(scene, settings, names):
    rows = names.in_scene
    friction, restitution, ignore = np.zeros((3, len(rows), len(rows)))
    trajectories = {n for n, item in scene.objects.items() if isinstance(item, KinematicObject)}
    unmoved = trajectories | set(scene.statics)
    set_ = trajectories | ({PERSON, *names.parts} if settings.drive.poses else set())
    for (i, a), (j, b) in itertools.product(enumerate(rows), repeat=2):
        if a == b and not of_person(a):
            ignore[i, j] = i != j
            continue
        friction[i, j] = scene.friction_of(a, b)
        restitution[i, j] = scene.restitution_of(a, b)
        both = {a, b}
        ignore[i, j] = scene.ignores(a, b) or both <= unmoved or both <= set_
    return friction, restitution, ignore


def room():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(), friction=0.7, restitution=0.2)
    scene.add_static("wall", hp.Box((1, 1, 1)), position=(3, 0, 0), friction=1.3)
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, friction=0.2, restitution=0.9)
    scene.add_object("box", hp.Box((1, 1, 1)), mass=1.0, position=(0, 3, 0))
    scene.add_moving("lift", hp.Box((1.0, 1.0, 0.1)), [(4, 0, 0), (4, 0, 1)], fps=1.0)
    scene.add_articulated("door", DOOR)
    return scene


ENDS = ["floor", "ball", "box", "lift", "door", PERSON, "person/left_foot", "person/head"]


@pytest.mark.parametrize("people", [0, 1, 2])
@pytest.mark.parametrize("settings", [hp.Settings(), Kinematic()], ids=["half", "kinematic"])
def test_equal_to_the_rule(people, settings):
    rng = np.random.default_rng(people)
    pairs = [p for p in itertools.combinations_with_replacement(ENDS, 2)]
    pairs = [(a, b) for a, b in pairs if a != b or of_person(a)]
    for _ in range(8):
        scene = room()
        for k in rng.permutation(len(pairs))[:5]:
            scene.friction(*pairs[k], float(rng.uniform(0.0, 2.0)))
        for k in rng.permutation(len(pairs))[:4]:
            scene.ignore(*pairs[k])
        names, core = Names.of(scene, people), Core()
        set_pairings(core, scene, settings, names)
        for mine, theirs in zip(core.tables, one_by_one(scene, settings, names), strict=True):
            assert np.array_equal(mine, theirs)

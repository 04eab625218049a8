"""Distances from statics, of which only what is near is asked first."""

import coal
import numpy as np
import pytest
import trimesh

from halfphysics.scene.scene import Scene
from support.judges.coal_shapes import coal_hull
from support.judges.judged_static import NEAR, REQUEST, JudgedStatic

HERE = coal.Transform3s()
#: Rounding of coal's distances over other trees of the same triangles [m].
ROUNDING = 1e-9


@pytest.mark.parametrize("gap", [0.5 * NEAR[0], 2.0 * NEAR[0], 0.9 * NEAR[1], 3.0 * NEAR[1]])
def test_near_triangles_give_the_distance_of_all(gap):
    scene = Scene()
    scene.add_static("ball", trimesh.creation.icosphere(4, 0.5), position=(0.3, -0.2, 1.0))
    static = JudgedStatic.of(scene.statics["ball"])
    rng = np.random.default_rng(7)
    for _ in range(20):
        away = rng.normal(size=3)
        away /= np.linalg.norm(away)
        points = rng.uniform(-0.05, 0.05, size=(12, 3))
        points += (0.3, -0.2, 1.0) + (0.5 + gap - (points @ away).min()) * away
        hull = coal_hull(points), HERE
        found, direction = static.distance(points, hull)
        whole = coal.distance(*hull, static.shape, HERE, REQUEST, coal.DistanceResult())
        assert abs(found - whole) < ROUNDING
        assert abs(np.linalg.norm(direction) - found) < 1e-6

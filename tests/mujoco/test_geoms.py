"""Geoms of a MuJoCo model: where we have a surface, MuJoCo has it too."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from halfphysics.errors import InputError
from halfphysics.geometry.mesh_queries import MeshQuery
from halfphysics.mujoco.geoms import geom_collider, mesh_triangles

#: Of the ball that touches the height field [m].
RADIUS = 0.02
WORLD = """
<mujoco><asset><hfield name="field" nrow="3" ncol="4" size="1.5 1 0.5 0.1" elevation="{}"/></asset>
<worldbody><geom name="field" type="hfield" hfield="field"/>
<body name="ball"><freejoint/><geom type="sphere" size="{}"/></body></worldbody></mujoco>"""


@pytest.fixture
def field():
    """A rough height field of 3 by 4 points and a ball, and places (n, 2) over it."""
    rng = np.random.default_rng(3)
    heights = " ".join(f"{h:.3f}" for h in rng.random(12))
    model = mujoco.MjModel.from_xml_string(WORLD.format(heights, RADIUS))
    places = rng.uniform(-0.95, 0.95, size=(40, 2)) * [1.5, 1.0]
    return model, mujoco.MjData(model), places


def test_rays_meet_a_height_field_where_its_triangles_are(field):
    model, data, places = field
    mujoco.mj_forward(model, data)
    vertices, faces = mesh_triangles(model, model.geom("field").id)
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normal[:, 2] > 0.0).all()
    for place in places:
        start, down = np.array([*place, 5.0]), np.array([0.0, 0.0, -1.0])
        geom = np.zeros(1, dtype=np.int32)
        ball = model.body("ball").id
        met = 5.0 - mujoco.mj_ray(model, data, start, down, None, 1, ball, geom)
        sides = np.roll(corners, -1, axis=1)[..., :2] - corners[..., :2]
        to = place - corners[..., :2]
        left = sides[..., 0] * to[..., 1] - sides[..., 1] * to[..., 0]
        (under,) = np.flatnonzero((left > 0.0).all(axis=1))
        first, slope = corners[under, 0], normal[under]
        ours = first[2] - (place - first[:2]) @ slope[:2] / slope[2]
        assert met == pytest.approx(ours, abs=1e-9)


def test_a_ball_touches_a_height_field_where_its_triangles_are(field):
    model, data, places = field
    vertices, faces = mesh_triangles(model, model.geom("field").id)
    query = MeshQuery(vertices, faces)
    touched = 0
    for x, y in places:
        for z in np.arange(0.01, 0.6, 0.01):
            data.qpos[:3] = x, y, z
            mujoco.mj_forward(model, data)
            gap = query.closest(data.qpos[None, :3])[0][0] - RADIUS
            # Deeper in, MuJoCo has the way out of a prism, not of the surface.
            if data.ncon and min(contact.dist for contact in data.contact) > -0.5 * RADIUS:
                touched += 1
                assert min(c.dist for c in data.contact) == pytest.approx(gap, abs=1e-5)
    assert touched > 30


def test_what_has_no_collider_is_told_what_helps(field):
    """A plane may stand where it is; a distance field is refused wherever it is."""
    model = field[0]
    ball = model.body("ball").geomadr[0]
    for kind, wanted in (("PLANE", "Fix it to the world"), ("SDF", "Make it a mesh")):
        model.geom_type[ball] = getattr(mujoco.mjtGeom, f"mjGEOM_{kind}")
        with pytest.raises(InputError, match=wanted) as error:
            geom_collider(model, ball)
        assert ("moves" in str(error.value)) == (kind == "PLANE")

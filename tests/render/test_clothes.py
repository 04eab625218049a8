"""Clothes are the whole skin, without gaps, on any shape; each is where it is worn."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.geometry.mesh_queries import is_closed, merge_vertices
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.render.clothes import dressed
from halfphysics.render.look import PEOPLE


@pytest.fixture(scope="module", params=[None, (2.0, -1.5, 1.0), (-2.5, 2.0, 0.0)], ids=str)
def body(request):
    return Body.default(betas=request.param)


def area(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_together_the_pieces_are_the_skin_without_a_gap(body):
    pieces = dressed(body)
    assert [p.name for p in pieces] == ["shirt", "trousers", "skin", "shoes", "hair"]
    rest = np.asarray(body.rest_vertices)
    places = [p.cut.of(rest) for p in pieces]
    total = sum(area(x, p.cut.faces) for x, p in zip(places, pieces, strict=True))
    assert total == pytest.approx(area(rest, body.faces), rel=1e-9)
    # Sewn together they are as closed as the skin: equal points come from equal ends.
    starts = np.cumsum([0, *(len(x) for x in places[:-1])])
    faces = np.concatenate([p.cut.faces + n for p, n in zip(pieces, starts, strict=True)])
    sewn, faces = merge_vertices(np.round(np.concatenate(places), 9), faces)
    whole, own = merge_vertices(np.round(rest, 9), body.faces)
    assert is_closed(own, len(whole)) == is_closed(faces, len(sewn))


def worn(body, point):
    """The name of the piece nearest to a point."""
    rest = np.asarray(body.rest_vertices)
    near = {p.name: np.linalg.norm(p.cut.of(rest) - point, axis=1).min() for p in dressed(body)}
    return min(near, key=near.get)


def test_everything_is_where_it_is_worn(body):
    rest, skin = np.asarray(body.rest_joints), np.asarray(body.rest_vertices)
    at = {name: rest[k] for name, k in JOINT_INDEX.items()}
    for side in ("left", "right"):
        assert worn(body, at[f"{side}_index3"]) == "skin"
        assert worn(body, at[f"{side}_elbow"]) == "skin"
        assert worn(body, at[f"{side}_shoulder"]) == "shirt"
        assert worn(body, at[f"{side}_knee"]) == "trousers"
        assert worn(body, at[f"{side}_foot"]) == "shoes"
    assert worn(body, at["spine3"]) == "shirt"
    assert worn(body, at["pelvis"]) == "trousers"
    assert worn(body, skin[skin[:, 1].argmax()]) == "hair"
    eyes = 0.5 * (at["left_eye_smplhf"] + at["right_eye_smplhf"])
    assert worn(body, eyes + np.array([0.0, 0.0, 0.05])) == "skin"


def test_people_have_shirts_of_their_own():
    shirts = [dressed(Body.default(), k)[0].color for k in range(len(PEOPLE) + 1)]
    assert len(set(shirts)) == len(PEOPLE)
    assert shirts[0] == shirts[-1]


def test_a_body_without_limbs_has_clothes_too():
    """All joints in one place, as in files that have no hands: no division by zero, one piece."""
    from dataclasses import replace

    body = replace(Body.default(), rest_joints=np.zeros((N_JOINTS, 3)))
    assert sum(len(piece.cut.faces) for piece in dressed(body)) >= len(body.faces)

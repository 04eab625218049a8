"""Bumps: a place of the skin and a tool that it runs into, every place with every tool.

`anywhere`: a place and a direction chosen by the seed.

A case is a function of a `postures.Rig`, as those of `posture_cases`; the tool is put so that the
last key's skin is `rig.depth` beyond its first touch.
"""

from __future__ import annotations

import numpy as np

from halfphysics.geometry.shapes import Box
from support.postures.furniture import Piece, board, box, chair, corner, pole, wedge
from support.postures.postures import leaning

AHEAD, LEFT = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
HANGING = {"both_shoulder": (0.0, 0.0, -1.25)}
AHEAD_ARMS = {"both_shoulder": (0.0, -1.4, 0.0)}
#: An eighth of a turn about z: a corner ahead.
_TURNED = (float(np.cos(np.pi / 8)), 0.0, 0.0, float(np.sin(np.pi / 8)))

#: Arms that hang and bend a little, and raised ones.
STAND = {**HANGING, "both_elbow": (0.0, -0.1, 0.0)}
ARMS_UP = {"both_shoulder": (0.0, 0.0, 0.9)}
#: Where: how the body stands, aimed parts, direction of motion, edges along.
PLACES = {
    "belly": ({}, ("spine1", "pelvis"), AHEAD, LEFT),
    "back": ({}, ("spine2",), (-1.0, 0.0, 0.0), LEFT),
    "buttock": (STAND, ("left_hip", "pelvis"), (-1.0, 0.0, 0.0), LEFT),
    "hip": (AHEAD_ARMS, ("left_hip",), LEFT, AHEAD),
    "hip_crease": (
        {**ARMS_UP, "both_hip": (-1.1, 0.0, 0.0), "both_knee": (1.0, 0.0, 0.0)},
        ("left_hip", "pelvis"),
        AHEAD,
        LEFT,
    ),
    "crotch": ({"both_hip": (0.0, 0.0, 0.35)}, ("pelvis",), DOWN, AHEAD),
    "armpit": (ARMS_UP, ("left_shoulder",), DOWN, AHEAD),
    "shoulder": (AHEAD_ARMS, ("left_shoulder", "left_collar"), LEFT, UP),
    "shoulder_front": (STAND, ("left_shoulder",), AHEAD, UP),
    "neck": ({}, ("neck",), AHEAD, LEFT),
    "head": ({}, ("head",), AHEAD, LEFT),
    "head_top": ({}, ("head",), UP, LEFT),
    "thigh": ({"left_hip": (-0.5, 0, 0)}, ("left_hip",), AHEAD, LEFT),
    "knee": ({"left_hip": (-0.8, 0, 0), "left_knee": (0.9, 0, 0)}, ("left_knee",), AHEAD, LEFT),
    "shin": ({"left_hip": (-0.5, 0, 0), "left_knee": (0.3, 0, 0)}, ("left_knee",), AHEAD, LEFT),
    "sole": ({"left_hip": (-0.5, 0, 0)}, ("left_foot", "left_ankle"), DOWN, LEFT),
    "elbow": ({"both_elbow": (0.0, -1.6, 0.0)}, ("left_elbow", "left_shoulder"), LEFT, UP),
    "forearm": ({}, ("left_elbow",), AHEAD, UP),
}
#: Tools: made for a point, the edge's direction and the one toward the body.
TOOLS = {
    "pole2cm": lambda at, edge, toward: pole("tool", at, edge, 0.02),
    "pole5cm": lambda at, edge, toward: pole("tool", at, edge, 0.05, round_ends=True),
    "edge90": lambda at, edge, toward: wedge("tool", at, edge, toward, 90.0),
    "edge30": lambda at, edge, toward: wedge("tool", at, edge, toward, 30.0),
    "corner": lambda at, edge, toward: corner("tool", at, toward),
    "board": lambda at, edge, toward: board("tool", at, edge, toward),
}


def _bump(place, tool):
    def case(rig):
        turns, parts, way, edge = PLACES[place]
        end = rig.key(**turns)
        way = np.asarray(way, float)
        at = _aimed(rig, end, place, parts, way)
        pieces = rig.advanced(end, [TOOLS[tool](at, edge, -way)], way)
        rub = np.asarray(edge, float)
        return end.moved(*(-(0.1 + rig.depth) * way)), end, pieces, (), rub

    return case


def _anywhere(tool):
    """A random place of the skin, in one of the poses of `PLACES`, from a random side."""

    def case(rig):
        rng = np.random.default_rng(1000 + rig.seed)
        end = rig.key(**PLACES[rng.choice(list(PLACES))][0])
        corners = rig.skin(end)[np.asarray(rig.body.faces)]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(normals, axis=1)
        face = rng.choice(len(area), p=area / area.sum())
        way = normals[face] / area[face] + 0.3 * rng.normal(size=3)
        way /= np.linalg.norm(way)
        edge = np.cross(way, rng.normal(size=3))
        edge /= np.linalg.norm(edge)
        thing = TOOLS[tool](corners[face].mean(axis=0), edge, -way)
        pieces = rig.advanced(end, [thing], way)
        return end.moved(*(-(0.1 + rig.depth) * way)), end, pieces, (), edge

    return case


def _aimed(rig, end, place, parts, way):
    """The point of the skin at which the tool aims."""
    if place == "armpit":
        joint = rig.joint(end, "left_shoulder")
        under = rig.skin(end, *parts)
        return under[np.linalg.norm(under[:, :2] - joint[:2] - (0.0, 0.02), axis=1).argmin()]
    if place == "hip_crease":
        return np.add(rig.joint(end, "left_hip"), (0.1, 0.0, 0.06))
    if place == "crotch":
        return rig.joint(end, "pelvis") - (0.0, 0.0, 0.2)
    return rig.reach(end, way, *parts)


BUMPS = {f"{place}-{tool}": _bump(place, tool) for place in PLACES for tool in TOOLS}
BUMPS |= {f"anywhere-{tool}": _anywhere(tool) for tool in TOOLS}


# -- into furniture ------------------------------------------------------------------------


def _case(make):
    BUMPS[make.__name__] = make
    return make


def _walked_into(rig, end, pieces, way, parts, rub):
    pieces = rig.advanced(end, pieces, way)
    back = -(0.1 + rig.depth) * np.asarray(way, float)
    return end.moved(*back), end, pieces, parts, rub


@_case
def hip_table_corner(rig):
    """Sideways into the corner of a table."""
    end = rig.key(**AHEAD_ARMS)
    hip = rig.reach(end, LEFT, "left_hip")
    plate = Piece("plate", Box((0.8, 0.8, 0.03)), tuple(np.add(hip, (0.0, 0.6, 0.0))), _TURNED)
    return _walked_into(rig, end, [plate], LEFT, ("left_hip",), AHEAD)


@_case
def shoulder_door_frame(rig):
    """Through an opening that is too narrow by a shoulder."""
    end = rig.key(both_shoulder=(0.0, 0.0, -1.3))
    at = rig.reach(end, AHEAD, "left_shoulder")
    y = at[1] - 0.02
    low, high = at[2] - 0.35, at[2] + 0.6  # a hatch: feet are ahead of shoulders
    frame = box("frame", (0.0, y, low), (0.12, y + 0.1, high), "-x", "-y")
    wall = box("wall", (0.02, y + 0.1, low), (0.1, y + 1.0, high), "-x")
    return _walked_into(
        rig, end, [frame, wall], AHEAD, ("left_shoulder", "left_collar", "spine2"), UP
    )


@_case
def knee_chair(rig):
    """A knee into the seat of a chair."""
    end = rig.key(left_hip=(-0.9, 0, 0), left_knee=(1.1, 0, 0), **HANGING)
    knee = rig.reach(end, AHEAD, "left_knee")
    pieces = chair(knee[2] + 0.02, knee[0] + 0.5, knee[0] + 0.05, y=knee[1])
    return _walked_into(rig, end, [pieces[0], *pieces[2:]], AHEAD, ("left_knee",), LEFT)


@_case
def head_shelf(rig):
    """Getting up under a shelf: head and board, a side board at the temple."""
    end = rig.key(leaning(0.5), **HANGING, neck=(-0.2, 0, 0))
    top = rig.reach(end, UP, "head")
    shelf = box("shelf", np.add(top, (-0.05, -0.5, 0.0)), np.add(top, (0.4, 0.5, 0.02)), "-z", "-x")
    upper = box("upper", np.add(top, (-0.05, -0.5, 0.3)), np.add(top, (0.4, 0.5, 0.32)), "-z", "-x")
    return _walked_into(rig, end, [shelf, upper], (0.5, 0.0, 0.866), ("head",), LEFT)

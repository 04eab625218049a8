"""The cases of `postures`: posture and furniture of each.

A case takes a `Rig` and gives (first key, last key, pieces, parts, one of which must press, and the
direction to rub along). Furniture is put where the last key's skin is `rig.depth` inside of it.
Hands are in `posture_hands`, bumps in `posture_bumps`.
"""

from __future__ import annotations

import numpy as np

from halfphysics.scenarios.acting.legs import WORLD_FROM_REST, about
from support.postures.furniture import bed, board, box, chair, floor, pole, sofa
from support.postures.hands import flat_hand
from support.postures.postures import leaning

UP, DOWN, AHEAD, LEFT = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
#: Hanging arms.
HANGING = {"both_shoulder": (0.0, 0.0, -1.25)}
#: Greatest depth of feet pressed into the floor [m].
STANDING = 0.01
CASES = {}


def _case(make):
    CASES[make.__name__] = make
    return make


def _ground(rig, end):
    """A floor under the feet, which end a little in it."""
    return floor(rig.low(end) + STANDING)


# -- sitting -------------------------------------------------------------------------------


def _sitting(rig, lean=0.0, back=0.0, **turns):
    """Standing half up, and seated."""
    arms = {"both_shoulder": (0.0, -0.5, -1.1), "both_elbow": (0.0, -0.9, 0.0)}
    spine = {f"spine{k}": (back, 0.0, 0.0) for k in (1, 2, 3)}
    legs = {"both_hip": (-1.5 - lean, 0.0, 0.06), "both_knee": (1.5, 0.0, 0.0)}
    end = rig.key(leaning(lean), **{**arms, **spine, **legs, **turns})
    up = {"both_hip": (-1.25, 0.0, 0.06), "both_knee": (1.3, 0.0, 0.0)}
    start = rig.key(leaning(0.25), (0.06, 0.0, 1.2), **{**arms, **up, **turns})
    return start, end


def _seat(rig, end):
    return rig.low(end, "pelvis", "both_hip") + rig.depth


@_case
def sit_chair(rig):
    start, end = _sitting(rig)
    seat = _seat(rig, end)
    back = rig.reach(end, (-1.0, 0.0, 0.0))[0] - 0.03
    pieces = chair(seat, back + 0.45, back)
    return start, end, [*pieces, _ground(rig, end)], ("left_hip", "right_hip"), AHEAD


@_case
def sit_back(rig):
    """Seated, then back against the rest."""
    start, end = _sitting(rig, lean=-0.35, back=-0.1)
    seat = _seat(rig, end)
    trunk = rig.skin(end, "spine1", "spine2", "spine3", "pelvis")
    trunk = trunk[trunk[:, 2] > seat + 0.15]
    back = trunk[:, 0].min() + rig.depth
    pieces = [*chair(seat, back + 0.5, back)]
    start = start.moved(0.12, 0.0, 0.0)
    return start, end, [*pieces, _ground(rig, end)], ("left_hip", "spine3"), UP


@_case
def sit_sofa(rig):
    """Down on the seat, back and sideways against the rests."""
    start, end = _sitting(rig, lean=-0.3, back=-0.08)
    seat = _seat(rig, end)
    trunk = rig.skin(end, "spine1", "spine2", "spine3", "pelvis")
    back = trunk[trunk[:, 2] > seat + 0.12, 0].min() + 0.6 * rig.depth
    left = rig.reach(end, LEFT, "left_hip", "pelvis")[1] - 0.5 * rig.depth
    pieces = sofa(seat, back + 0.55, back, y=left - 0.35)
    start = start.moved(0.14, -0.12, 0.05)
    return start, end, [*pieces, _ground(rig, end)], ("left_hip", "right_hip", "spine3"), AHEAD


@_case
def sit_stool_corner(rig):
    """On the front corner of a stool, one thigh on it."""
    start, end = _sitting(rig, back=0.1)
    seat = _seat(rig, end)
    front = rig.joint(end, "left_hip")[0] + 0.2
    stool = box("stool", (front - 0.4, -0.05, seat - 0.3), (front, 0.35, seat), "+z", "+x", "-y")
    return start, end, [stool, _ground(rig, end)], ("left_hip",), AHEAD


@_case
def deep_squat(rig):
    """Heels to the seat; the support behind and under is a low box."""
    legs = {"both_hip": (-2.1, 0.0, 0.15), "both_knee": (2.4, 0.0, 0.0), "both_ankle": (-0.5, 0, 0)}
    arms = {"both_shoulder": (0.0, -1.2, -0.3)}
    end = rig.key(leaning(0.2), **legs, **arms, spine1=(0.2, 0, 0), spine2=(0.2, 0, 0))
    part = {"both_hip": (-1.5, 0.0, 0.15), "both_knee": (1.9, 0.0, 0.0), "both_ankle": (-0.5, 0, 0)}
    start = rig.key(leaning(0.2), (0.04, 0.0, 1.2), **part, **arms, spine1=(0.2, 0, 0))
    seat = _seat(rig, end)
    ankle = rig.reach(end, (-1.0, 0.0, 0.0), "both_ankle", "both_foot", "both_knee")[0]
    low = box("step", (ankle - 0.6, -0.4, seat - 0.15), (ankle - 0.02, 0.4, seat), "+z", "+x")
    return start, end, [low, _ground(rig, end)], ("left_hip", "right_hip"), LEFT


# -- lying ---------------------------------------------------------------------------------


def _bed(rig, end, height, over=0.0):
    """A bed under a body along x, shorter by the length `over` at the feet's side."""
    points = rig.skin(end)
    head = rig.joint(end, "head")
    sign = 1.0 if head[0] > end.pelvis[0] else -1.0
    low, high = points[:, :2].min(axis=0) - 0.1, points[:, :2].max(axis=0) + 0.1
    if sign > 0:
        low[0] += over
    else:
        high[0] -= over
    board_at = high[0] if sign > 0 else low[0]
    return bed(height, low, high, board_at)


@_case
def lie_supine(rig):
    arms = {"both_shoulder": (0.0, 0.0, -1.15)}
    root = leaning(-0.5 * np.pi)
    end = rig.key(root, both_hip=(-0.05, 0.0, 0.1), **arms)
    start = rig.key(root, (0, 0, 1.25), both_hip=(-0.4, 0, 0.1), both_knee=(0.5, 0, 0), **arms)
    top = rig.low(end, "pelvis", "spine3") + rig.depth
    return start, end, _bed(rig, end, top), ("pelvis", "spine3"), LEFT


@_case
def lie_prone(rig):
    arms = {"both_shoulder": (0.0, 0.1, -0.1), "both_elbow": (0.0, 0.0, 1.2)}
    root = leaning(0.5 * np.pi)
    turned = {"neck": (0.0, 0.6, 0.0), "head": (0.0, 0.6, 0.0), "both_ankle": (0.7, 0, 0)}
    end = rig.key(root, **arms, **turned)
    start = rig.key(
        root, (0, 0, 1.3), both_hip=(-0.2, 0, 0.1), both_knee=(0.4, 0, 0), **arms, **turned
    )
    top = rig.low(end, "pelvis", "spine1", "spine3") + rig.depth
    return start, end, _bed(rig, end, top), ("pelvis", "spine3"), LEFT


@_case
def lie_side(rig):
    """On the left side, knees drawn up, the left arm ahead."""
    root = about(0, -0.5 * np.pi) @ WORLD_FROM_REST
    root = about(2, -0.5 * np.pi) @ root  # along x, head ahead of the pelvis
    bent = {
        "both_hip": (-0.9, 0.0, 0.0),
        "both_knee": (1.2, 0.0, 0.0),
        "left_shoulder": (0.0, -1.45, -0.2),
        "right_shoulder": (0.0, 0.9, 1.0),
        "both_elbow": (0.0, -1.1, 0.0),
    }
    end = rig.key(root, **bent)
    start = rig.key(root, (0, 0, 1.2), **{**bent, "both_hip": (-0.6, 0, 0)})
    top = rig.low(end, "left_hip", "left_shoulder", "spine2") + rig.depth
    return start, end, _bed(rig, end, top), ("left_shoulder",), AHEAD


@_case
def lie_over_edge(rig):
    """On the back, the bed's edge under the thighs, shanks hanging."""
    arms = {"both_shoulder": (0.0, 0.0, -0.9)}
    root = leaning(-0.5 * np.pi)
    legs = {"both_hip": (0.05, 0.0, 0.1), "both_knee": (1.2, 0.0, 0.0)}
    end = rig.key(root, **legs, **arms)
    start = rig.key(root, (0.0, 0, 1.25), both_hip=(-0.3, 0, 0.1), both_knee=(0.8, 0, 0), **arms)
    top = rig.low(end, "pelvis", "spine3") + rig.depth
    thigh = 0.6 * rig.joint(end, "left_knee")[0] + 0.4 * rig.joint(end, "left_hip")[0]
    over = abs(
        rig.reach(end, AHEAD if thigh > 0 else (-1.0, 0, 0))[0] + np.sign(thigh) * 0.1 - thigh
    )
    return start, end, _bed(rig, end, top, over), ("pelvis", "left_hip"), LEFT


@_case
def lie_on_pole(rig):
    """Backwards over a 5 cm pole under the small of the back."""
    root = leaning(-0.5 * np.pi)
    bent = {"spine1": (-0.2, 0, 0), "spine2": (-0.2, 0, 0), "both_shoulder": (0.0, 0.0, -0.6)}
    end = rig.key(root, **bent)
    at = rig.joint(end, "spine2")
    pieces = rig.advanced(end, [pole("pole", at, LEFT, 0.05)], DOWN)
    return end.moved(0, 0, 0.12 + rig.depth), end, pieces, ("spine2",), LEFT


# -- crouching and kneeling ----------------------------------------------------------------


@_case
def crouch(rig):
    """Down on feet and hands."""
    legs = {"both_hip": (-1.9, 0.0, 0.2), "both_knee": (2.1, 0.0, 0.0), "both_ankle": (-0.4, 0, 0)}
    arms = {"both_shoulder": (0.9, -1.4, 0.0), "both_elbow": (0, -0.1, 0)}
    spine = {f"spine{k}": (0.25, 0, 0) for k in (1, 2, 3)}
    end = rig.key(leaning(0.5), **legs, **arms, **spine)
    for side in ("left", "right"):
        end = rig.facing(end, f"{side}_wrist", flat_hand(side))
    start = end.moved(0.0, 0.0, 0.12 + rig.depth)
    ground = floor(rig.low(end) + rig.depth)
    return start, end, [ground], ("left_foot", "right_foot"), AHEAD


@_case
def crouch_wall(rig):
    """Crouching, back to a wall with a skirting board."""
    legs = {"both_hip": (-1.9, 0.0, 0.1), "both_knee": (2.0, 0.0, 0.0), "both_ankle": (-0.3, 0, 0)}
    end = rig.key(leaning(0.1), **legs, **HANGING, spine1=(0.1, 0, 0))
    back = rig.reach(end, (-1.0, 0, 0), "spine1", "spine2", "spine3", "pelvis", "both_hip")[0]
    low = rig.low(end)
    wall = box("wall", (back - 0.3, -1.0, low - 0.1), (back + rig.depth, 1.0, low + 1.5), "+x")
    start = end.moved(0.12 + rig.depth, 0.0, 0.03)
    return start, end, [wall, _ground(rig, end)], ("pelvis",), UP


@_case
def kneel(rig):
    """Knees and shins to the floor."""
    legs = {"both_hip": (-0.1, 0.0, 0.06), "both_knee": (1.6, 0.0, 0.0), "both_ankle": (1.3, 0, 0)}
    end = rig.key(leaning(0.1), **legs, **HANGING)
    start = rig.key(leaning(0.2), (0, 0, 1.2), **{**legs, "both_hip": (-0.4, 0, 0.06)}, **HANGING)
    ground = max(rig.low(end, "left_knee"), rig.low(end, "right_knee")) + 0.7 * rig.depth
    return start, end, [floor(ground)], ("left_knee", "right_knee"), AHEAD


@_case
def kneel_step(rig):
    """One knee on the edge of a step."""
    legs = {"left_hip": (-0.9, 0, 0.1), "left_knee": (1.9, 0.0, 0.0), "right_hip": (-0.1, 0, -0.06)}
    end = rig.key(**legs, **HANGING)
    knee = rig.joint(end, "left_knee")
    step = board("step", knee, LEFT, UP, thick=0.3, depth=0.2, length=0.4)
    pieces = rig.advanced(end, [step], DOWN)
    return end.moved(0, 0, 0.1 + rig.depth), end, pieces, ("left_knee",), AHEAD

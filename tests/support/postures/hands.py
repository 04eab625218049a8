"""Cases of `postures` for arms, hands and fingers; made like those of `posture_cases`."""

from __future__ import annotations

import numpy as np

from halfphysics.scenarios.acting.legs import WORLD_FROM_REST, about
from support.postures.furniture import board, box, corner, pole, table, wedge
from support.postures.postures import CLEAR, deepest, leaning

UP, DOWN, AHEAD, LEFT = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
HANDS = {}
FINGERTIPS = ("left_index3", "left_middle3", "left_ring3")


def _case(make):
    HANDS[make.__name__] = make
    return make


def flat_hand(side):
    """World orientation of a hand ahead, palm down."""
    sign = -1.0 if side == "left" else 1.0
    return WORLD_FROM_REST @ about(1, sign * 0.5 * np.pi)


def _leaning_arms(rig, raised):
    arms = {"both_shoulder": (0.95 - raised, -1.35, 0.0), "both_elbow": (0.0, -0.1, 0.0)}
    key = rig.key(leaning(0.3), **arms)
    for side in ("left", "right"):
        level = flat_hand(side) @ about(2, (1.0 if side == "left" else -1.0) * 0.4 * raised)
        key = rig.facing(key, f"{side}_elbow", level)
    return key


@_case
def elbows_on_table(rig):
    end = _leaning_arms(rig, 0.0)
    start = _leaning_arms(rig, 0.35).moved(0, 0, 0.05)
    top = max(rig.low(end, "left_elbow"), rig.low(end, "right_elbow")) + 0.5 * rig.depth
    front = rig.joint(end, "left_elbow")[0] - 0.02
    pieces = table(top, front, front + 0.7, 0.6, -0.6)
    return start, end, pieces, ("left_elbow", "right_elbow"), LEFT


@_case
def elbow_point(rig):
    """The points of the elbows on a plate, forearms upright."""
    arms = {"both_shoulder": (0.5, -1.3, 0.0), "both_elbow": (0.0, -2.0, 0.0)}
    end = rig.key(leaning(0.2), **arms)
    for side in ("left", "right"):
        end = rig.facing(end, f"{side}_elbow", _upright_arm(side))
    pieces = rig.advanced(end, [_plate(rig, end, "both_elbow", "both_shoulder")], DOWN)
    return end.moved(0, 0, 0.1 + rig.depth), end, pieces, ("left_elbow", "right_elbow"), AHEAD


def _upright_arm(side):
    sign = 1.0 if side == "left" else -1.0
    return WORLD_FROM_REST @ about(2, sign * 0.5 * np.pi)


def _plate(rig, key, *parts):
    """The front edge of a table top, under parts that are ahead."""
    at = rig.reach(key, DOWN, *parts)
    return box("plate", (at[0] - 0.04, -0.8, at[2] - 0.03), (at[0] + 0.6, 0.8, at[2]), "+z", "-x")


@_case
def hand_on_table(rig):
    """The left hand flat on a table."""
    end = rig.key(
        left_shoulder=(0.35, -1.4, 0), left_elbow=(0, -0.2, 0), right_shoulder=(0, 0, 1.2)
    )
    end = rig.facing(end, "left_wrist", flat_hand("left"))
    up = rig.key(left_shoulder=(0.1, -1.4, 0), left_elbow=(0, -0.2, 0), right_shoulder=(0, 0, 1.2))
    up = rig.facing(up, "left_wrist", flat_hand("left"))
    top = rig.low(end, "left_wrist", "left_middle1", "left_index1") + 0.6 * rig.depth
    wrist = rig.joint(end, "left_wrist")
    front = wrist[0] + 0.02
    pieces = table(top, front, front + 0.6, wrist[1] + 0.4, wrist[1] - 0.4)
    return up.moved(0, 0, 0.03), end, pieces, ("left_wrist", "left_middle1"), LEFT


def _reaching(rig, **turns):
    """Standing, the left hand ahead, palm down."""
    key = rig.key(left_shoulder=(0.2, -1.4, 0), right_shoulder=(0, 0, 1.2), **turns)
    return rig.facing(key, "left_wrist", flat_hand("left"))


def _grip(rig, thing, open_=0.1, closed=1.35):
    """Fingers that close around an object under the palm: it is made for a point and a radius."""
    start, end = _reaching(rig, curl_left=open_), _reaching(rig, curl_left=closed)
    at = rig.joint(start, "left_middle1") - (0.0, 0.0, 0.1)
    (it,) = rig.advanced(start, [thing(at)], DOWN, depth=0.0)
    while deepest(it, rig.points(start)) > -CLEAR:  # farther where it passes beside a finger
        it = it.moved((0.0, 0.0, -0.5 * CLEAR))
    return start, end, [it], FINGERTIPS, LEFT


@_case
def grip_pole_2cm(rig):
    return _grip(rig, lambda at: pole("pole", at, LEFT, 0.02))


@_case
def grip_pole_5cm(rig):
    return _grip(rig, lambda at: pole("pole", at, LEFT, 0.05, round_ends=True))


@_case
def grip_plate(rig):
    """Around the edge of a 1 cm plate."""
    return _grip(rig, lambda at: board("plate", at, LEFT, UP, thick=0.01, depth=0.3))


@_case
def grip_wedge(rig):
    return _grip(rig, lambda at: wedge("wedge", at, LEFT, UP, 40.0))


def _poke(rig, key, thing, direction, *parts):
    at = rig.reach(key, direction, *parts)
    pieces = rig.advanced(key, [thing(at)], direction)
    u = np.asarray(direction, float)
    return key.moved(*(-(0.1 + rig.depth) * u)), key, pieces, parts, tuple(np.roll(u, 1))


@_case
def poke_corner(rig):
    """The index finger into a corner."""
    key = _reaching(rig, curl_left=1.5)
    rotations = key.rotations.copy()
    rotations[25:28] = 0.0
    key = type(key)(rotations, key.pelvis)
    return _poke(rig, key, lambda at: corner("corner", at, (-1, 0.2, 0.3)), AHEAD, "left_index3")


@_case
def fingertips_wall(rig):
    """All finger tips into a wall."""
    key = _reaching(rig, curl_left=0.15)

    def wall(at):
        return box("wall", np.add(at, (0, -1, -1)), np.add(at, (0.2, 1, 1)), "-x")

    return _poke(rig, key, wall, AHEAD, "left_middle3")


@_case
def fingers_on_rods(rig):
    """Spread fingers down on rods as thick as the gaps between them."""
    key = _reaching(rig, left_index1=(0, 0.15, 0), left_ring1=(0, -0.15, 0))
    knuckle = rig.joint(key, "left_middle2")
    rods = [
        pole(f"rod{k}", np.add(knuckle, (0.0, 0.018 * (k - 1.5), -0.05)), AHEAD, 0.008, 0.6)
        for k in range(4)
    ]
    pieces = rig.advanced(key, rods, DOWN)
    return (
        key.moved(0, 0, 0.1 + rig.depth),
        key,
        pieces,
        ("left_wrist", "left_index1", "left_middle2"),
        AHEAD,
    )


@_case
def fist_on_edge(rig):
    key = _reaching(rig, curl_left=1.5)

    def edge(at):
        return wedge("edge", at, LEFT, UP, 90.0)

    return _poke(
        rig,
        key,
        edge,
        DOWN,
        "left_thumb3",
        "left_middle2",
        "left_index2",
        "left_ring2",
        "left_middle1",
    )

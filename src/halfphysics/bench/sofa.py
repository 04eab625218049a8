"""Sitting down on a sofa made of boxes, the target 6 cm inside its seat."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.bench.clips import body
from halfphysics.bench.pressing import Play, pressed
from halfphysics.bench.record import Options, Record
from halfphysics.bench.room import ARM_REST, DEPTH, SEAT, SEAT_FRONT, SLOPE
from halfphysics.bench.squatting import eased, squat, standing_height
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

#: Depth by which the target sinks once seated [m].
SINK = 0.12
_FPS, _SECONDS = 30.0, 3.0


def sofa(options: Options) -> Iterator[Record]:
    """Records of both drives."""
    motion = sitting(body(), floor=0.0)
    if options.quick:
        motion = motion[20:60]
    for record, _, _ in pressed("sofa", "boxes", Play(motion=motion, scene=boxes()), options):
        yield record


def sitting(person: Body, floor: float) -> Motion:
    """A person stands, sits down on a seat of height `SEAT`, sinks in and leans back.

    Args:
        person: The body that sits.
        floor: Final depth of the feet's target in the floor [m].
    """
    t = np.arange(round(_SECONDS * _FPS) + 1) / _FPS
    # A target at rest does not press: it sinks, leans and rocks until the end.
    down, sunk, back = eased(t, 0.1, 0.8), eased(t, 0.7, 2.3), eased(t, 0.9, 2.0)
    sway = np.sin(2.0 * np.pi * 0.8 * t) * eased(t, 0.7, 0.5)
    rock = np.cos(2.0 * np.pi * 0.8 * t) * eased(t, 0.7, 0.5)
    # From the pelvis joint down to the sitting surface; the thighs are lower than the pelvis' skin.
    seat = 0.5 * (seat_depth(person, "pelvis") + seat_depth(person, "left_hip"))
    drop = standing_height(person) - seat - SEAT
    # The pelvis stays a little forward, so that the thighs sit too; the back bends to the rest.
    lean = 0.5 * np.sin(np.pi * down) + (0.06 + 0.12 * rock) * down
    low = drop * down + (SINK - floor) * sunk
    motion = squat(person, 0.38 * down + 0.02 * back, low, lean, 0.1 * sway, _FPS)
    path = motion.translation.copy()
    path[:, 2] -= floor * sunk
    rotations = motion.rotations.copy()
    for joint in ("spine1", "spine2", "spine3"):
        rotations[:, JOINT_INDEX[joint], 0] = -0.17 * back
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotations[:, JOINT_INDEX[f"{side}_shoulder"], 2] = sign * 1.15
        rotations[:, JOINT_INDEX[f"{side}_elbow"], 1] = sign * (0.6 + 0.7 * down - 0.45 * back)
    return motion.with_frames(path, rotations)


def seat_depth(person: Body, part: str) -> float:
    """Largest distance of a part's skin behind or below its joint, seated [m]."""
    points = person.variant.parts[JOINT_INDEX[part]].vertices
    axis = 1 if part == "pelvis" else 2
    return -float(points[:, axis].min())


def boxes() -> Scene:
    """A floor and a sofa."""
    scene = Scene()
    scene.add_static("floor", Plane())
    front, back, base = SEAT_FRONT, SEAT_FRONT - DEPTH, 0.27
    for name, low, high in (
        ("base", (back, -1.0, 0.05), (front, 1.0, base)),
        ("seat_front", (front - 0.25, -1.0, base), (front, 0.32, SEAT)),
        ("seat_back", (back, -1.0, base), (front - 0.25, 0.32, SEAT - SLOPE)),
        ("rest", (back - 0.2, -1.0, 0.05), (back, 0.5, 0.9)),
        ("left_arm", (back, 0.32, base), (front, 0.5, ARM_REST)),
        ("right_arm", (back, -1.2, base), (front, -1.0, ARM_REST)),
    ):
        size = np.subtract(high, low)
        scene.add_static(name, Box(tuple(size)), position=np.add(low, 0.5 * size))
    return scene

"""Results with soft things made by hand: whoever presses is put there, the samples are geometry."""

from __future__ import annotations

from functools import cache

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.contacts import Contacts
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.results.soft_contacts import SoftContacts

#: A bed [m], its layer, and the height of its surface.
BED, THICKNESS, TOP = (2.0, 1.2, 0.4), 0.15, 0.4
STIFFNESS = 5e4
FRAMES, FPS = 16, 30.0
#: A ball on the bed: its radius, and how deep it is in the layer in the middle of the result.
RADIUS, DEEP = 0.11, 0.05
#: Distance between the samples of the ball [m], and between those of the skin.
PITCH, SKIN_PITCH = 0.015, 0.02


def soft_rows(frame, depth, position, area, **more):
    """Rows of `SoftContacts` on the bed, which is the first of the names, facing up."""
    n = len(depth)
    whole = {"layer": 0, "other": 1, "part": -1, "vertex": -1} | more
    return {
        "frame": np.full(n, frame),
        **{name: np.broadcast_to(value, n).astype(np.int64) for name, value in whole.items()},
        "position": position,
        "normal": np.tile([0.0, 0.0, 1.0], (n, 1)),
        "depth": depth,
        "pressure": STIFFNESS * depth,
        "area": np.broadcast_to(area, n).astype(np.float64),
    }


def ball_samples(centre, radius=RADIUS, pitch=PITCH):
    """Points (n, 3) of the lower half of a ball over a grid of `pitch`, and their depth."""
    grid = np.arange(-radius + pitch / 2, radius, pitch)
    xy = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    square = (xy**2).sum(axis=1)
    xy, square = xy[square < radius**2], square[square < radius**2]
    points = np.column_stack([xy + centre[:2], centre[2] - np.sqrt(radius**2 - square)])
    depth = TOP - points[:, 2]
    return points[depth > 0.0], depth[depth > 0.0]


def lying(frames=FRAMES, sink=0.03):
    """A person on the back over the bed, who sinks into it by `sink` [m] and stays."""
    body = Body.default()
    rotations = np.zeros((frames, N_JOINTS, 3))
    rotations[:, 0] = rot.log(
        rot.multiply(rot.exp(np.array([0.0, 0.0, np.pi / 2])), rot.exp(np.array([0.0, 0.0, 0.0])))
    )
    for joint, side in ((16, -1.0), (17, 1.0)):
        rotations[:, joint, 2] = side * 1.2
    translation = np.zeros((frames, 3))
    motion = hp.Motion(translation, rotations, FPS)
    lowest = body.vertices(motion, frames=[0])[0][:, 2].min()
    share = np.clip(np.arange(frames) / (frames // 2), 0.0, 1.0)
    translation[:, 2] = TOP - lowest - sink * share
    translation[:, 0] += 0.1
    return body, hp.Motion(translation, rotations, FPS)


def skin_samples(body, motion, frame):
    """Skin vertices in the bed, about one for each square of `SKIN_PITCH`: index, place, depth."""
    skin = body.vertices(motion, frames=[frame])[0]
    depth = TOP - skin[:, 2]
    inside = np.flatnonzero((depth > 0.0) & (depth < THICKNESS))
    cell = np.round(skin[inside, :2] / SKIN_PITCH).astype(int)
    _, first = np.unique(cell, axis=0, return_index=True)
    chosen = inside[np.sort(first)]
    return chosen, skin[chosen], depth[chosen]


def bed_scene(law="foam"):
    scene = hp.Scene()
    soft = hp.Soft(THICKNESS, STIFFNESS, law=law)
    scene.add_static("bed", hp.Box(BED), position=(0.0, 0.0, TOP - BED[2] / 2), soft=soft)
    scene.add_object("ball", hp.Sphere(RADIUS), mass=1.0, position=(0.7, 0.35, 1.0))
    return scene


@cache
def soft_result(law="foam"):
    """A person lies down on a bed; a ball dips into it, deepest in the middle, and leaves."""
    body, motion = lying()
    dip = DEEP * np.sin(np.pi * np.clip((np.arange(FRAMES) - 1) / (FRAMES // 2), 0.0, 1.0))
    place = np.column_stack(
        [np.full(FRAMES, 0.7), np.full(FRAMES, 0.35), TOP + RADIUS - dip + 0.02 * (dip <= 0.0)]
    )
    rows = []
    for frame in range(FRAMES):
        points, depth = ball_samples(place[frame])
        rows.append(soft_rows(frame, depth, points, PITCH**2))
        vertex, points, depth = skin_samples(body, motion, frame)
        more = {"other": 2, "vertex": vertex, "part": body.weights[vertex].argmax(axis=1)}
        rows.append(soft_rows(frame, depth, points, SKIN_PITCH**2, **more))
    table = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    return Result(
        people=(PersonResult(name="person", motion=motion, reference=motion, body=body),),
        objects={
            "ball": ObjectTrack(
                position=place, quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, 1))
            )
        },
        scene=bed_scene(law),
        names=("bed", "ball", "person"),
        contacts=Contacts.none(),
        clearance=np.full(FRAMES, np.inf),
        lost_time=np.zeros(FRAMES),
        settings=hp.Settings(),
        soft_contacts=SoftContacts(**table),
    )

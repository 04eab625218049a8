"""A short result made by hand: a walk through a gap, a ball that is kicked away."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.scene.scene import Scene

FRAMES, FPS = 16, 30.0


@cache
def small_result() -> SimpleNamespace:
    """A result as of `simulate`, with the body 12 cm beside the reference from frame 6 on."""
    body = Body.default()
    upright = rot.exp(np.array([np.pi / 2, 0.0, 0.0]))
    along_x = rot.exp(np.array([0.0, 0.0, np.pi / 2]))
    rotations = np.zeros((FRAMES, N_JOINTS, 3))
    rotations[:, 0] = rot.log(rot.multiply(along_x, upright))
    time = np.arange(FRAMES) / FPS
    for side, name in ((1, "left"), (-1, "right")):
        rotations[:, JOINT_INDEX[f"{name}_hip"], 0] = side * 0.4 * np.sin(8 * time)
        rotations[:, JOINT_INDEX[f"{name}_shoulder"], 2] = -side * 1.2
    translation = np.zeros((FRAMES, 3))
    translation[:, 0] = 1.5 * time
    reference = Motion(translation, rotations, FPS)
    # The soles on the floor: the pelvis is where the model file puts it plus the translation.
    lowest = body.vertices(reference, frames=[0])[0][:, 2].min()
    translation[:, 2] -= lowest
    reference = Motion(translation, rotations, FPS)
    moved = translation.copy()
    moved[6:, 1] += 0.12
    motion = Motion(moved, rotations, FPS)

    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_static("wall", Box((0.1, 1.5, 2.2)), position=(0.9, -1.0, 1.1))
    scene.add_static("bench", Box((0.4, 0.4, 0.4)), position=(0.5, 0.8, 0.2))
    scene.add_object("ball", Sphere(0.11), mass=0.43, position=(0.9, 0.1, 0.11))
    position = np.tile([0.9, 0.1, 0.11], (FRAMES, 1))
    position[10:, 0] += 4.0 * time[: FRAMES - 10]
    ball = SimpleNamespace(position=position, quaternion=np.tile([1.0, 0, 0, 0], (FRAMES, 1)))
    names = ("floor", "wall", "bench", "ball", "person")
    foot, shoulder = JOINT_INDEX["right_foot"], JOINT_INDEX["right_shoulder"]
    rows = [  # frame, person, part, subject, other, impulse
        *((f, 0, foot, -1, 0, 20.0) for f in range(FRAMES)),
        (2, 0, shoulder, -1, 2, 0.0),  # near, without contact
        (6, 0, shoulder, -1, 1, 3.0),
        (7, 0, shoulder, -1, 1, 2.0),
        (10, 0, foot, -1, 3, 1.0),
        (12, -1, -1, 3, 2, 0.5),
    ]
    rows.sort(key=lambda row: row[0])  # as `Contacts` are
    frame, person, part, subject, other, strength = (np.array(c) for c in zip(*rows, strict=True))
    impulse = strength[:, None] * np.array([0.0, 1.0, 0.0])
    contacts = SimpleNamespace(
        frame=frame,
        person=person,
        part=part,
        subject=subject,
        other=other,
        other_part=np.full(len(rows), -1),
        position=np.zeros((len(rows), 3)),
        normal=np.tile([0.0, 1.0, 0.0], (len(rows), 1)),
        impulse=impulse,
    )
    clearance = 0.001 * np.arange(FRAMES, dtype=float)
    clearance[-2:] = np.inf
    off = np.zeros((FRAMES, N_JOINTS))
    off[6:] = 0.12
    someone = SimpleNamespace(
        motion=motion,
        reference=reference,
        recorded=reference,
        body=body,
        name="person",
        joint_errors=lambda: (np.zeros_like(off), off),
    )
    return SimpleNamespace(
        motion=motion,
        reference=reference,
        people=(someone,),
        objects={"ball": ball},
        scene=scene,
        names=names,
        contacts=contacts,
        clearance=clearance,
        settings=SimpleNamespace(clearance_range=0.05, stiffness=1.0),
        fps=FPS,
        holds=(),
    )


@cache
def touched_result() -> SimpleNamespace:
    """The same result with contacts on the skin: at the vertex that is most its part's."""
    result = SimpleNamespace(**vars(small_result()))
    (person,) = result.people
    contacts = SimpleNamespace(**vars(result.contacts))
    vertex = np.argmax(np.asarray(person.body.weights), axis=0)
    skin = person.body.vertices(person.motion)
    contacts.position = skin[contacts.frame, vertex[np.maximum(contacts.part, 0)]]
    result.contacts = contacts
    return result

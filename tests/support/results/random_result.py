"""Results of random numbers, and exact comparison of two results."""

from __future__ import annotations

import dataclasses

import numpy as np

from halfphysics.base.axes import axes_of
from halfphysics.geometry.shapes import Box, Capsule, Plane, Sphere
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.motion.motion import Motion
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Breaches, Inside
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings


def make_result(
    body, seed=0, people=1, frames=5, axes="z", scene=None, model="smplx", holds=0, **changes
):
    """A result of random numbers; of each person so many holds, and a motion as recorded."""
    rng = np.random.default_rng(seed)

    def random():
        return 0.05 * rng.normal(size=(frames, 3)), rng.normal(size=(frames, 55, 3))

    def person(name):
        shape = {"betas": rng.normal(size=4), "gender": "female", "model": model}
        reference = Motion(*random(), 29.97, **shape, axes=axes_of(axes))
        motion = reference.with_frames(*random())
        if holds:
            held = tuple(
                AdaptedHold(
                    "ball", ("left_wrist", "right_wrist")[: 1 + k % 2], k, frames - 1,
                    rng.uniform(0.0, 99.0), tuple(rng.uniform(0.0, 0.1, 1 + k % 2)),
                    rng.normal(size=(frames, 3)), rng.normal(size=(frames, 4)),
                )
                for k in range(holds)
            )  # fmt: skip
            recorded = reference.with_frames(*random())
            scale = rng.uniform(1.0, 30.0, (frames, 55))
            reference = dataclasses.replace(
                reference, holds=held, recorded=recorded, stiffness_scale=scale
            )
        return PersonResult(name=name, motion=motion, reference=reference, body=body)

    def track(n):
        return ObjectTrack(position=rng.normal(size=(n, 3)), quaternion=rng.normal(size=(n, 4)))

    if scene is None:
        scene = Scene(gravity=(0.1, 0.2, -9.0))
        scene.add_static("floor", Plane(offset=-1.0 / 3.0))
        scene.add_static("wall", Box((0.1, 0.2, 0.3)), position=rng.normal(size=3), friction=0.3)
        quaternion = rng.normal(size=4)
        scene.add_object("ball", Sphere(0.11), mass=0.43, quaternion=quaternion, restitution=0.5)
        scene.add_object("stick", Capsule(0.1, 1.0), density=300.0, com=(0.0, 0.0, 0.1))
        scene.friction("person", "ball", 0.25)
        scene.ignore("stick", "wall")
    names = [f"person{i}" for i in range(people)]
    every = (*scene.statics, *scene.objects, *names)
    n = int(rng.integers(0, 30))
    low = {"person": -1, "part": -1, "subject": -1, "other_part": -1}
    high = {"frame": frames, "person": people, "part": 55, "other_part": 55}

    def table(kind):
        columns = {}
        for name in kind.columns():
            if name in kind.VECTORS:
                columns[name] = rng.normal(size=(n, 3))
            elif name in kind.NUMBERS:
                columns[name] = rng.uniform(0.001, 0.1, size=n)
            else:
                columns[name] = rng.integers(low.get(name, 0), high.get(name, len(every)), size=n)
        return kind(**columns)

    arguments = {
        "people": [person(name) for name in names],
        "objects": {name: track(frames) for name in scene.objects},
        "scene": scene,
        "names": every,
        "contacts": table(Contacts),
        "inside": table(Inside),
        "breaches": table(Breaches),
        "clearance": np.where(rng.random(frames) < 0.5, np.inf, rng.normal(size=frames)),
        "lost_time": rng.random(frames),
        "diagnostics": {"passes": rng.random(frames), "residual": rng.random(frames)},
        "settings": Settings(stiffness=float(rng.random()), drive_time=None, substeps=3),
    }
    return Result(**(arguments | changes))


def assert_same(a: Result, b: Result) -> None:
    """Equal to the last bit."""
    assert a.names == b.names
    assert a.settings == b.settings
    assert a.fps == b.fps
    np.testing.assert_array_equal(a.clearance, b.clearance)
    np.testing.assert_array_equal(a.lost_time, b.lost_time)
    assert sorted(a.diagnostics) == sorted(b.diagnostics)
    for name, values in a.diagnostics.items():
        np.testing.assert_array_equal(values, b.diagnostics[name])
    tables = ((a.contacts, b.contacts), (a.inside, b.inside), (a.breaches, b.breaches))
    for one, other in tables:
        for column in one.columns():
            np.testing.assert_array_equal(getattr(one, column), getattr(other, column))
    assert list(a.objects) == list(b.objects)
    for name, track in a.objects.items():
        np.testing.assert_array_equal(track.position, b.objects[name].position)
        np.testing.assert_array_equal(track.quaternion, b.objects[name].quaternion)
    assert len(a.people) == len(b.people)
    for p, q in zip(a.people, b.people, strict=True):
        assert p.name == q.name
        pairs = (p.motion, q.motion), (p.reference, q.reference), (p.recorded, q.recorded)
        for m, n in pairs:
            for field in ("translation", "rotations", "axes", "betas"):
                np.testing.assert_array_equal(getattr(m, field), getattr(n, field))
            assert (m.stiffness_scale is None) == (n.stiffness_scale is None)
            if m.stiffness_scale is not None:
                np.testing.assert_array_equal(m.stiffness_scale, n.stiffness_scale)
            assert (m.fps, m.gender, m.model) == (n.fps, n.gender, n.model)
            assert (m.recorded is None) == (n.recorded is None)
            assert len(m.holds) == len(n.holds)
        for one, other in zip(p.reference.holds, q.reference.holds, strict=True):
            for field in dataclasses.fields(one):
                np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))
        np.testing.assert_array_equal(p.body.rest_vertices, q.body.rest_vertices)


def touching(frame, part, other, impulse, person=0):
    """Contacts of given columns, of a person with objects; `impulse` (n, 3) [N s]."""
    n = len(frame)
    return Contacts(
        frame=np.asarray(frame),
        person=np.full(n, person),
        part=np.asarray(part),
        other=np.asarray(other),
        position=np.zeros((n, 3)),
        normal=np.tile([0.0, 0.0, 1.0], (n, 1)),
        impulse=np.asarray(impulse, dtype=float).reshape(n, 3),
        subject=np.full(n, -1),
        other_part=np.full(n, -1),
    )

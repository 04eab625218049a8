"""People who react: one walks to a table, reaches over a cup and sits; another one meets them.

Run it: python examples/07_people_who_react.py [film.npz]
"""

from __future__ import annotations

import sys

import numpy as np

import halfphysics as hp
from halfphysics.actors import HandOver, LookAt, Person, ReachFor, SitOn, Wait, WalkTo, play


def room() -> hp.Scene:
    """A table with a cup, a bench, and a pillar on the straight way between them."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("table", hp.Box((0.6, 1.4, 0.9)), position=(3.2, 0.0, 0.45))
    scene.add_static("pillar", hp.Box((0.35, 0.35, 2.4)), position=(1.4, 0.0, 1.2))
    scene.add_static("bench", hp.Box((0.5, 1.6, 0.44)), position=(-0.6, 1.8, 0.22))
    scene.add_object("cup", hp.Cylinder(0.04, 0.1), mass=0.3, position=(3.0, -0.1, 0.951))
    return scene


def main(out: str | None = None) -> hp.Result:
    """The ways of both cross: they go round each other, and round the pillar."""
    scene = room()
    above_cup = (2.95, -0.1, 1.13)
    guest = Person(
        place=(0.0, 0.0),
        scene=scene,
        goals=[
            ReachFor(above_cup, palm="down", hold=0.5),
            SitOn((-0.5, 1.8), height=0.44, stay=2.0),
        ],
    )
    host = Person(
        hp.Body.default(stature=1.62),
        place=(2.2, 1.6),
        heading=-2.4,
        scene=scene,
        goals=[
            WalkTo((0.2, -0.6), heading=0.8),
            HandOver(to=0, until=lambda seen: seen.time > 9.0),
            LookAt(0, seconds=2.0),
            Wait(1.0),
        ],
    )
    result = play([guest, host], scene, seconds=22.0, seed=7)
    print(result.summary())
    for name, person in zip(result.names[-2:], (guest, host), strict=True):
        state = "sits" if person.sits else "stands"
        print(f"{name} {state} at ({person.place.x:.2f}, {person.place.y:.2f}): done {person.done}")
    apart = np.linalg.norm(
        result.people[0].motion.translation - result.people[1].motion.translation, axis=1
    )
    print(f"the two were never nearer than {apart.min():.2f} m")
    if out is not None:
        result.save(out)
    return result


if __name__ == "__main__":
    main(*sys.argv[1:2])

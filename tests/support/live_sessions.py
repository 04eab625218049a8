"""A live session for tests: one person, a ball and a box on a floor, at 30 frames per second."""

from __future__ import annotations

import halfphysics as hp
from halfphysics.live.serve import serve

FPS = 30


def scene():
    found = hp.Scene()
    found.add_static("floor", hp.Plane())
    found.add_static("table", hp.Box((0.6, 0.6, 0.5)), position=(2.0, 0.0, 0.25))
    found.add_object("ball", hp.Sphere(0.11), mass=0.43, position=(1.0, 0.0, 0.11))
    return found


def session(**options):
    """A server on a free port; use it by `with`."""
    return serve(scene(), port=0, fps=FPS, **options)

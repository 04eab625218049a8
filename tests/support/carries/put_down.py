"""A thing that is put down and left: a carry of recordings.py, and ten seconds in which nothing is
done."""

from __future__ import annotations

import numpy as np

from halfphysics.results.result import ObjectTrack
from support.carries.recordings import FPS, Case, recording
from support.carries.takes import Hold, Take

#: How long the thing is left [s].
LEFT = 10.0


def left(case: Case) -> Take:
    """The take of a carry that ends with the thing put down."""
    made = recording(case)
    more = round(LEFT * FPS)
    motion, track = made.motion, made.track
    rows = np.concatenate([np.arange(len(motion)), np.full(more, len(motion) - 1)])
    return Take(
        id=f"left-{case.id}",
        kind="left",
        name=case.thing,
        solids=made.thing.solids,
        mass=made.thing.mass,
        bodies=(made.body,),
        motions=(motion.with_frames(motion.translation[rows], motion.rotations[rows]),),
        track=ObjectTrack(position=track.position[rows], quaternion=track.quaternion[rows]),
        holds=tuple(Hold(0, f"{side}_wrist", *made.hold) for side in made.thing.grasps),
        statics=made.stands,
        noise=case.noise,
    )

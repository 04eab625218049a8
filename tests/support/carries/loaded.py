"""Recordings as `load_sequence` gives them: in memory, or from a file of a data set's layout."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box
from halfphysics.simulation.sequence import Sequence
from support.carries.files import LAYOUTS
from support.carries.files.written import at_rate
from support.carries.recordings import Recording

#: A recording that is not written at all.
MEMORY = "memory"
#: Joints of the body, without those of the face and the fingers.
BODY = slice(0, 22)


@dataclass(frozen=True, eq=False)
class Loaded:
    """What is simulated, and what it is judged by.

    Attributes:
        sequence: Motions as adapted, the scene with the stands that the layout does not have.
        recorded: The carrier's motion as it was recorded.
        made: The recording at the rate of the layout.
        middle: Of the thing, in the frame of its object in the scene (3,) [m].
        size_mm: Largest distance of a joint of the carrier's body from where it was recorded.
    """

    sequence: Sequence
    recorded: object
    made: Recording
    middle: np.ndarray
    size_mm: float

    @property
    def motion(self):
        """The carrier's motion."""
        return self.sequence.motions[0]

    @property
    def body(self):
        """The carrier's body."""
        return self.sequence.bodies[0] or hp.Body.default()


def loaded(made: Recording, layout: str, how: str) -> Loaded:
    """A recording, `bare`, in `contact` or `adapted`, from memory or from a file of a layout."""
    if layout == MEMORY:
        sequence = made.sequence()
        prepared = sequence if how in ("unsized", "bare") else _adapted(sequence, how)
        return Loaded(prepared, sequence.motion, made, np.zeros(3), 0.0)
    module, fps = LAYOUTS[layout]
    made = at_rate(made, fps)
    with tempfile.TemporaryDirectory() as folder:
        written = module.write(made, Path(folder))
        sequence = hp.load_sequence(written.path, adapt=how == "adapted")
    track = sequence.recorded[made.case.thing]
    middle = track.position + rot.rotate(track.quaternion, written.middle)
    off = float(np.abs(middle - made.track.position).max())
    if off > written.precision:
        raise ValueError(f"{made.case.id} as {layout}: the thing is {off:g} m from the record")
    if layout != "grab":  # it has its table
        for name, (size, position, quaternion) in made.stands.items():
            sequence.scene.add_static(name, Box(size), position=position, quaternion=quaternion)
    recorded = sequence.motions[0].recorded or sequence.motions[0]
    body = sequence.bodies[0] or hp.Body.default()
    away = body.joints(recorded)[:, BODY] - made.body.joints(made.motion)[:, BODY]
    if how == "contact":
        sequence = _adapted(sequence, how)
    return Loaded(
        sequence,
        recorded,
        made,
        written.middle,
        float(1000.0 * np.linalg.norm(away, axis=-1).max()),
    )


def _adapted(sequence: Sequence, how: str) -> Sequence:
    """The sequence with its motions adapted: `contact` without a grip."""
    from halfphysics.adaptation.adapt import adapt

    options = {} if how == "adapted" else {"grip": False}
    motions = [
        adapt(motion, sequence.scene, body, sequence.recorded, **options).motion
        for motion, body in zip(sequence.motions, sequence.bodies, strict=True)
    ]
    one = isinstance(sequence.motion, hp.Motion)
    return replace(sequence, motion=motions[0] if one else tuple(motions))

"""Scenarios simulated for the figures, and the measures that they share."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from collections.abc import Sequence as Several
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics import metrics, scenarios
from halfphysics.base import rotations as rot
from halfphysics.baselines import from_options
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.motion.skeleton import N_JOINTS, PARENTS
from halfphysics.results.result import SETTLE

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack, Result
    from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

#: Frames between measurements of the skin in a quick report.
EVERY = 4
#: Pictures of a strip; each this wide and high [pixels]: two beside each other fill a phone.
_TILES, _QUICK_TILES, _COLUMNS, _SIZE = 4, 2, 2, (230, 250)


def play(name: str, options: Mapping[str, Any], choice: Mapping[str, Any]) -> Result:
    """A scenario of one person, with the settings chosen."""
    return run(scenarios.load(name, **options), choice)


def run(sequence: Sequence, choice: Mapping[str, Any]) -> Result:
    """A result with the settings chosen; lost time is a number here, so its warning is silenced."""
    from halfphysics.simulation.simulate import simulate

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        return simulate(
            sequence.motions[0],
            sequence.scene,
            body=sequence.bodies[0],
            settings=from_options(choice),
        )


def strip(
    result: Result, wanted: bool, *, quick: bool, frames: Several[int] | None = None
) -> dict[str, bytes]:
    """The pictures of a task: "strip" is a PNG of under 150 kB, which a phone can show.

    It shows the frames given, as far as the result has them, or its key frames.
    """
    from halfphysics.render.contact_sheet import contact_sheet_png, key_frames

    if not wanted:
        return {}
    if frames is None:
        frames = key_frames(result, _QUICK_TILES if quick else _TILES)
    frames = [min(frame, len(result) - 1) for frame in frames]
    samples = 1 if quick else 2
    return {"strip": contact_sheet_png(result, frames, _COLUMNS, _SIZE, samples=samples, colors=96)}


def penetration(
    result: Result, *, quick: bool = False, frames: slice | None = None
) -> metrics.PenetrationReport:
    """Penetration of the skin: at all frames or those given; at some frames if quick."""
    every = frames or slice(None, None, EVERY if quick else 1)
    tracks = {k: frames_of(track, every) for k, track in result.objects.items()}
    body = result.people[0].body
    return metrics.penetration(result.motion[every], body, result.scene, objects=tracks)


def default_body(sequence: Sequence) -> Body:
    """The body of the person in the scenarios."""
    from halfphysics.body.body import Body

    return sequence.bodies[0] or Body.default()


def frames_of(track: ObjectTrack, which: slice) -> ObjectTrack:
    """The track of an object at some frames."""
    return replace(track, position=track.position[which], quaternion=track.quaternion[which])


def joint_angles(a: Motion, b: Motion) -> Array:
    """Angles between the joints of two motions (T, 55) [degrees]."""
    return np.degrees(rot.angles(a.rotations, b.rotations))


def pelvis_distance(result: Result) -> Array:
    """Distance of the pelvis of the first person from its reference (T,) [m]."""
    return result.people[0].joint_errors()[1][:, 0]


def free_joints(result: Result) -> NDArray[np.bool_]:
    """Whether a joint of the first person is unaffected by contacts (T, 55).

    A joint between a contact and the root is affected: its own part, or one below it in the tree,
    is in contact. It stays affected for the time that it may take to return, `SETTLE`. The pelvis
    is affected by every contact. Joints below a blocked part count as unaffected.
    """
    frames = len(result.motion)
    touches = np.zeros((frames, N_JOINTS), dtype=bool)
    contacts = result.contacts
    rows = (contacts.person == 0) & (contacts.part >= 0)
    touches[contacts.frame[rows], contacts.part[rows]] = True
    beyond = touches.copy()
    for joint in range(N_JOINTS - 1, 0, -1):
        beyond[:, PARENTS[joint]] |= beyond[:, joint]
    wait = round(SETTLE * result.fps)
    out = np.ones_like(beyond)
    for t in range(frames):
        out[t] = ~beyond[max(0, t - wait) : t + 1].any(axis=0)
    out[:, 0] = False
    return out


def object_speed(result: Result, name: str) -> Array:
    """Speed of an object between frames (T - 1,) [m/s]."""
    way = np.diff(result.objects[name].position, axis=0)
    return np.asarray(np.linalg.norm(way, axis=1) * result.fps)


def first_touch(result: Result, name: str) -> int:
    """The first frame with a contact of the person; the last frame if there is none."""
    contacts = result.contacts
    touched = (contacts.other == result.names.index(name)) & (contacts.person == 0)
    return int(contacts.frame[touched].min()) if touched.any() else len(result) - 1

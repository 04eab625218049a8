"""Motions in furnished rooms, reference and simulated: the runs of Table 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from evidence.model import Outcome
from evidence.rooms import verify
from evidence.runs import choices, playing
from halfphysics import metrics

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.results.result import Result
    from halfphysics.simulation.sequence import Sequence as Played

#: Statures [m] of the visitors, in turn; None: the default body.
_STATURES = (None, 1.62, 1.84)
#: Frames between measurements of the skin: in a quick report, and in the check that the references
#: intersect the room.
_QUICK_EVERY, _ASKED_EVERY = 8, 5
#: Methods to play a motion: name, description, settings.
WAYS: dict[str, tuple[str, choices.Choice]] = {
    "paper": ("half-physics, the paper's algorithm", choices.FIRM),
    "ours": ("half-physics, the default drive", {"stiffness": 1.0, "substeps": 8}),
    "peer": ("plain MuJoCo, velocities set", {"mode": "engine_velocity", "substeps": 8}),
}
#: Methods that claim no penetration.
CLAIMED = ("paper", "ours")


def made(number: int, seed: int, ways: Sequence[str], strip: bool, quick: bool) -> Outcome:
    """One test scene: its room, and its motion as reference and as played by all `ways`."""
    from evidence.rooms.layout import room
    from evidence.rooms.visits import visit
    from halfphysics.body.body import Body
    from halfphysics.simulation.sequence import Sequence as Played

    stature = _STATURES[number % len(_STATURES)]
    body = Body.default() if stature is None else Body.default(stature=stature)
    furnished = room(number, seed)
    asked = visit(furnished, body, number, seed)
    sequence = Played(asked.motion, furnished.scene, body)
    # MuJoCo only has convex solids: it gets the convex bodies that the furniture is made of.
    peers = Played(asked.motion, furnished.bodies, body)
    outcome = measured(sequence, ways, strip, quick, peers)
    about = {
        "triangles": furnished.triangles,
        "scanned": furnished.scanned,
        "items": [item.name for item in furnished.items],
        "uses": asked.uses,
    }
    return Outcome(values={**outcome.values, "room": about}, pictures=outcome.pictures)


def measured(
    sequence: Played,
    ways: Sequence[str],
    strip: bool,
    quick: bool,
    peers: Played | None = None,
) -> Outcome:
    """A motion of one person in a scene, as reference and as played by all `ways`.

    `peers`: the sequence for MuJoCo; its skin is measured in the scene itself, too.
    """
    motion, body = sequence.motions[0], playing.default_body(sequence)
    every = _QUICK_EVERY if quick else 1
    values: dict[str, Any] = {"frames": len(motion), "fps": motion.fps}
    values["asked"] = {
        **_depths(metrics.penetration(motion[::every], body, sequence.scene)),
        **_verdict(motion, body, sequence.scene, _QUICK_EVERY if quick else _ASKED_EVERY),
    }
    pictures: dict[str, bytes] = {}
    for way in ways:
        claimed = way in CLAIMED
        result = playing.run(sequence if claimed else peers or sequence, WAYS[way][1])
        tracks = {
            k: playing.frames_of(o, slice(None, None, every)) for k, o in result.objects.items()
        }
        report = metrics.penetration(result.motion[::every], body, sequence.scene, objects=tracks)
        values[way] = {**_depths(report), **_kept(result)}
        if claimed:
            values[way] |= _verdict(result.motion, body, sequence.scene, every)
        pictures |= playing.strip(result, strip and way == "ours", quick=quick)
    return Outcome(values=values, pictures=pictures)


def _depths(report: metrics.PenetrationReport) -> dict[str, float]:
    return {
        "rate": report.rate_percent,
        "mean_mm": report.depth_mean_mm,
        "max_mm": report.depth_max_mm,
        "inside_mm": report.depth_penetrating_mm,
    }


def _kept(result: Result) -> dict[str, Any]:
    """Whether all frames came back, and the errors against the reference."""
    local, everywhere = result.people[0].joint_errors()
    whole = len(result.motion) == len(result.reference) and bool(np.isfinite(everywhere).all())
    return {
        "success": whole,
        "local_mm": float(1e3 * local.mean()),
        "global_mm": float(1e3 * everywhere.mean()),
        "lost_s": float(result.lost_time.sum()),
    }


def _verdict(motion: Any, body: Body, scene: Any, every: int) -> dict[str, Any]:
    """The result of the independent library; empty where it is not installed."""
    found = verify.verify(motion, body, scene, every=every)
    if found is None:
        return {}
    return {
        "library": found.library,
        "checked": found.checked,
        "intersecting": found.intersecting,
        "distance_mm": None if found.distance is None else 1e3 * found.distance,
    }

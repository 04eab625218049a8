"""Events of a result: when people carry objects, which objects slip in their hands or are dropped.

Only objects that move freely (`Scene.add_object`) have events: a link hangs on its joint, and a
kinematic object has no weight. "Up" is against gravity; metres, seconds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.labels.event_kinds import Drop, Events, Hold, Limits, Slip
from halfphysics.labels.holds import holds_and_drops
from halfphysics.labels.loads import Loads
from halfphysics.labels.slips import slips_of
from halfphysics.metrics.argument_checks import check_result
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.results.result import Result


def events(result: Result, limits: Limits | None = None) -> Events:
    """Holds, slips and drops of a result.

    They come from the contacts' impulses and the poses at the frames. An object is *carried* in a
    frame in which the forces that people exert on it are together at least `Limits.load` of its
    weight, and statics and other objects bear at most `Limits.elsewhere` of it: a tray is carried,
    a cup that stands on it is not. A kick is shorter than `Limits.hold`.

    A part *slides* if it is one of the parts that exert the load on an object and its surface moves
    along the object's surface at the contact, both taken as rigid between two frames. The object
    need not be carried: palms that pull at a suitcase and slide along it slip as well.

    Raises:
        InputError: `result` is no result, or `limits` is no `Limits`.
        FileError: In a result from a file: a body or the scene is missing.
    """
    check_result(result)
    limits = Limits() if limits is None else limits
    if not isinstance(limits, Limits):
        raise InputError(f"limits: expected Limits, found {shown(limits)}")
    scene = result.scene
    holds: list[Hold] = []
    drops: list[Drop] = []
    slips: list[Slip] = []
    for name in result.objects:
        item = scene.objects.get(name)  # None: a link, or its mesh file is missing
        if item is None or isinstance(item, KinematicObject):
            continue
        loads = Loads.of(result, item)
        if not len(loads.rows):
            continue
        for hold, drop in holds_and_drops(loads, limits):
            holds.append(hold)
            drops += [] if drop is None else [drop]
        slips += slips_of(loads, limits)
    return Events(
        holds=tuple(sorted(holds, key=lambda hold: hold.first)),
        slips=tuple(sorted(slips, key=lambda slip: slip.first)),
        drops=tuple(sorted(drops, key=lambda drop: drop.released)),
    )

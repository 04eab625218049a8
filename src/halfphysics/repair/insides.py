"""How deep people of a repair are inside static geometry, objects and each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from halfphysics.geometry.shapes import Plane
from halfphysics.metrics.penetration import PenetrationReport, penetration

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result

#: Skin that is at most this deep [mm] is not inside: the tolerance of PhysDiff (Yuan et al. 2023).
DEEP = 5.0


def insides(motions: Sequence[Motion], result: Result) -> list[PenetrationReport]:
    """The penetration of motions of the people of a result, one each, in all that is around them.

    Objects are where the simulation has them, people where the motions have them.
    """
    people = {p.name: (m, p.body) for p, m in zip(result.people, motions, strict=True)}
    return [
        penetration(
            motion,
            body,
            result.scene,
            objects=result.objects,
            people={other: its for other, its in people.items() if other != name},
        )
        for name, (motion, body) in people.items()
    ]


def told(reports: Sequence[PenetrationReport], result: Result) -> list[str]:
    """What people were inside and are moved out of, in words.

    Level ground is left out: feet that are not flat are in it.
    """
    level = {name for name, its in result.scene.statics.items() if isinstance(its.shape, Plane)}
    deep = {
        name
        for report in reports
        for name, depth in report.by_name.items()
        if name not in level and depth.max() > DEEP
    }
    people = {person.name for person in result.people}
    lines = ["people were inside each other: moved apart"] if deep & people else []
    things = [name for name in result.names if name in deep - people]
    return [*lines, f"inside {', '.join(things)}: moved out"] if things else lines

"""How people stand in scenarios with default settings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from halfphysics import metrics, scenarios
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import measure, simulators
from halfphysics.body.body import Body
from halfphysics.metrics.asked import asked_motion
from halfphysics.results.result import Result
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import follow

#: Scenarios of one person: walking and kicking, at a wall, between a jamb and a table, on a sofa.
STORIES = ("kick_ball", "walk_into_wall", "doorway", "sit_on_sofa")


def ground(options: Options) -> Iterator[Record]:
    """Frames/s of each scenario, and how its person stands."""
    for name in STORIES:
        told = scenarios.load(name)
        motion = options.short(told.motions[0])
        person = told.bodies[0] or Body.default()
        skin, parts = simulators(person, Settings(), motion.fps, told.scene)
        done = measure(
            "ground",
            name,
            len(motion) - 1,
            options,
            ours=partial(follow, skin.world, [motion]),
            parts=partial(follow, parts.world, [motion]),
        )
        yield replace(done.record, checks=standing(done.ours))


def standing(result: Result) -> dict[str, tuple[float, None]]:
    """How the first person of a result stands; none has a peer."""
    person = result.people[0]
    floats = metrics.floating(
        person.motion,
        person.body,
        result.scene,
        objects=result.objects,
        reference=asked_motion(person),
    )
    stance, force = metrics.stance_slide(result), metrics.net_force(result)
    path = metrics.path_offset(result)
    return {
        "floating [%]": (floats.percent, None),
        "held up by nothing [%]": (metrics.unsupported_weight(result).percent, None),
        "slide in stance [mm/frame]": (stance.simulated.mean_mm, None),
        "held for 50 ms [body weights]": (force.sustained_weights, None),
        "beyond joint ranges [deg]": (metrics.range_violations(result).max_deg, None),
        "peak [N]": (force.peak, None),
        "off the path at the end [mm]": (path.end_offset_mm, None),
        "tilt at the end [deg]": (path.end_tilt_deg, None),
    }

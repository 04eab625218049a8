"""Speed measured beside a peer in one run, for `halfphysics bench`.

A case is a function ``(Options) -> Iterator[Record]`` of a module here and one line below. Rates
depend on the machine and its load; the ratio to a peer timed in turns hardly does.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

from halfphysics.bench.record import Options, Record
from halfphysics.errors import InputError

__all__ = ["CASES", "LEFT_OUT", "Options", "Record", "run"]

#: Case -> (module of this package, function, description in one line).
CASES: Mapping[str, tuple[str, str, str]] = MappingProxyType(
    {
        "free": (
            "free",
            "free",
            "motion in, corrected motion out, nothing near; models are built before. "
            "Baseline: MuJoCo, without geometry, velocities set, internal forces cancelled",
        ),
        "live": (
            "free",
            "live",
            "the same pose by pose. Baseline: the same loop pose by pose",
        ),
        "stepper": (
            "free",
            "stepper",
            "the native core alone, targets computed before: not what a user sees. "
            "Baseline: its loop alone, targets computed before",
        ),
        "itself": (
            "itself",
            "itself",
            "the core alone, walking with self-contact, nothing near. "
            "Baseline: ours without self-contact",
        ),
        "wall": (
            "wall",
            "wall",
            "a T-pose walked into a wall of 1 cm at 1.5 m/s. "
            "Baseline: the same loop with the wall as a box and the parts as convex meshes",
        ),
        "near": (
            "near",
            "near",
            "the core alone, N=8, walking between things that stand 1 m off. "
            "Baseline: its loop alone, the meshes as convex pieces",
        ),
        "grasp": (
            "grasp",
            "grasp",
            "two hands squeeze a box of 3 kg, lift it and hold it, N=8. Baseline: the same loop",
        ),
        "lift": (
            "handling",
            "lift",
            "the scenario lift_suitcase: two palms lift 5 kg, walk and shake, N=8. "
            "Baseline: the same loop",
        ),
        "glass": (
            "handling",
            "glass",
            "the scenario grasp_glass: all fingers of one hand lift, shake, carry and turn over "
            "0.3 kg, N=8. Baseline: the same loop",
        ),
        "sofa": (
            "sofa",
            "sofa",
            "sitting down on a sofa of boxes and rocking on it, N=8. Baseline: the same loop",
        ),
        "soft-seat": (
            "soft",
            "seat",
            "the scenario sit_on_sofa with a seat and a rest of foam, N=8. "
            "Baseline: ours on the same sofa, hard",
        ),
        "soft-bed": (
            "soft",
            "bed",
            "the scenario stretch_on_bed on a mattress of foam, N=8. "
            "Baseline: ours on the same bed, hard",
        ),
        "lean": (
            "lean",
            "lean",
            "in a furnished room, one mesh: leaning on a wall, rummaging in a shelf, N=8. "
            "Baseline: the room as convex pieces",
        ),
        "settle": (
            "settle",
            "settle",
            "in the same room: sitting down on the sofa, feet pressed into the floor, N=8. "
            "Baseline: the room as convex pieces",
        ),
        "tree": (
            "tree",
            "tree",
            "what the room's mesh takes before the first frame: its tree, built, and found again "
            "by its content; seconds",
        ),
        "meeting": (
            "meeting",
            "meeting",
            "the scenario meet: two people walk into each other, N=8; no baseline",
        ),
        "doorway": ("doorway", "doorway", "the demo's story: doorway, table, ball"),
        "ground": (
            "ground",
            "ground",
            "scenarios with default settings, and how their person stands: floating, slide of feet "
            "in stance, net force, offset and tilt at the end; no baseline",
        ),
        "setup": (
            "whole",
            "setup",
            "a world of a body and a scene seen before, seconds. "
            "Baseline: of a body that this process has not seen; less is better",
        ),
        "clip": (
            "whole",
            "clip",
            "150 free frames by simulate, set-up included. "
            "Baseline: the same in a world built before",
        ),
        "batch": (
            "whole",
            "batch",
            "8 clips together at a wall, processor time of all threads; and by the clock. "
            "Baseline: simulate, clip after clip",
        ),
        "hosted": (
            "hosted",
            "hosted",
            "a person in a MuJoCo world of one's own, beside a robot arm, 2 ms, 30 frames/s. "
            "Baseline: the same world with the person as plain MuJoCo bodies, velocities set, "
            "internal forces cancelled",
        ),
        "hosted-worlds": (
            "hosted",
            "worlds",
            "8 such worlds in which the arm presses on the person, by one call, processor time of "
            "all threads; and by the clock. Baseline: Control.step, world after world",
        ),
        "envs": (
            "envs",
            "envs",
            "environments of robots and people, 16 side by side on all cores, by the clock; "
            "no baseline",
        ),
        "instructions": (
            "instructions",
            "instructions",
            "the core alone, skin, default drive, N=8: instructions per substep with contact, "
            "counted by valgrind where it is installed; millions, less is better",
        ),
        "metrics": (
            "measuring",
            "penetration",
            "metrics.penetration of 10,000 vertices in meshes of 10,000 triangles for 100 frames "
            "and of 100,000 for 1,000, skinning included; seconds for all frames, processor time "
            "of all threads",
        ),
        "viewer": (
            "viewer",
            "viewer",
            "two people of 14k vertices, and their ghosts, moved 30 times a second in a browser "
            "scene with a client connected",
        ),
        "sweep": (
            "sweep",
            "sweep",
            "sweeps of a scenario, whole: two processes beside one by the clock; one process, "
            "processor time. Baseline: what stands behind each setting",
        ),
        "sweep-parts": (
            "sweep",
            "parts",
            "where a variant's processor time goes; seconds. Baseline: simulate of the same run",
        ),
        "sweep-memory": (
            "sweep",
            "memory",
            "what driver and workers hold at ten points of a long sweep; MB",
        ),
        "skinning": ("measuring", "skinning", "body.vertices, all vertices of the default body"),
    }
)

#: Case -> why it may have no records.
LEFT_OUT: Mapping[str, str] = MappingProxyType(
    {
        "instructions": "valgrind is not installed",
        "sweep-memory": "what other processes hold is read on Linux only",
    }
)


def run(name: str, options: Options) -> Iterator[Record]:
    """The records of one case, each returned when it is measured.

    Raises:
        InputError: The case is unknown.
    """
    if name not in CASES:
        raise InputError(f"bench: unknown case {name!r}, expected one of {', '.join(CASES)}")
    module, function, _ = CASES[name]
    measure: Callable[[Options], Iterator[Record]] = getattr(
        importlib.import_module(f"{__name__}.{module}"), function
    )
    return measure(options)

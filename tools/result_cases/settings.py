"""Every scenario, and some of them with every choice of how to simulate."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import result_values
from result_cases.scenes import body, bowling, clip, clips, moved

#: One of every kind: walls, things held, joints, furniture, two people, a ball.
VARIED = ("walk_into_wall", "push_door", "sit_on_sofa", "kick_ball", "grasp_glass", "shake_hands")
#: Those of them that are played with all combinations of `grid`.
GRID = ("walk_into_wall", "push_door", "sit_on_sofa")
#: The two drives by name.
DRIVES: Mapping[str, dict[str, Any]] = {"drive": {}, "algorithm1": {"drive_time": None}}
#: Choices that stand alone, by name.
CHOICES: Mapping[str, dict[str, Any]] = {
    "self_contact": {"self_contact": True},
    "self_contact_parts": {"self_contact": True, "contact": "parts"},
    "human": {"strength": "human"},
    "human_self": {"strength": "human", "self_contact": True},
    "limits": {"strength": {"arms": 20.0, "root": 300.0, "pelvis": 100.0}},
    "recover": {"root": "recover", "root_speed": 0.6, "recovery_rate": 4.0},
    "by_joint": {"stiffness": {"arms": 0.2, "right_wrist": 5.0}},
    "wide": {"clearance": 0.01, "clearance_range": 0.2},
    "close": {"clearance": 0.0},
    "loose": {"tolerance": 1e-4, "max_sweeps": 5},
    "substeps": {"record": "substeps"},
    "substeps_paper": {"record": "substeps", "drive_time": None, "substeps": 8, "stiffness": 0.0},
    "threads_2": {"threads": 2},
    "human_parts": {"strength": "human", "contact": "parts", "stiffness": 0.5},
}
#: Choices, and scenarios with all choices, that `--quick` runs.
QUICK = ("self_contact", "human", "recover", "substeps", "threads_2", "by_joint")


def scenario(name: str, **changes: Any) -> dict[str, Any]:
    """A scenario played with some settings changed; `options` are those of the scenario."""
    told = hp.scenarios.load(name)
    settings = replace(told.settings, **changes)
    result = hp.simulate(told.motion, told.scene, body=told.body, settings=settings)
    return {"asked": [motion.translation for motion in told.motions], **result_values(result)}


def solids(name: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """A clip among solids of every kind."""
    settings = hp.Settings(**changes)
    return result_values(hp.simulate(clip(name), bowling(), body=body(), settings=settings))


def pair(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Two people who move into each other among solids."""
    first, second = clip("asap_walk1"), clip("asap_kick1")
    people = [moved(first, (-0.35, 0.05, 0.0)), moved(second, (0.35, -0.1, 0.0))]
    frames = min(len(motion) for motion in people)
    people = [motion[:frames] for motion in people]
    other = hp.Body.default(stature=1.6)
    settings = hp.Settings(**changes)
    return result_values(
        hp.simulate(
            people, bowling(), body=[body(), other], settings=settings, stiffness=[1.0, 0.3]
        )
    )


def grid() -> Iterator[tuple[str, dict[str, Any]]]:
    """Drive, firmness, number of substeps and shape of contact, all with all."""
    for drive, firm, count, contact in itertools.product(
        DRIVES, (0.0, 1.0, 10.0), (1, 8), ("skin", "parts")
    ):
        changes = {**DRIVES[drive], "stiffness": firm, "substeps": count, "contact": contact}
        yield f"{drive}_{firm:g}_{count}_{contact}", changes


def cases() -> Iterator[Case]:
    """Scenarios as they are, then everything with every choice."""
    for name in hp.scenarios.names():
        yield Case(f"scenario/{name}", partial(scenario, name), quick=True)
    combined = dict(grid())
    for what, changes in (*combined.items(), *CHOICES.items()):
        few = what in QUICK or what in ("algorithm1_0_8_skin", "drive_10_1_parts")
        together = what in ("self_contact", "human", "algorithm1_0_8_skin")
        everything = what in CHOICES or together
        for name in VARIED if everything else GRID:
            chosen = few if name == "walk_into_wall" else together and name == "shake_hands"
            yield Case(f"{name}/{what}", partial(scenario, name, **changes), quick=chosen)
        yield Case(f"two_people/{what}", partial(pair, changes), quick=together)
        for name in ("asap_kick1", "animdraw_dab") if everything else ("asap_kick1",):
            if name in clips():
                yield Case(f"solids/{name}/{what}", partial(solids, name, changes), quick=few)

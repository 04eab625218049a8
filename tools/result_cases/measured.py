"""What is worked out of results: reports of parts, metrics, labels, events, pictures."""

from __future__ import annotations

import io
import runpy
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import halfphysics as hp
from result_cases.case import Case
from result_cases.scenes import body, bowling, clip, furnished

#: Scenarios that are measured, besides clips among solids and in a furnished room.
SCENARIOS = ("grasp_glass", "sit_on_sofa", "shake_hands", "push_door", "lift_suitcase", "kick_ball")


def simulated(name: str) -> hp.Result:
    """A result to measure: of a scenario, or of a kick in a "room" or among "solids"."""
    if name in ("room", "solids"):
        scene = furnished(0.1) if name == "room" else bowling()
        return hp.simulate(clip("asap_kick1"), scene, body=body())
    told = hp.scenarios.load(name)
    people = tuple(motion[:90] for motion in told.motions)
    return hp.simulate(people, told.scene, body=told.body, settings=told.settings)


def parts(name: str) -> dict[str, Any]:
    """Clearance, contact, force and displacement of every part; frames without contact."""
    result = simulated(name)
    people = range(len(result.people))
    return {
        "parts": [result.parts(person) for person in people],
        "free": [result.free_frames(person) for person in people],
        "joint_errors": [list(person.joint_errors()) for person in result.people],
    }


def metrics(name: str) -> dict[str, Any]:
    """Every metric."""
    result, m = simulated(name), hp.metrics
    first = result.people[0]
    others = {p.name: (p.motion, p.body) for p in result.people[1:]}
    motions = (result.reference, result.motion)
    return {
        "mpjpe": m.mpjpe(*motions, first.body),
        "mpjpe_global": m.mpjpe_global(*motions, first.body),
        "jerk": [m.jerk(motion, first.body) for motion in motions],
        "foot_skate": [m.foot_skate(motion, first.body) for motion in motions],
        "deviation": m.deviation(result),
        "contact_precision": m.contact_precision(result),
        "contact_forces": m.contact_forces(result),
        "penetration": [m.penetration(motion[::6], first.body, result.scene) for motion in motions],
        "in_others": m.penetration(
            first.motion[::6],
            first.body,
            hp.Scene(),
            people={name: (motion[::6], one) for name, (motion, one) in others.items()},
        ),
        "volume": m.penetrating_volume(result.reference[::20], first.body, result.scene),
    }


def labels(name: str) -> dict[str, Any]:
    """Contact labels and events, in their own layout and in those of data sets."""
    from halfphysics import labels

    result = simulated(name)
    found = labels.contact_labels(result)
    values: dict[str, Any] = {"labels": found, "events": labels.events(result).document()}
    if found.objects:
        values["behave"] = labels.behave(labels.contact_labels(result, reach=0.05))
        values["omomo"] = labels.omomo(found)
        values["chois"] = labels.chois(labels.contact_labels(result, reach=0.06))
    return values


def command(*arguments: str) -> None:
    """Run the command line in this process.

    Raises:
        RuntimeError: It did not end with 0; what it printed.
    """
    said, before = io.StringIO(), sys.argv
    sys.argv = ["halfphysics", *arguments]
    try:
        with redirect_stdout(said), redirect_stderr(said):
            runpy.run_module("halfphysics", run_name="__main__")
    except SystemExit as end:
        if end.code not in (None, 0):
            raise RuntimeError(f"exit code {end.code}: {said.getvalue()}") from None
    finally:
        sys.argv = before


def pictures(name: str) -> dict[str, Any]:
    """Pixels of pictures from several cameras, without text."""
    from PIL import Image

    result, out = simulated(name), {}
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "result.npz")
        result.save(file)
        for camera in ("follow", "top") if name != "solids" else ("follow",):
            picture = str(Path(folder) / f"{camera}.png")
            command("render", file, picture, "--frame", "20", "--size", "160x120",
                    "--camera", camera, "--no-text", "--threads", "1")  # fmt: skip
            with Image.open(picture) as image:
                out[camera] = np.asarray(image.convert("RGB"))
    return out


def cases() -> Iterator[Case]:
    """Everything of a few results."""
    kinds: tuple[Callable[[str], dict[str, Any]], ...] = (parts, metrics, labels, pictures)
    quick = {(parts, "solids"), (metrics, "solids"), (labels, "grasp_glass"), (pictures, "solids")}
    for run in kinds:
        for name in ("solids", "room", *SCENARIOS):
            yield Case(f"{run.__name__}/{name}", partial(run, name), (run, name) in quick)

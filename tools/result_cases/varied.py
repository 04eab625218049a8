"""What settings do not cover: other bodies, frame rates, gravity, firmness over time, sweeps."""

from __future__ import annotations

import io
import json
import tarfile
import tempfile
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import motion_values, result_values
from result_cases.measured import command
from result_cases.scenes import body, bowling, clip, clips, floor
from result_cases.settings import DRIVES

#: What is said of a sample that does not come from it: which program made it and what for.
ABOUT = ("versions", "plan", "settings", "sources")


def shaped(betas: float, stature: float | None, changes: Mapping[str, Any]) -> dict[str, Any]:
    """A kick among solids by a body of another shape."""
    numbers = None if stature else betas * np.cos(np.arange(10.0))
    one = hp.Body.default(numbers, stature=stature)
    motion = clip("asap_kick1").grounded(one)
    return result_values(hp.simulate(motion, bowling(), body=one, settings=hp.Settings(**changes)))


def rate(name: str, fps: float, changes: Mapping[str, Any]) -> dict[str, Any]:
    """A scenario at another frame rate."""
    told = hp.scenarios.load(name, fps=fps)
    settings = hp.Settings(**changes)
    return result_values(hp.simulate(told.motion, told.scene, body=told.body, settings=settings))


def gravity(vector: tuple[float, float, float]) -> dict[str, Any]:
    """A person and things under another gravity, with frictions of pairs and parts."""
    scene = hp.Scene(vector)
    for name, static in bowling().statics.items():
        scene.add_static(name, static.shape, position=static.position, friction=0.7)
    scene.add_object("ball", hp.Sphere(0.11), mass=0.43, position=(0.3, 0.0, 0.12))
    scene.add_object("crate", hp.Box((0.3, 0.3, 0.3)), density=100.0, position=(0.4, 0.2, 0.151))
    scene.friction("ball", "crate", 0.1)
    scene.friction("person/left_foot", "floor", 0.05)
    scene.friction("person", "crate", 0.3)
    scene.ignore("post", "person")
    return result_values(hp.simulate(clip("asap_kick1"), scene, body=body()))


def over_time(each: bool) -> dict[str, Any]:
    """Firmness that changes from frame to frame: one number, or one for each joint."""
    motion = clip("asap_kick3")
    firm = np.abs(np.sin(np.linspace(0.0, 4.0, len(motion))))
    if each:
        firm = firm[:, None] * np.linspace(0.1, 3.0, 55)
    settings = hp.Settings(drive_time=None, substeps=8)
    return result_values(
        hp.simulate(motion, bowling(), body=body(), settings=settings, stiffness=firm)
    )


def parameters(name: str) -> dict[str, Any]:
    """A clip as SMPL-X parameters and back, in other axes, and as the sequence of its file."""
    motion = clip(name)
    given = motion.to_smplx()
    again = hp.Motion.from_smplx(fps=motion.fps, **given)
    sequence = hp.load_sequence(clips()[name])
    return {
        "parameters": given,
        "again": motion_values(again),
        "rebased": motion_values(motion.rebased(body(), "y")),
        "sequence": [motion_values(one) for one in sequence.motions],
        "clips": [Path(str(one)).name for one in hp.clips(clips()[name])],
    }


def sweep() -> dict[str, Any]:
    """A small sweep of two scenarios: the arrays and cards of its samples."""
    plan = {
        "inputs": [{"scenarios": ["kick_ball", "place_glass"]}],
        "bodies": ["own", {"stature": 1.6}],
        "factors": {
            "objects.friction": {"uniform": [0.2, 1.2]},
            "motion.yaw": {"normal": [0, 20], "within": [-45, 45]},
            "settings.contact": ["parts"],
        },
        "seed": 7,
        "labels": {"also": ["behave", "omomo"]},
        "outputs": {"folder": "out", "formats": ["webdataset"]},
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.json"
        path.write_text(json.dumps(plan))
        command("sweep", str(path), "--jobs", "1")
        return {tar.name: _samples(tar) for tar in sorted(Path(folder).rglob("*.tar"))}


def _samples(path: Path) -> dict[str, Any]:
    out: dict[str, Any] = {}
    with tarfile.open(path) as tar:
        for member in sorted(tar.getnames()):
            file = tar.extractfile(member)
            raw = file.read() if file is not None else b""
            if member.endswith(".npz"):
                with np.load(io.BytesIO(raw)) as arrays:
                    out[member] = {key: arrays[key] for key in sorted(arrays)}
            elif member.endswith(".json"):
                card = {k: v for k, v in json.loads(raw).items() if k not in ABOUT}
                out[member] = json.dumps(card, sort_keys=True)
    return out


def alone() -> dict[str, Any]:
    """A person who stands on a floor that slopes, limp, and falls."""
    scene = hp.Scene()
    scene.add_static("slope", hp.Plane(normal=(0.2, 0.1, 1.0)), friction=0.4)
    scene.add_static("step", hp.Box((0.5, 0.5, 0.2)), position=(-0.4, -0.3, 0.1))
    settings = hp.Settings.paper(0.0, contact="parts")
    return result_values(hp.simulate(clip("asap_squat3"), scene, body=body(), settings=settings))


def late() -> dict[str, Any]:
    """Steps of changing length."""
    motion, out = clip("asap_walk1"), []
    simulator = hp.Simulator(floor(), body=body(), fps=motion.fps)
    simulator.reset(motion[0])
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t], dt=(0.02, 1.0 / 30.0, 0.05)[t % 3])
        out.append((frame.pose.translation, frame.pose.rotations, frame.torque, frame.clearance))
    return {"frames": out}


def cases() -> Iterator[Case]:
    """All of it, with both drives where that matters."""
    for drive, changes in DRIVES.items():
        for what, betas, stature in (("round", 2.0, None), ("thin", -2.0, None),
                                     ("small", 0.0, 1.4), ("tall", 0.0, 2.0)):  # fmt: skip
            run = partial(shaped, betas, stature, changes)
            yield Case(f"varied/{what}/{drive}", run, what == "round" and drive == "drive")
        for name in ("kick_ball", "walk_into_wall", "place_glass", "meet"):
            for fps in (24.0, 60.0):
                yield Case(f"varied/{name}_{fps:g}/{drive}", partial(rate, name, fps, changes))
    for what, vector in (("none", (0.0, 0.0, 0.0)), ("aslant", (1.0, 2.0, -8.0))):
        yield Case(f"varied/gravity_{what}", partial(gravity, vector), what == "aslant")
    yield Case("varied/firm_over_time", partial(over_time, False))
    yield Case("varied/firm_over_time_each", partial(over_time, True), True)
    for name in ("asap_walk1", "animdraw_dab"):
        yield Case(f"varied/parameters/{name}", partial(parameters, name), name == "animdraw_dab")
    yield Case("varied/falls", alone, True)
    yield Case("varied/late", late, True)
    yield Case("varied/sweep", sweep, True)

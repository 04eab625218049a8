"""What is shown of an object is a line or two, whatever it holds."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.short_repr import MOST, changed_repr, counted, numbers, short_repr
from halfphysics.labels import contact_labels
from support import small_results as small

#: Letters of two lines of a notebook.
TWO_LINES = 2 * 100


def simulator():
    made = hp.Simulator(small.scene(), body=[hp.Body.default()] * 2, fps=30.0)
    made.reset([motion[0] for motion in small.motions()])
    return made


def person():
    return small.result().people[0]


def body():
    return hp.Body.default()


THINGS = {
    "Result(24 frames at 30 fps, 2 people, 4 objects, 197 contacts)": small.result,
    "PersonResult(person0: 24 frames at 30 fps, root up to 212 mm off its path)": person,
    "Contacts(197 rows in frames 1 to 23, ": lambda: small.result().contacts,
    "Contacts(2 rows in frame 1, ": lambda: small.result().contacts[:2],
    "Contacts(none)": lambda: small.result().contacts[:0],
    "Inside(none)": lambda: small.result().inside,
    "Breaches(none)": lambda: small.result().breaches,
    "Simulator(2 people, 3 statics, 4 objects, 30 fps: running)": simulator,
    "Frame(2 people, 4 objects, ": lambda: simulator().step([m[1] for m in small.motions()]),
    "Frame(1 person, 0 objects, 0 contacts, ": lambda: hp.Simulator(hp.Scene(), fps=30.0).reset(
        small.motions()[0][0]
    ),
    "World(2 people, 3 statics, 4 objects)": lambda: simulator().world,
    "Person(name='person0', ": lambda: simulator().world.people[0],
    "State(": lambda: simulator().get_state(),
    "Motion(24 frames at 30 fps, 0.77 s, smplx neutral, no betas)": lambda: small.motions()[0],
    "Pose(55 joints, translation (-0.30, 0.00, 0.95) m)": lambda: small.motions()[0][0],
    "Body(free neutral, 1.728 m, 13718 vertices)": body,
    "Scene(statics=['floor', 'wall', 'ramp'], objects=['box', 'crate', 'platform']": small.scene,
    "Settings()": hp.Settings,
    "Settings(stiffness={'arms': 2.0}, substeps=4)": lambda: None,
    "Torque(stiffness=2.0)": lambda: hp.baselines.Torque(stiffness=2.0),
    "Kinematic()": hp.baselines.Kinematic,
    "Sequence(motion=": lambda: hp.scenarios.load("meet"),
    "Substeps(185 poses at 240 per second, 2 people, 4 objects)": lambda: small.result().substeps,
    "ObjectTrack(24 frames, (-2.00, -2.00, 0.20) to (": lambda: small.result().objects["crate"],
    "Mesh(6 vertices, 8 triangles, (1.00, 1.00, 1.00) m)": lambda: hp.Mesh(*small.WEDGE),
    "Object(name='box', shape=Box(size=(0.3, 0.3, 0.3)), mass=2, ": lambda: small.scene().objects[
        "box"
    ],
    "KinematicObject(name='platform', ": lambda: small.scene().objects["platform"],
    "Static(name='ramp', shape=Mesh(6 vertices, ": lambda: small.scene().statics["ramp"],
    "{'planes': array(24), ": lambda: small.result().diagnostics,
    "Verdict(": lambda: hp.metrics.judge(small.motions()[0], body()),
    "PartReport(clearance=array(24, 55), ": lambda: small.alone().parts(0),
    "Support(24 frames, ": lambda: person().support,
    "Pressure(": lambda: person().support.pressure,
    "Pressure(none)": lambda: person().support.pressure[:0],
    "ContactLabels(threshold_m=0.002, ": lambda: contact_labels(small.alone()),
    "NetForceReport(weight=": lambda: hp.metrics.net_force(small.alone(), 0),
    "PenetrationReport(rate_percent=": lambda: hp.metrics.penetration(
        small.motions()[0], body(), small.scene()
    ),
}
del THINGS["Settings(stiffness={'arms': 2.0}, substeps=4)"]


@pytest.mark.parametrize("start", THINGS)
def test_what_is_shown(start):
    shown = repr(THINGS[start]())
    assert shown.startswith(start)
    assert "\n" not in shown
    limit = 400 if start.startswith("{") else TWO_LINES
    assert len(shown) <= limit


def test_settings_show_what_was_changed_and_can_be_pasted():
    settings = hp.Settings(stiffness={"arms": 2.0}, substeps=4, tolerance=1.2345678901e-6)
    assert repr(settings) == (
        "Settings(substeps=4, stiffness={'arms': 2.0}, tolerance=1.2345678901e-06)"
    )
    assert eval(repr(settings), {"Settings": hp.Settings}) == settings
    for kind in (hp.Settings, hp.baselines.Torque, hp.baselines.EngineKinematic):
        assert kind.__dict__["__repr__"] is changed_repr


@dataclass
class Wide:
    rows: np.ndarray = field(default_factory=lambda: np.zeros((7, 3)))
    none: None = None
    ratio: float = 1.0 / 3.0
    names: tuple[str, ...] = ("a", "b", "c", "d")
    few: tuple[int, ...] = (1, 2)
    table: dict = field(default_factory=lambda: {str(k): k for k in range(9)})
    text: str = "x" * 200
    _own: int = 3

    __repr__ = short_repr


def test_values_of_all_kinds():
    assert repr(Wide()) == ("Wide(rows=array(7, 3), ratio=0.333333, table={9 entries})")
    given = Wide(names=tuple("abcde"), few=(3, 4), text="y" * 200)
    assert repr(given) == (
        "Wide(rows=array(7, 3), ratio=0.333333, names=(5 entries), few=(3, 4), "
        "table={9 entries}, text=str(...))"
    )


def test_fields_that_do_not_fit_are_left_out():
    @dataclass
    class Long:
        __repr__ = short_repr

    fields = {f"field_{k}": (float, float(k)) for k in range(50)}
    kind = dataclass(
        type(
            "Long",
            (),
            {"__annotations__": {n: t for n, (t, _) in fields.items()}} | {"__repr__": short_repr},
        )
    )
    shown = repr(kind(**{n: v for n, (_, v) in fields.items()}))
    assert shown.endswith(", ...)")
    assert len(shown) < MOST + 20


def test_words():
    assert counted(1, "person", "people") == "1 person"
    assert counted(1_234, "row") == "1,234 rows"
    assert numbers([1.0, -0.001, 2.346]) == "(1.00, 0.00, 2.35)"

"""The card of a sample: its description of a simulation, the same on every machine."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.json_files import text_of
from halfphysics.baselines import options_of
from halfphysics.labels import events
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.motion.motion import Motion
from halfphysics.results.inside import Inside
from halfphysics.results.result import ObjectTrack
from halfphysics.results.soft_contacts import SoftContacts
from halfphysics.settings import Settings
from halfphysics.sweep.make.card import Checks, card_of, checks
from halfphysics.sweep.make.making import Maker
from halfphysics.sweep.make.provenance import versions
from halfphysics.sweep.make.vary import Ready
from halfphysics.sweep.plan.plan import OF_RESULT, Inputs, Outputs, Plan
from halfphysics.sweep.plan.variants import Variants
from support.paths import DOCS
from support.results.handled import Handled
from support.standing import ARMS_DOWN, raised, still

LABELS = SimpleNamespace(threshold_m=0.002)


def plan_of(base=Path(), **options):
    given = {"inputs": (Inputs(scenarios=("kick_ball",)),), "factors": {"object.ball.mass": [0.5]}}
    return Plan(**{**given, **options}, base=base)


def held():
    """A box that is held for 2 s, then falls 0.8 m."""
    time = np.arange(90) / 30.0
    box = np.tile([0.0, 0.0, 1.2], (90, 1))
    box[:, 2] = np.maximum(1.2 - 4.905 * np.maximum(time - 2.0, 0.0) ** 2, 0.4)
    case = Handled(30.0, box)
    case.push(range(1, 61), 1.0, 5.0)
    case.rest(range(73, 90))
    return case.result()


def card(result, *, motions=None, sources=(), plan=None, line="scenario\tkick_ball\t0"):
    plan = plan or plan_of()
    ready = Ready(
        motions=motions or tuple(p.reference for p in result.people),
        scene=result.scene,
        bodies=tuple(p.body for p in result.people),
        settings=result.settings,
        sources=sources,
    )
    variant = Variants(plan, [line])[0]
    return card_of(plan, variant, ready, result, LABELS, events(result))


def changed(result, **fields):
    return replace(result, scene=result.scene, **fields)


def test_a_card_says_what_it_was_made_from():
    plan = plan_of(seed=7)
    found = card(held(), plan=plan, sources=({"path": "a/b.npz", "sha256": "00"},))
    assert (found["number"], found["seed"], found["plan"]) == (0, 7, plan.identity)
    assert (found["input"], found["body"], found["scene"]) == ("kick_ball", "own", "own")
    assert found["factors"] == {"object.ball.mass": 0.5}
    assert found["settings"]["stiffness"] == 1.0
    assert set(found["settings"]) == set(options_of(Settings()))
    assert found["sources"] == [{"path": "a/b.npz", "sha256": "00"}]
    assert found["versions"] == versions()
    assert set(OF_RESULT) <= set(found)


def test_a_card_says_what_happened():
    result = held()
    found = card(result)
    assert (found["frames"], found["fps"]) == (90, 30.0)
    assert found["seconds"] == pytest.approx(89 / 30.0)
    assert found["success"] is True
    assert found["checks"] == {"whole": True, "finite": True, "clear": True, "in_time": True}
    assert (found["holds"], found["slips"], found["drops"], found["lost_grasps"]) == (1, 0, 1, 1)
    assert found["held_seconds"] == pytest.approx(2.0)
    assert found["contacts"] == 60 + 17
    assert found["threshold_m"] == 0.002
    # Each frame of the hold: 5 times its weight sideways, once upward.
    weight = 9.81
    assert found["force_max"] == pytest.approx(np.sqrt(26.0) * weight)
    assert found["impulse"] == pytest.approx(60 * np.sqrt(26.0) * weight / 30.0)
    assert found["objects"]["box"]["travel"] == pytest.approx(0.8)
    assert found["objects"]["box"]["turn_max"] == 0.0
    assert found["travel_max"] == pytest.approx(0.8)
    assert found["clearance_min"] == result.settings.clearance_range  # no item is nearer
    assert found["events"]["drops"][0]["onto"] == "floor"
    assert found["held"] == []  # no hand was adapted to it


def test_a_card_says_what_adapted_hands_did():
    result = held()
    (person,) = result.people
    still = np.tile([1.0, 0.0, 0.0, 0.0], (90, 1))
    hold = AdaptedHold("box", ("left_wrist",), 10, 50, 40.0, (0.02,), np.zeros((90, 3)), still)
    reference = replace(person.reference, holds=(hold,), recorded=person.reference)
    adapted = replace(person, body=person.body, reference=reference)
    found = card(changed(result, people=(adapted,)))
    (hand,) = found["held"]
    assert (hand["object"], hand["part"], hand["asked"]) == ("box", "left_wrist", 40.0)
    assert hand["start"] == pytest.approx(10 / 30.0)
    json.dumps(found, allow_nan=False)


def test_what_holds_people_up_is_in_the_card_of_a_plan_that_asks():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    standing = still(hp.Body.default(), ARMS_DOWN)
    hovering = raised(standing, 0.3)
    motions = [standing, hp.Motion(hovering.translation + 2.0, hovering.rotations, hovering.fps)]
    result = hp.simulate(motions, scene, settings=hp.Settings(weight=False))
    plain = card(result)
    assert plain["unsupported_percent"] is plain["carried_max"] is None
    asked = card(result, plan=plan_of(outputs=Outputs(support=True)))
    assert asked["unsupported_percent"] == 100.0  # of the second person
    assert asked["carried_max"] == pytest.approx(1.0, abs=0.01)  # of the first


def test_deviation_is_that_of_the_joints():
    """12 cm beside the reference from frame 30 of 90 on, in the same pose."""
    result = held()
    (person,) = result.people
    asked = np.array(person.motion.translation)
    asked[30:, 1] -= 0.12
    reference = person.motion.with_frames(asked, person.motion.rotations)
    beside = replace(person, reference=reference, body=person.body)
    found = card(changed(result, people=(beside,)))
    assert found["joint_error_max_mm"] == pytest.approx(120.0)
    assert found["joint_error_mean_mm"] == pytest.approx(80.0)
    assert found["pose_error_mean_mm"] == pytest.approx(0.0, abs=1e-9)


def inside(*frames):
    n = len(frames)
    columns = {name: np.zeros(n, dtype=np.int64) for name in ("person", "part", "other")}
    return Inside(frame=np.array(frames), subject=np.full(n, -1), depth=np.full(n, 0.01), **columns)


@pytest.mark.parametrize(
    ("what", "clear", "started"),
    [
        ({}, True, 0),
        ({"inside": inside(0, 1, 2)}, True, 1),  # penetration is resolved
        ({"inside": inside(0, 1, 2, 40)}, False, 1),  # and occurs again
        ({"inside": inside(40)}, False, 0),
        ({"inside": inside(*range(90))}, False, 1),  # penetration is never resolved
        ({"clearance": np.where(np.arange(90) == 40, -1e-6, 0.01)}, False, 0),
        ({"clearance": np.where(np.arange(90) < 3, -0.01, 0.0)}, True, 0),
    ],
)
def test_clear_is_never_lost_after_a_clear_frame(what, clear, started):
    found = card(changed(held(), **what))
    assert found["checks"] == {"whole": True, "finite": True, "clear": clear, "in_time": True}
    assert found["success"] is clear
    assert found["started_inside"] == started
    if "clearance" in what:
        assert found["clearance_min"] == min(what["clearance"])


def test_a_blocked_step_is_no_success():
    found = card(changed(held(), lost_time=np.where(np.arange(90) == 5, 1e-3, 0.0)))
    assert found["checks"]["in_time"] is False
    assert found["success"] is False
    assert found["lost_time"] == 1e-3


def test_frames_that_did_not_come_back_are_no_success():
    result = held()
    reference = result.reference
    more = Motion(
        np.concatenate([reference.translation, reference.translation[-1:]]),
        np.concatenate([reference.rotations, reference.rotations[-1:]]),
        reference.fps,
    )
    found = checks(result, [more])
    assert found == Checks(whole=False, finite=True, clear=True, in_time=True)
    assert found.failed == ["whole"]


def test_what_is_not_finite_is_null_and_no_success():
    result = held()
    track = result.objects["box"]
    broken = ObjectTrack(position=np.array(track.position), quaternion=track.quaternion)
    broken.position.setflags(write=True)
    broken.position[50] = np.nan  # as a defect of the core would
    object.__setattr__(result, "objects", {"box": broken})
    found = card(result)
    assert found["checks"]["finite"] is False
    assert found["objects"]["box"]["travel"] is None
    text_of(found)


def test_cards_are_json_of_the_same_bytes_each_time():
    one, other = (text_of(card(held())) for _ in range(2))
    assert one == other
    assert json.loads(one) == card(held())


def test_the_documentation_says_what_every_value_is():
    page = (DOCS / "sweeps.md").read_text()
    table = page.partition("## The card of a sample")[2].partition("## ")[0]
    found = card(held())
    named = set(re.findall(r"`(\w+)`", table))
    assert set(found) <= named
    assert set(found["checks"]) <= named
    assert set(found["objects"]["box"]) <= named
    assert set(found["versions"]) <= named


def test_no_folder_of_a_machine_is_in_a_card(tmp_path):
    """Files below the plan's folder by relative path, others as the plan says or by name."""
    there = tmp_path / "there"
    base = tmp_path / "plans"
    there.mkdir()
    base.symlink_to(there)
    plan = plan_of(
        base=base, inputs=(Inputs(files=("../clips/*.npz",)),), factors={"objects.mass": [1.0]}
    )
    places = {
        tmp_path / "clips" / "a.npz": "../clips/a.npz",
        base / "room" / "table.obj": "room/table.obj",
        there / "room" / "chair.obj": "room/chair.obj",
        Path("/somewhere/models/SMPLX_NEUTRAL.npz"): "SMPLX_NEUTRAL.npz",
    }
    sources = tuple({"path": str(path), "sha256": "01"} for path in places)
    found = card(held(), plan=plan, sources=sources, line="file\t../clips/a.npz\t0")
    assert [s["path"] for s in found["sources"]] == list(places.values())
    assert str(tmp_path) not in text_of(found)


def test_the_sample_of_a_variant_has_its_card(tmp_path):
    plan = plan_of(base=tmp_path)
    maker = Maker(plan, Variants(plan, ["scenario\tkick_ball\t0"]))
    sample = maker.sample(0)
    assert json.loads(sample.files["card.json"]) == sample.card
    assert sample.card["success"] is True
    assert sample.card["objects"]["ball"]["travel"] > 1.0
    assert sample.card["drops"] == sample.card["holds"] == 0
    assert maker.sample(0).files == sample.files


def test_a_card_has_the_pressures_on_soft_things_or_zeros():
    assert card(held())["pressure_max"] == card(held())["pressure_area"] == 0.0
    result = held()
    box, person = result.names.index("box"), result.names.index(result.people[0].name)
    rows = SoftContacts(
        frame=np.array([3, 3]),
        layer=np.array([box, box]),
        other=np.array([person, person]),
        part=np.array([20, 20]),
        vertex=np.array([5, 6]),
        position=np.zeros((2, 3)),
        normal=np.tile([0.0, 0.0, 1.0], (2, 1)),
        depth=np.full(2, 0.01),
        pressure=np.array([4e3, 2e3]),
        area=np.array([1e-4, 3e-4]),
    )
    found = card(changed(result, soft_contacts=rows))
    assert found["pressure_max"] == 4e3
    assert found["pressure_mean"] == pytest.approx(2.5e3)
    assert found["pressure_area"] == pytest.approx(4e-4)
    json.dumps(found, allow_nan=False)

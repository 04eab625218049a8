"""Skin pressed into furniture stays outside: judged by `skin_judge`, from clear starts.

A sample of `postures`, throws and rooms runs always. `HALFPHYSICS_SKIN=all` (or `k/n`: every n-th
case from k on) runs `campaigns.skin` instead, its rows in `HALFPHYSICS_SKIN_LOG` (out/skin.jsonl),
for at most `HALFPHYSICS_SKIN_SECONDS`.
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from campaigns.clear import clips
from campaigns.skin import (
    SEATED,
    WHO,
    Case,
    all_cases,
    body_of,
    campaign,
    complaints,
    contacts,
    first_contact,
    run,
    summary,
)
from halfphysics.motion.skeleton import JOINT_NAMES
from support.judges.skin_judge import SkinJudge
from support.paths import ROOT
from support.postures.bumps import PLACES
from support.postures.furniture import KINDS
from support.postures.postures import CLEAR, build

pytest.importorskip("trimesh")

WANTED = os.environ.get("HALFPHYSICS_SKIN", "")
SECONDS = float(os.environ.get("HALFPHYSICS_SKIN_SECONDS", "inf"))
LOG = Path(os.environ.get("HALFPHYSICS_SKIN_LOG", ROOT / "out" / "skin.jsonl"))
needs_skin = pytest.mark.skipif(
    "skin" not in contacts(), reason="Settings(contact='skin') is not in this build"
)
#: A case is demanding: its target is at least this deep [m], between rods 8 mm thick.
TRIVIAL = 0.002

#: Ways of pressing (a seat, a back, a trunk, a hand closed around things, joints, creases of the
#: skin), in turn among furniture of every kind, with every setting. These are simulated and judged.
SAMPLE = (
    Case("sit_chair", "meshes"),
    Case("sit_back", "primitives", drive=None),
    Case("sit_sofa", "merged", 30.0, 1, stiffness=10.0),
    Case("sit_stool_corner", "sheets", stiffness=0.0),
    Case("lie_side", "primitives", stiffness=0.0, drive=None),
    Case("crouch", "primitives", pace=3.0),
    Case("hand_on_table", "sheets"),
    Case("grip_pole_5cm", "meshes", 60.0, 4),
    Case("grip_plate", "primitives", drive=None),
    Case("grip_wedge", "meshes", 30.0, 8),
    Case("hip_table_corner", "meshes", seed=2),
    Case("knee_chair", "primitives", seed=4),
    Case("crotch-pole5cm", "meshes", drive=None),
    Case("knee-edge90", "merged", 30.0, 1, stiffness=0.0),
    Case("neck-board", "sheets", pace=3.0),
    Case("hip_crease-edge30", "primitives", 30.0, 4, seed=len(WHO) - 1),
)
#: Others that are alike: their cases are looked at here, `campaigns.skin` simulates them.
ALIKE = (
    Case("deep_squat", "primitives", 60.0, 4, seed=1),
    Case("lie_supine", "meshes", 30.0, 1),
    Case("lie_on_pole", "merged"),
    Case("kneel", "merged", drive=None, stiffness=10.0),
    Case("elbows_on_table", "meshes", seed=3),
    Case("grip_pole_2cm", "primitives"),
    Case("poke_corner", "merged", 30.0, 1, pace=3.0),
    Case("fist_on_edge", "primitives", stiffness=10.0),
    Case("head_shelf", "sheets"),
    Case("armpit-pole2cm", "primitives"),
)
#: The furniture is plane where they press.
FLAT = [
    c
    for c in SAMPLE
    if c.name in ("sit_chair", "sit_back", "sit_sofa", "lie_side", "crouch", "hand_on_table")
]
#: With 1 mm of clearance [m].
TOUCHING = 0.002
#: Median and 95 % of the distance at first contact [m], with 1 mm of clearance.
VISIBLE = (0.0015, 0.006)
#: Algorithm 1 closes a hand around a plate with its full torque: there the clearance is reduced.
SITTING = [c for c in SAMPLE if c.name.startswith(("sit", "grip")) and c.drive is not None]


@cache
def row_of(case, contact):
    """Run once."""
    return run(case, contact=contact)


def ids(some):
    return [c.id.removeprefix("posture-") for c in some]


# -- the cases match their names -------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("case", SAMPLE + ALIKE, ids=ids(SAMPLE + ALIKE))
def test_a_case_starts_clear_and_asks_for_something(case):
    body = body_of(case.who)
    made = build(case.name, body, "primitives", case.fps, case.seed, pace=case.pace)
    judge = SkinJudge(body, made.scene)
    chosen = np.linspace(0, len(made.motion) - 1, 12).astype(int)
    few = made.motion.with_frames(
        made.motion.translation[chosen], made.motion.rotations[chosen], fps=10.0
    )
    verdict = judge.judge_motion(few)
    assert verdict.start > 0.9 * CLEAR
    assert 0 not in verdict.cut
    assert verdict.depth > TRIVIAL
    assert judge.penetration(few)[0] > 0.0
    if made.parts:
        skin = body.vertices(few)
        pressing = np.isin(judge.skin.part, [JOINT_NAMES.index(p) for p in made.parts])
        assert (
            max(
                thing.piece.depths(thing.local(points[pressing], 0)).max()
                for thing in judge.statics
                for points in skin
            )
            > TRIVIAL
        )


@cache
def pressed_into(name, kind):
    """The verdict on a posture's last pose but a few, in furniture of a kind."""
    body = body_of()
    made = build(name, body, kind)
    return SkinJudge(body, made.scene, samples=100).judge_motion(made.motion[-14:-12])


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_furniture_of_every_kind_is_in_the_same_place(kind):
    """All of them cut the last pose; sheets have no inside and so no depth."""
    for name in ("sit_chair", "knee-edge90", "hip_table_corner"):
        verdict = pressed_into(name, kind)
        assert len(verdict.cut) == len(verdict.coal) == 2
        if kind != "sheets":
            # Boxes and wedges are the same; a floor is as deep as its slab.
            theirs = pressed_into(name, "primitives")
            assert verdict.depth == pytest.approx(theirs.depth, abs=1e-9)


@pytest.mark.slow
def test_what_rigid_parts_leave_inside_is_found():
    """The judge is not too lenient: a bent knee is outside its parts' hulls."""
    row = row_of(Case("knee_chair", "primitives"), "parts")
    assert row["depth_mm"] > 5.0
    assert row["metric_mm"] > 5.0
    assert row["cut"] > 50
    assert row["coal"] > 10
    assert complaints(row)


# -- the skin stays out ------------------------------------------------------------------------


@pytest.mark.slow
@needs_skin
@pytest.mark.parametrize("case", SAMPLE, ids=ids(SAMPLE))
def test_the_skin_stays_out(case):
    row = row_of(case, "skin")
    assert not complaints(row), complaints(row)


@pytest.mark.slow
@needs_skin
@pytest.mark.parametrize("case", SITTING, ids=ids(SITTING))
def test_sitting_and_grasping_keep_the_distance(case):
    row = row_of(case, "skin")
    assert row["gap_mm"] >= 1e3 * SEATED


@pytest.mark.slow
@needs_skin
@pytest.mark.parametrize("case", FLAT, ids=ids(FLAT))
def test_flat_things_are_touched(case):
    """Hulls of the skin touch a plane with the skin itself: no gap remains."""
    assert row_of(case, "skin")["gap_mm"] <= 1e3 * TOUCHING


@pytest.mark.slow
@needs_skin
@pytest.mark.parametrize("case", SAMPLE, ids=ids(SAMPLE))
def test_no_time_is_lost(case):
    assert row_of(case, "skin")["lost"] == 0.0


@pytest.mark.slow
@needs_skin
@pytest.mark.parametrize(("tool", "every"), [("pole2cm", 1), ("edge90", 3)])
def test_the_visible_gap_is_small(tool, every):
    """Hulls bridge the hollows of the skin; thin objects do not reach it there."""
    gaps = [
        first_contact(Case(f"{place}-{tool}", fps=60.0, substeps=4))
        for place in list(PLACES)[::every]
    ]
    assert None not in gaps
    assert np.median(gaps) <= VISIBLE[0]
    assert np.percentile(gaps, 95) <= VISIBLE[1]


@pytest.mark.slow
@needs_skin
def test_throws_stay_out():
    some = [c for c in all_cases(None, kinds=("throw",)) if c.speed == 5.0 and c.substeps == 4]
    rows = [run(c) for c in some[:3]]
    assert not [text for row in rows for text in complaints(row)]


@pytest.mark.slow
@needs_skin
def test_real_clips_stay_out(shared_data):
    quick = [
        c
        for c in all_cases(shared_data, kinds=("room",))
        if c.speed == 4.0 and c.fps * c.substeps == 120.0
    ]
    # The shortest; `campaigns.clear` has a sample of every clip.
    row = run(min(quick, key=lambda c: clips(shared_data)[c.what].duration), shared_data)
    assert row["touched"]
    assert not complaints(row)


@needs_skin
@pytest.mark.skipif(not WANTED, reason="HALFPHYSICS_SKIN is not set: the campaign runs on demand")
def test_campaign():
    data = os.environ.get("HALFPHYSICS_TEST_DATA")
    k, n = (0, 1) if WANTED == "all" else map(int, WANTED.split("/"))
    LOG.parent.mkdir(parents=True, exist_ok=True)
    some = all_cases(None if data is None else Path(data), seeds=3)[k::n]
    rows = campaign(some, None if data is None else Path(data), LOG, "skin", SECONDS)
    print(f"\n{summary(rows)}")
    assert rows
    bad = [f"{row['id']}: {text}" for row in rows for text in complaints(row)]
    assert not bad, "\n".join(bad)

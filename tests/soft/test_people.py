"""People who lie and sit on foam: what carries them, at every rate."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from evidence.runs.lying import held, lying, sitting
from halfphysics import scenarios
from halfphysics.bench.clips import body as bench_body
from halfphysics.bench.soft import BED, SEAT, story
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.layer_pressure import SHOWN
from halfphysics.results.pressure_maps import pressure_map
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.judges.skin_judge import SkinJudge
from support.people import along_x
from support.soft.frames import hard
from support.soft.skin_pressure import pressed

pytestmark = pytest.mark.slow

#: What carries who sits may miss the weight by this share.
SEATED = 0.01
#: Who sits presses most at this distance from the middle of the body, which no fold does [m]: sit
#: bones are 10 to 13 cm apart, and people have more of a seat under them than bones.
SIT_BONES, CLEFT = (0.03, 0.09), 0.015
#: Height of the mattress [m].
TOP = 0.45
#: Depths at rest at other frame rates and substeps may differ by this share, joints by this [m].
OTHER_RATE, AWAY = 0.005, 2e-3
#: Frames of the story until the hands are on the back of the sofa; fingers that press with less
#: than this [N] are not looked at, and contacts of the others may miss this share of the pressures.
BACK, LIGHT, FELT = 47, 0.1, 0.02
#: Frame rates and substeps a frame.
STEPS = [(30, 4), (30, 8), (30, 16), (60, 4), (60, 8), (120, 4)]


def played(what, fps=30.0, substeps=8, **settings):
    told = story(what)
    motion = told.motions[0]
    motion = held(motion if fps == motion.fps else motion.resample(fps))
    chosen = Settings(substeps=substeps, **settings)
    return simulate(motion, told.scene, body=told.bodies[0], settings=chosen)


@pytest.fixture(scope="module")
def in_bed():
    return {steps: played(BED, *steps) for steps in STEPS}


def test_a_mattress_carries_who_lies_on_it(in_bed):
    share = lying(in_bed[30, 8])["share of the weight"]
    assert share == pytest.approx(100.0, abs=1.0)


@pytest.mark.parametrize("steps", STEPS, ids=str)
def test_who_lies_sinks_as_deep_at_every_rate(in_bed, steps):
    """Depth of the pelvis in the mattress, and where the joints end."""
    finest = in_bed[30, 16]
    body = finest.people[0].body
    pelvis = body.weights.argmax(axis=1) == 0
    depth = [
        TOP - body.vertices(r.motion, frames=[len(r) - 1])[0][pelvis, 2].min()
        for r in (in_bed[steps], finest)
    ]
    joints = [body.joints(r.motion[-1]) for r in (in_bed[steps], finest)]
    assert depth[0] == pytest.approx(depth[1], rel=OTHER_RATE)
    assert np.linalg.norm(joints[0] - joints[1], axis=1).max() < AWAY


def test_the_pressures_are_those_of_the_skin_where_it_is():
    """Load, area, peak and centre of pressure, by the triangles of the skin in the last pose."""
    stiffness = 6e4
    layer = hp.Soft(thickness=0.13, stiffness=stiffness, law="linear")
    told = scenarios.load("stretch_on_bed", body=bench_body(), soft=layer)
    scene = told.scene
    result = simulate(told.motions[0], scene, body=told.bodies[0], settings=Settings(substeps=8))
    body = result.people[0].body
    skin = body.vertices(result.motion, frames=[len(result) - 1])[0]
    bed = scene.statics["mattress"]
    low, high = (bed.position + s * 0.5 * np.asarray(bed.shape.size) for s in (-1.0, 1.0))
    inside = np.array([low[:2], high[:2]])
    seen = pressed(skin, body.faces, high[2], inside, stiffness, SHOWN)
    rows = result.soft_contacts
    last = rows.frame == len(result) - 1
    pressure, area = rows.pressure[last].astype(float), rows.area[last].astype(float)
    assert pressure @ area == pytest.approx(seen.load, rel=0.03)
    assert area[pressure >= SHOWN].sum() == pytest.approx(seen.area, rel=0.05)
    assert pressure.max() == pytest.approx(seen.peak, rel=0.05)
    centre = (pressure * area) @ rows.position[last][:, :2] / (pressure @ area)
    np.testing.assert_allclose(centre, seen.centre, atol=0.01)


def test_a_sofa_and_the_floor_carry_who_sits():
    result = played(SEAT)
    found = sitting(result)
    person = result.people[0]
    weight = 9.81 * sum(part.mass for part in person.body.variant.parts)
    seat = found["share of the weight on seat and rest"]
    feet = person.support
    assert 69.0 < seat < 81.0  # published: evidence/interface_pressures.py
    last = feet.force[-5:].sum(axis=1)[:, 2].mean()
    assert last == pytest.approx(weight, rel=SEATED)
    made = pressure_map(result, "seat")
    across = made.pressure[-1].max(axis=1)  # of rows of cells, from one hip to the other
    off = np.abs(made.cell * (np.arange(len(across)) + 0.5) + made.corner[1])
    aside = (off > SIT_BONES[0]) & (off < SIT_BONES[1])
    assert across[aside].max() == across.max()
    assert across[off < CLEFT].max() < 0.9 * across.max()


def test_nobody_enters_the_frame(in_bed):
    result = in_bed[30, 8]
    judge = SkinJudge(result.people[0].body, hard(result.scene))
    assert judge.judge_result(result, every=5, coal_every=10).clear


def test_what_a_person_presses_out_of_a_cushion_is_what_the_cushion_feels():
    """Newton's third law between a person and a free soft thing."""
    body = hp.Body.default()
    motion = along_x(0.5, 31, 0.0)
    x = float(body.vertices(motion, frames=[0])[0][:, 0].max())
    scene = hp.Scene(gravity=0.0)
    scene.add_object(
        "cushion",
        hp.Box((0.3, 0.6, 0.6)),
        mass=3.0,
        position=(x + 0.25, 0.0, 0.0),
        soft=hp.Soft(thickness=0.08, stiffness=2e4, law="linear"),
    )
    settings = Settings(substeps=8, weight=False, root="stay", blocked="continue")
    simulator = hp.Simulator(scene, body=body, settings=settings)
    simulator.reset(motion[0])
    place = simulator.world.objects[0]
    index, felt = simulator.names.index("cushion"), 0.0
    before = simulator.world.stepper.qvel()[place.dof : place.dof + 3].copy()
    for t in range(1, len(motion)):
        c = simulator.step(motion[t]).contacts
        after = simulator.world.stepper.qvel()[place.dof : place.dof + 3].copy()
        pushed = -c.impulse[c.other == index].sum(axis=0)
        np.testing.assert_allclose(3.0 * (after - before), pushed, atol=1e-9)
        felt += np.linalg.norm(pushed)
        before = after
    assert felt > 0.5


def test_fingers_press_with_their_hand_and_each_is_recorded():
    """Hands at rest on the back of the sofa: contacts of fingers are what their samples exert."""
    told = story(SEAT)
    motion = held(told.motions[0][:BACK])
    result = simulate(motion, told.scene, body=told.bodies[0], settings=Settings(substeps=8))
    last = len(result) - 1
    rows, contacts = result.soft_contacts, result.contacts
    soft = np.isin(contacts.other, np.unique(rows.layer)) & (contacts.frame == last)
    felt = {}
    for part, name in enumerate(JOINT_NAMES):
        own = rows.force[(rows.frame == last) & (rows.part == part), 0].sum()
        if name[-1] in "123" and "spine" not in name and own > LIGHT:
            impulse = contacts.impulse[soft & (contacts.part == part), 0].sum()
            felt[name] = impulse * result.motion.fps / own
    assert len(felt) == 28
    assert list(felt.values()) == pytest.approx([1.0] * 28, abs=FELT)


@pytest.mark.parametrize("towards", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
def test_a_cushion_at_a_knee_is_pressed_by_the_skin_alone(towards):
    """Small hulls have no samples of their own: nothing presses a person but its skin, so that all
    that a person feels is in the person's rows."""
    body = hp.Body.default()
    motion = along_x(0.0, 8, 0.0)
    hulls, skin = body.skin_hulls, body.vertices(motion[0])
    knee = JOINT_NAMES.index("left_knee")
    every = np.split(skin[hulls.vertex], hulls.first[1:-1])
    points = min((every[h] for h in np.flatnonzero(hulls.part == knee)), key=len)
    towards, middle = np.array(towards, float), points.mean(axis=0)
    far = (points @ towards).max() - middle @ towards
    scene = hp.Scene(gravity=0.0)
    scene.add_object(
        "cushion",
        hp.Sphere(0.08),
        mass=0.5,
        position=middle + (far + 0.085) * towards,
        velocity=-0.8 * towards,
        soft=hp.Soft(thickness=0.04, stiffness=2e5),
    )
    simulator = hp.Simulator(scene, body=body)
    simulator.reset(motion[0])
    felt = 0
    for t in range(1, len(motion)):
        contacts = simulator.step(motion[t]).contacts
        assert (contacts.person == 0).all()
        felt += len(contacts.part)
    assert felt > 2

"""Who rests on soft layers sinks until they carry what nothing else does."""

import functools

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX

BODY = hp.Body.default()
#: Pressures at rest miss the weight by so much of it.
MISSES = 0.01
#: The centre of pressure of who lies is this near to the centre of mass, along the ground [m]: 1 %
#: of the stature, two seconds after it lay down.
CENTRE = 0.017
#: Forces and moments that nothing supplies, as a share of the weight, and of the weight times the
#: stature.
NOTHING = 0.01
#: Who sits upright with the feet on nothing leans by so much at most [deg].
LEANS = 15.0
#: Sink and pose at rest by frame rate and substeps: share of the sink, and of a millimetre [m].
SAME_SHARE, SAME = 0.02, 1e-3


def standing(frames=75, fps=30.0, at=0.0):
    """Somebody who stands upright with bent knees, the soles at a height [m]."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    for side in ("left", "right"):
        for joint, bend in (("hip", -0.25), ("knee", 0.5), ("ankle", -0.25)):
            rotations[:, JOINT_INDEX[f"{side}_{joint}"], 0] = bend
    motion = hp.Motion(np.zeros((frames, 3)), rotations, fps)
    low = BODY.vertices(motion[0])[:, 2].min()
    return motion.with_frames(motion.translation + np.array([0.0, 0.0, at - low]), rotations)


def lying(frames=75, fps=30.0, at=0.0):
    """Somebody who lies on the back, arms beside the body, the lowest point at a height [m]."""
    rotations = np.zeros((frames, 55, 3))
    # Left is -y, up the body +x, ahead +z.
    back = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    rotations[:, 0] = rot.matrix_to_rotvec(back)
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotations[:, JOINT_INDEX[f"{side}_shoulder"], 2] = 1.1 * sign
    motion = hp.Motion(np.zeros((frames, 3)), rotations, fps)
    low = BODY.vertices(motion[0])[:, 2].min()
    return motion.with_frames(motion.translation + np.array([0.0, 0.0, at - low]), rotations)


def sitting(frames=90, fps=30.0, at=0.4):
    """Somebody who sits upright, legs stretched ahead, the lowest point at a height [m]."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotations[:, JOINT_INDEX[f"{side}_hip"], 0] = -1.6
        rotations[:, JOINT_INDEX[f"{side}_knee"], 0] = 0.3
        rotations[:, JOINT_INDEX[f"{side}_shoulder"], 2] = sign
    motion = hp.Motion(np.zeros((frames, 3)), rotations, fps)
    low = BODY.vertices(motion[0])[:, 2].min()
    return motion.with_frames(motion.translation + np.array([0.0, 0.3, at - low]), rotations)


def bed(soft="mattress", top=0.4):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static(
        "bed", hp.Box((2.4, 2.4, 0.3)), position=(0.0, 0.0, top - 0.15), friction=0.6, soft=soft
    )
    return scene


def weight(body=BODY):
    return body.mass * 9.81


def pressed(result, name, frames=15):
    """Mean upward force of a thing on the first person in the last frames [N]."""
    contacts = result.contacts
    some = contacts[(contacts.other == result.names.index(name)) & (contacts.subject < 0)]
    last = some.frame >= len(result) - frames
    return some.impulse[last, 2].sum() * result.fps / frames


@functools.cache
def rests(kind, soft, fps=30.0, substeps=None, shift=0.0):
    make = standing if kind == "stands" else lying
    motion = make(frames=round(2.5 * fps), fps=fps, at=0.4 + shift)
    settings = hp.Settings(substeps=substeps)
    return hp.simulate(motion, bed(soft), body=BODY, settings=settings)


def sink(result):
    """How far the lowest skin is below the unloaded surface at the end [m]."""
    return 0.4 - BODY.vertices(result.motion[-1])[:, 2].min()


@pytest.mark.parametrize("kind", ["stands", "lies"])
@pytest.mark.parametrize("soft", ["mattress", "mat"])
def test_the_pressures_of_a_layer_sum_to_the_weight(kind, soft):
    result = rests(kind, soft)
    assert pressed(result, "bed") == pytest.approx(weight(), rel=MISSES)
    assert sink(result) > 0.0


def test_a_clip_that_is_sunk_comes_to_rest_at_the_same_height():
    here, there = rests("lies", "mattress"), rests("lies", "mattress", shift=-0.02)
    assert pressed(there, "bed") == pytest.approx(weight(), rel=MISSES)
    assert sink(there) == pytest.approx(sink(here), abs=SAME)


@pytest.mark.parametrize(("fps", "substeps"), [(60.0, None), (120.0, None), (30.0, 16)])
def test_sink_and_pose_do_not_depend_on_frame_rate_and_substeps(fps, substeps):
    here, there = rests("lies", "mattress"), rests("lies", "mattress", fps=fps, substeps=substeps)
    assert sink(there) == pytest.approx(sink(here), rel=SAME_SHARE)
    away = BODY.joints(there.motion[-1]) - BODY.joints(here.motion[-1])
    assert np.abs(away[:22]).max() < 2.0 * SAME


def test_few_substeps_lie_nearly_alike():
    """Friction holds how the legs lie, and nothing but a weak spring asks for more."""
    here, there = rests("lies", "mattress"), rests("lies", "mattress", substeps=4)
    assert sink(there) == pytest.approx(sink(here), rel=SAME_SHARE)


def test_feet_sink_in_a_mattress_and_neither_curl_nor_drift():
    result = rests("stands", "mattress")
    toes = [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]
    assert np.degrees(np.abs(result.motion.rotations[:, toes])).max() < 12.0
    ankle = BODY.joints(result.motion)[:, JOINT_INDEX["left_ankle"]]
    assert np.linalg.norm((ankle[-1] - ankle[-31])[:2]) < SAME
    assert sink(result) > 0.02


def test_support_has_what_the_layer_carries():
    result = rests("lies", "mattress")
    support = result.people[0].support
    force, centre = support.surface("bed")
    assert force[-20:-5, 2].mean() == pytest.approx(support.weight, rel=MISSES)
    assert support.weight_percent[-20:-5].mean() == pytest.approx(100.0, abs=100.0 * MISSES)
    assert not support.unsupported[-20:-5].any()
    off = (centre - support.com)[-20:-5, :2].mean(axis=0)
    assert np.abs(off).max() < CENTRE


def test_who_sits_upright_with_the_feet_on_nothing_leans_until_it_is_balanced():
    result = hp.simulate(sitting(), bed(), body=BODY)
    support = result.people[0].support
    assert support.weight_percent[-20:-5].mean() == pytest.approx(100.0, abs=100.0 * MISSES)
    moment = np.abs(support.residual[-20:-5, 3:]).mean(axis=0)
    assert moment.max() < NOTHING * support.weight * BODY.stature
    root = [rot.exp(m.rotations[-1, 0]) for m in (result.motion, result.reference)]
    leans = rot.log(rot.multiply(root[0], rot.conjugate(root[1])))
    assert np.degrees(np.linalg.norm(leans)) < LEANS


@functools.cache
def sofa(rise=False, soft="sofa"):
    story = scenarios.load("sit_on_sofa", soft=soft, rise=rise)
    motion = story.motion if rise else held(story.motion)
    return story, hp.simulate(motion, story.scene, body=story.body, settings=story.settings)


def held(motion, seconds=2.0):
    """A motion whose last pose is held for so long."""
    more = round(seconds * motion.fps)
    still = [np.repeat(x[-1:], more, axis=0) for x in (motion.translation, motion.rotations)]
    return motion.with_frames(
        np.concatenate([motion.translation, still[0]]),
        np.concatenate([motion.rotations, still[1]]),
    )


def test_who_sits_on_a_sofa_is_carried_by_seat_rest_and_feet():
    story, result = sofa()
    support = result.people[0].support
    assert support.weight_percent[-20:-5].mean() == pytest.approx(100.0, abs=100.0 * MISSES)
    nothing = np.abs(support.residual[-20:-5]).mean(axis=0)
    assert nothing[:3].max() < NOTHING * support.weight
    assert nothing[3:].max() < NOTHING * support.weight * story.body.stature
    seat = support.surface("seat")[0][-20:-5, 2].mean()
    feet = support.surface("floor")[0][-20:-5, 2].mean()
    assert 0.65 * support.weight < seat < 0.81 * support.weight
    assert 0.19 * support.weight < feet < 0.31 * support.weight
    floor = story.body.vertices(result.motion[-1])[:, 2].min()
    assert floor < 0.01


def test_a_hand_on_a_cushion_carries_nobody_who_stands():
    motion = standing(at=0.003)
    translation = motion.translation.copy()
    translation[5:, 2] -= 0.03
    motion = motion.with_frames(translation, motion.rotations)
    skin, wrist = BODY.vertices(motion[0]), BODY.joints(motion[0])[JOINT_INDEX["left_wrist"]]
    hand = skin[skin[:, 0] > wrist[0] + 0.04]
    ends = []
    for soft in (None, "sofa", "mattress", "pillow"):
        scene = hp.Scene()
        scene.add_static("floor", hp.Plane())
        # Fingers are 5 mm in it.
        at = (wrist[0] + 0.12, wrist[1], hand[:, 2].min() + 0.005 - 0.15)
        if soft is not None:
            scene.add_static("cushion", hp.Box((0.16, 0.3, 0.3)), position=at, soft=soft)
        result = hp.simulate(motion, scene, body=BODY, settings=hp.Settings(contact="parts"))
        ends.append(result.motion.translation[-1, 2])
        assert soft is None or len(result.soft_contacts.pressure), "it is pressed"
    assert ends == pytest.approx([ends[0]] * 4, abs=1e-3)


def test_a_state_saved_on_a_sofa_resumes_to_the_bit():
    story = scenarios.load("sit_on_sofa", soft="sofa")
    motion, saved = story.motion, 70
    settings = hp.Settings(contact="parts")
    sim = hp.Simulator(story.scene, body=story.body, settings=settings, fps=motion.fps)
    sim.reset(motion[0])
    for t in range(1, saved):
        sim.step(motion[t])
    state = sim.get_state()
    ends = []
    for again in (False, True):
        if again:
            sim.set_state(state)
        ends.append([sim.step(motion[t]).pose for t in range(saved, saved + 10)])
    for went, goes in zip(*ends, strict=True):
        assert np.array_equal(went.translation, goes.translation)
        assert np.array_equal(went.rotations, goes.rotations)


def test_who_stands_up_from_a_sofa_is_back_on_the_path():
    story, result = sofa(rise=True)
    pelvis = [story.body.joints(m[-1])[0] for m in (story.motion, result.motion)]
    assert np.abs(pelvis[0] - pelvis[1]).max() < 0.02

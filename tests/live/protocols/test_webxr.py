"""The page for WebXR in Chromium, with an emulated device, against a live session."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from support.browser import CHROMIUM, tab
from support.live_frames import BODY, furthest, t_pose

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium, or no playwright")
DEVICE = (Path(__file__).parent / "webxr_device.js").read_text()

#: The issue's bound for loops [degrees].
WITHIN = 0.1
#: From the module's text: joint -> SMPL-X joint, the joint where its bone ends, which way y points.
BACK, UP = [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]
NAMED = {
    "hips": ("pelvis", "spine1", BACK),
    "spine-lower": ("spine1", "spine2", BACK),
    "spine-middle": ("spine2", "spine3", BACK),
    "chest": ("spine3", "neck", BACK),
    "neck": ("neck", "head", BACK),
    "head": ("head", None, BACK),
    **{
        f"{side}-{name}": (f"{side}_{joint}", None if end is None else f"{side}_{end}", y)
        for side in ("left", "right")
        for name, joint, end, y in (
            ("shoulder", "collar", "shoulder", UP),
            ("arm-upper", "shoulder", "elbow", UP),
            ("arm-lower", "elbow", "wrist", UP),
            ("hand-wrist", "wrist", "middle1", UP),
            ("hand-index-phalanx-proximal", "index1", "index2", UP),
            ("hand-thumb-phalanx-proximal", "thumb2", "thumb3", UP),
            ("upper-leg", "hip", "knee", BACK),
            ("lower-leg", "knee", "ankle", BACK),
            ("foot-ankle", "ankle", "foot", UP),
        )
    },
}
#: WebXR's axes (y up, a person looks along -z) from the world's.
UPRIGHT = rot.exp([-np.pi / 2, 0.0, 0.0])


def frame_at_rest(joint, end, y):
    """The axes of a WebXR joint of a person at rest, seen in SMPL-X's axes (4,)."""
    rest = BODY.rest_joints
    along = np.array(UP)
    if end is not None:
        along = rest[JOINT_INDEX[end]] - rest[JOINT_INDEX[joint]]
    z = -along / np.linalg.norm(along)
    y = np.array(y) - z * (z @ np.array(y))
    y /= np.linalg.norm(y)
    return rot.from_matrix(np.stack([np.cross(y, z), y, z], axis=1))


def tracked(pose, own=None):
    """What a device tracks of a pose: name -> x, y, z and x, y, z, w; `own`: axes at rest."""
    positions, quaternions = BODY.joint_frames(pose)
    found = {}
    for name, (joint, end, y) in NAMED.items():
        j = JOINT_INDEX[joint]
        axes = frame_at_rest(joint, end, y) if own is None else own[name]
        w, *v = rot.multiply(rot.multiply(UPRIGHT, quaternions[j]), axes)
        found[name] = [*rot.rotate(UPRIGHT, positions[j]), *v, w]
    return found


def posed(**turns):
    rotations = t_pose().rotations.copy()
    for name, turn in turns.items():
        rotations[JOINT_INDEX[name]] = turn
    return hp.Pose(t_pose().translation + np.array([0.1, -0.2, 0.0]), rotations)


REACH = posed(left_shoulder=[0.0, -0.4, 0.3], right_elbow=[0.0, 0.7, 0.0], neck=[0.0, 0.3, 0.0])
GIVEN = sorted(JOINT_INDEX[joint] for joint, _, _ in NAMED.values())


@pytest.fixture(scope="module")
def entered(tmp_path_factory):
    """A session, and its page in which the device was entered."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    with hp.serve(scene, port=0, fps=60.0) as live, tab(tmp_path_factory.mktemp("webxr")) as page:
        page.page.add_init_script(DEVICE)
        page.open(f"http://127.0.0.1:{live.server.port}/webxr")
        page.until(lambda: page.evaluate("!document.getElementById('enter').disabled"))
        page.until(lambda: page.evaluate("state.height !== null"))
        page.page.click("#enter")
        page.until(lambda: page.evaluate("device.frames > 0"))
        yield live, page


def reached(live, page, pose, joints):
    """The newest pose that was asked for is that of the device, once the person got there."""
    (person,) = live.session.people

    def there():
        target = live.session.newest.targets.get(person)
        return target is not None and furthest(target, pose, joints) < WITHIN

    page.until(there, 20.0)
    return live.session.newest.targets[person]


def test_a_body_arrives(entered):
    """Uncalibrated: -z along the bones, as the module says."""
    live, page = entered
    page.evaluate("(body) => { device.body = body; }", tracked(REACH))
    target = reached(live, page, REACH, GIVEN)
    assert np.abs(BODY.joints(target)[0] - BODY.joints(REACH)[0]).max() < 0.01
    assert page.evaluate("device.asked[1].optionalFeatures") == ["body-tracking", "hand-tracking"]
    assert int(page.page.inner_text("#poses")) > 0
    assert page.errors == []


def test_a_t_pose_calibrates_any_device(entered):
    """Joints whose axes are anything at rest, of a person who is smaller than ours."""
    live, page = entered
    rng = np.random.default_rng(1)
    own = {name: rot.normalize(rng.normal(size=4)) for name in NAMED}

    def small(pose):
        rows = tracked(pose, own)
        return {name: [*(0.8 * x for x in row[:3]), *row[3:]] for name, row in rows.items()}

    page.evaluate("(body) => { device.body = body; }", small(t_pose()))
    sent = page.evaluate("state.sent")
    page.until(lambda: page.evaluate("state.sent") > sent + 2)
    page.page.click("#calibrate")
    reached(live, page, t_pose(), GIVEN)
    page.evaluate("(body) => { device.body = body; }", small(REACH))
    target = reached(live, page, REACH, GIVEN)
    assert np.abs(BODY.joints(target)[0] - BODY.joints(REACH)[0]).max() < 0.02
    page.evaluate("state.turns = plainTurns(); state.scale = 1;")


def test_hands_alone_move_fingers(entered):
    """Whatever the arm does, of which nothing is known: a finger bends against its hand."""
    live, page = entered
    bent = posed(left_index1=[0.0, 0.0, -0.5], left_shoulder=[0.3, 0.2, 0.1])
    body = tracked(bent)
    hand = {
        "wrist": body["left-hand-wrist"],
        "index-finger-phalanx-proximal": body["left-hand-index-phalanx-proximal"],
    }
    page.evaluate("(hand) => { device.body = null; device.hands = { left: hand }; }", hand)
    reached(live, page, bent, [JOINT_INDEX["left_index1"]])
    assert page.page.inner_text("#device").startswith("hands only")
    page.evaluate("device.hands = {}")


def test_another_person_is_as_tall_as_they_are(tmp_path):
    """And not scaled by what the one before was calibrated with."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    bodies = [hp.Body.default(stature=1.5), hp.Body.default(stature=1.9)]
    with hp.serve(scene, body=bodies, port=0, fps=60.0) as live, tab(tmp_path) as page:
        page.page.add_init_script(DEVICE)
        page.open(f"http://127.0.0.1:{live.server.port}/webxr")
        page.until(lambda: page.evaluate("state.height !== null"))
        short = page.evaluate("state.height")
        page.evaluate("state.scale = 0.8;")
        page.page.select_option("#person", "person1")
        page.until(lambda: page.evaluate("state.height !== null"))
        assert page.evaluate("state.height") > 1.1 * short
        assert page.evaluate("state.scale") == 1

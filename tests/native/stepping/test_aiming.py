"""Where people are driven: who starts on what is under them; who sits is not blocked."""

import numpy as np
import pytest

import halfphysics as hp
from support.as_it_is import as_it_is

BODY = hp.Body.default()
WEIGHT = as_it_is(weight=True)


def standing(height, frames=3):
    """A T-pose whose lowest skin is so high over z = 0 [m]."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    return hp.Motion(np.zeros((frames, 3)), rotations, 30.0).grounded(BODY, height)


def room(ceiling=None):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    if ceiling is not None:
        scene.add_static("ceiling", hp.Box((1.0, 1.0, 0.2)), position=(0.0, 0.0, ceiling + 0.1))
    return scene


def test_who_starts_in_the_floor_is_put_on_it():
    result = hp.simulate(standing(-0.03), room(), body=BODY, settings=WEIGHT)
    assert len(result.inside) == 0
    assert result.people[0].corrected.all()


def test_who_would_thereby_be_in_something_else_starts_as_asked():
    motion = standing(-0.03)
    top = BODY.vertices(motion[0])[:, 2].max()
    with pytest.warns(hp.HalfPhysicsWarning, match="inside floor"):
        result = hp.simulate(motion, room(top + 0.01), body=BODY, settings=WEIGHT)
    assert np.array_equal(result.motion.translation[0], motion.translation[0])
    assert {result.names[i] for i in result.inside.at(0).other} == {"floor"}


@pytest.mark.parametrize("name", ["open_laptop", "close_laptop", "crawl_under_table"])
def test_nothing_that_is_over_a_thing_starts_in_it(name):
    """Hands over the table stay over it, as the feet come down to the floor."""
    story = hp.scenarios.load(name)
    result = hp.simulate(story.motion[:2], story.scene, body=story.body)
    assert len(result.inside) == 0


def test_a_hand_on_a_shelf_holds_nobody_in_the_air():
    """The ground goes down by half a metre under somebody with a hand 3 mm over a shelf."""
    drop, frames, fps = 0.5, 75, 30.0
    motion = standing(0.0, frames)
    joints, skin = BODY.joints(motion)[0], BODY.vertices(motion[0])
    finger = joints[hp.JOINT_NAMES.index("right_middle2")]
    hand = skin[np.linalg.norm(skin - finger, axis=1) < 0.12]
    path = np.tile([*joints[0, :2], -0.05], (frames, 1))
    fallen = 0.5 * 9.81 * np.maximum(np.arange(frames) / fps - 0.5, 0.0) ** 2
    path[:, 2] -= np.minimum(fallen, drop)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(), position=(0.0, 0.0, -drop - 0.1))
    scene.add_moving("lift", hp.Box((1.0, 1.0, 0.1)), path, fps=fps)
    under = (*finger[:2], hand[:, 2].min() - 0.013)
    scene.add_static("shelf", hp.Box((0.1, 0.3, 0.02)), position=under)
    result = hp.simulate(motion, scene, body=BODY)
    assert (result.contacts.other == result.names.index("shelf")).any()
    down = result.motion.translation[:, 2] - motion.translation[:, 2]
    assert down[-1] == pytest.approx(-drop, abs=0.01)


def test_feet_of_whom_a_seat_holds_up_stand_on_the_floor():
    """The motion sits 9 mm deep in a hard seat: the seat holds the body up, and the feet stay."""
    story = hp.scenarios.load("sit_on_sofa")
    result = hp.simulate(story.motion, story.scene, body=story.body)
    up = (result.motion.translation - story.motion.translation)[-1, 2]
    soles = [story.body.vertices(m[-1])[:, 2].min() for m in (story.motion, result.motion)]
    assert up > 0.008
    assert soles[1] == pytest.approx(soles[0], abs=2e-3)


def test_who_sits_is_not_blocked():
    """Somebody moves back on a mattress: friction holds, but nobody waits for it."""
    story = hp.scenarios.load("sit_on_bed")
    result = hp.simulate(story.motion, story.scene, body=story.body)
    late = np.arange(len(result)) / result.fps - result.clock
    assert late.max() < 0.3
    off = result.motion.translation[-1] - story.motion.translation[-1]
    assert np.linalg.norm(off[:2]) < 0.02

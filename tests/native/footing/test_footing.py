"""People stand on what is under them: heights, falls, stairs, and what stays as it was."""

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.body.footing_points import footing_points
from halfphysics.scenarios.acting.gait import Walk
from halfphysics.scenarios.acting.gait import walk as gait
from support.as_it_is import as_it_is
from support.carries.pushes import PushCase
from support.carries.take_cases import take_of
from support.ground.cases import Case, set_up
from support.ground.figures import figures, knee_jerk, toes_angle
from support.ground.upright import BODY, FEET, SIDES, STANDS, WEIGHT, floor, lowest, standing


@pytest.mark.parametrize("height", [-0.03, -0.01, 0.01, 0.03, 0.08])
def test_a_displaced_clip_stands_from_the_first_frame_on_without_force(height):
    motion = standing(height)
    result = hp.simulate(motion, floor(), body=BODY, settings=WEIGHT)
    feet = lowest(result.motion)
    assert (feet > STANDS[0]).all()
    assert (feet < STANDS[1] + 0.003).all()
    assert not result.contacts.impulse.any()
    assert hp.metrics.mpjpe(result.motion, motion, BODY) < 1e-6
    assert result.people[0].corrected.all()


def test_a_sole_stays_on_the_ground_as_the_height_makes_up_for_a_motion_that_comes_down():
    """A recording that stands 9 cm too high for 2/3 of a second, and comes down in 0.13 s."""
    high = np.concatenate([np.full(20, 0.09), np.linspace(0.09, 0.0, 5)[1:], np.zeros(30)])
    motion = standing(0.0, frames=len(high))
    motion = motion.with_frames(motion.translation + high[:, None] * [0, 0, 1], motion.rotations)
    result = hp.simulate(motion, floor(), body=BODY, settings=WEIGHT)
    feet = lowest(result.motion)
    assert (feet > STANDS[0]).all()
    # Moving feet pass 6 mm higher and hang by 4 mm at most; taken up with the body by 16.
    assert (feet < STANDS[1] + 0.0065).all()
    assert feet[-1] < STANDS[1]


def test_toes_of_who_hops_on_sliding_feet_are_firm_too():
    """On tiptoe at 1 m/s, up and down by 12 cm twice a second: no foot ever rests."""
    motion, fps = standing(0.0), 30.0
    rotations = motion.rotations.copy()
    for side in SIDES:
        rotations[:, hp.JOINT_NAMES.index(f"{side}_ankle"), 0] += 0.8
    t = np.arange(len(motion)) / fps
    way = np.column_stack([t, 0.0 * t, 0.06 * (1.0 - np.cos(4.0 * np.pi * t))])
    tiptoe = motion.with_frames(motion.translation, rotations).grounded(BODY, z=0.0)
    hops = tiptoe.with_frames(tiptoe.translation + way, rotations)
    result = hp.simulate(hops, floor(), body=BODY)
    assert result.contacts.impulse.sum() > 1.0  # N s: they do touch
    assert toes_angle(result.people[0]) < 1.0  # 3.9 degrees, if only feet at rest had firm toes


@pytest.mark.parametrize("scene", [hp.Scene(), floor(top=-0.0012)], ids=["nothing", "floor"])
def test_who_stands_already_or_on_nothing_is_not_changed_by_one_bit(scene):
    motion = standing(0.0)
    result = hp.simulate(motion, scene, body=BODY, settings=WEIGHT)
    without = hp.simulate(motion, scene, body=BODY, settings=as_it_is())
    assert np.array_equal(result.motion.translation, without.motion.translation)
    assert np.array_equal(result.motion.rotations, without.motion.rotations)
    assert not result.people[0].corrected.any()
    assert result.free_frames().all()


def test_nobody_is_held_up_by_nothing_and_falls_no_faster_than_gravity():
    height, fps = 0.6, 60.0
    motion = standing(height, frames=120, fps=fps)
    result = hp.simulate(motion, floor(), body=BODY, settings=WEIGHT)
    z = result.motion.translation[:, 2] - motion.translation[:, 2]
    # Semi-implicit steps: one of g dt^2 ahead of the parabola at most.
    acceleration = np.diff(z, 2) * fps**2
    assert acceleration.min() > -9.81 * 1.001
    assert STANDS[0] < lowest(result.motion)[-1] < STANDS[1] + 0.003
    assert not result.lost_time.any()
    assert not len(result.breaches)


def lifted(frames=150, fps=60.0, high=0.6):
    """Somebody on a lift that goes up at 3 m/s and stops: the result, heights, bends (T,)."""
    motion, scene = standing(0.0, frames=frames, fps=fps), floor(top=-0.0012)
    up = np.minimum(3.0 * np.arange(frames) / fps, high) - 0.0512
    lift = np.column_stack([np.broadcast_to(motion.translation[0, :2], (frames, 2)), up])
    scene.add_moving("lift", hp.Box((3.0, 3.0, 0.1)), lift, fps=fps)
    result = hp.simulate(motion, scene, body=BODY)
    bent = np.abs(result.motion.rotations - motion.rotations).max(axis=(1, 2))
    return result, (result.motion.translation - motion.translation)[:, 2], bent


def test_who_is_thrown_up_falls_while_its_joints_are_out_of_place():
    result, z, bent = lifted()
    free = ~np.isin(np.arange(150), result.contacts.frame)
    # Frames that nothing touches, nor the two before and after them, above all that could carry.
    flies = np.flatnonzero(np.convolve(free & (z > 0.7), np.ones(5), "valid") == 5) + 1
    assert len(flies) >= 4
    assert (bent[flies] > np.radians(2.0)).all()
    # Of the root, against which joints move on their way back; held by nothing it would not fall.
    fall = np.diff(z, 2)[flies].mean() * 60.0**2
    assert -1.1 * 9.81 < fall < -0.4 * 9.81
    assert not len(result.breaches)


def test_who_is_lifted_onto_something_stands_there_and_is_as_the_motion_has_it():
    result, z, bent = lifted(frames=240)  # it bounces, and its feet step to where they belong
    assert z[-1] == pytest.approx(0.6, abs=0.005)
    assert bent[-1] < np.radians(2.5)
    assert not np.isin(np.arange(120, 240), result.contacts.frame).any()  # 2 mm over the lift


def test_a_jump_is_not_pulled_down():
    """Up and down along a parabola of 0.3 m, off the ground for half a second."""
    fps, g = 60.0, 9.81
    motion = standing(0.0012, frames=120, fps=fps)
    t = np.arange(120) / fps - 0.5
    up = np.maximum(0.0, 0.3 - 0.5 * g * (t - np.sqrt(0.6 / g)) ** 2)
    jump = motion.with_frames(motion.translation + up[:, None] * [0.0, 0.0, 1.0], motion.rotations)
    result = hp.simulate(jump, floor(), body=BODY, settings=WEIGHT)
    assert np.abs(result.motion.translation - jump.translation).max() < 0.02


def moved(motion, along, up):
    """Somebody who does not move a joint goes `along` -y and `up` [m], each (T,)."""
    way = np.column_stack([np.zeros(len(up)), -along, up])
    return motion.with_frames(motion.translation + way, motion.rotations)


def test_hops_on_feet_that_slide_are_not_pulled_down():
    """Hops of 20 cm, one after the other, at 0.6 m/s: no foot ever rests, and nobody floats."""
    fps, g, high = 60.0, 9.81, 0.2
    t = np.arange(180) / fps
    lasts = 2.0 * np.sqrt(2.0 * high / g)
    s = np.mod(t, lasts)
    motion = standing(0.0012, frames=180, fps=fps)
    hops = moved(motion, 0.6 * t, 0.5 * g * s * (lasts - s))
    result = hp.simulate(hops, floor(), body=BODY, settings=WEIGHT)
    assert np.abs((result.motion.translation - hops.translation)[:, 2]).max() < 0.02


def test_who_glides_over_the_ground_comes_down():
    fps = 60.0
    motion = standing(0.03, frames=120, fps=fps)
    glides = moved(motion, 0.8 * np.arange(120) / fps, np.zeros(120))
    result = hp.simulate(glides, floor(), body=BODY, settings=WEIGHT)
    # Feet that move keep kSwingGap more.
    assert (lowest(result.motion)[60:] < STANDS[1] + 0.009).all()


def test_knees_go_down_to_the_ground_smoothly():
    """A walk 1 cm over the floor: legs that reach down and are lifted do not jerk."""
    walk = gait(BODY, Walk(distance=2.0, speed=1.2), 30.0)
    high = walk.with_frames(walk.translation + np.array([0.0, 0.0, 0.01]), walk.rotations)
    result = hp.simulate(high, floor(), body=BODY, settings=WEIGHT)
    assert knee_jerk(result.people[0]) < 1.2


@pytest.mark.parametrize("shape", ["plane", "hull", "mesh"])
def test_planes_hulls_and_meshes_carry_alike(shape):
    result = hp.simulate(standing(0.02), floor(shape, 0.0), body=BODY, settings=WEIGHT)
    plane = hp.simulate(standing(0.02), floor(), body=BODY, settings=WEIGHT)
    # A fall towards a hull ends within a tenth of a micrometre.
    assert np.abs(result.motion.translation - plane.motion.translation).max() < 2e-7


def test_one_foot_on_a_step_bends_the_leg_and_keeps_the_foot_level():
    scene, step = floor(), 0.08
    left = BODY.joints(standing()[0])[hp.JOINT_NAMES.index("left_ankle")]
    scene.add_static(
        "step", hp.Box((0.2, 0.6, step)), position=(left[0], left[1] - 0.1, step / 2.0)
    )
    motion = standing(0.0, frames=90)
    result = hp.simulate(motion, scene, body=BODY, settings=as_it_is(weight=True, root="recover"))
    name = [hp.JOINT_NAMES[i] for i in BODY.weights.argmax(axis=1)]
    for side, height in (("left", step), ("right", 0.0)):
        sole = [i for i in FEET if name[i].startswith(side)]
        assert STANDS[0] < lowest(result.motion, sole)[-1] - height < STANDS[1] + 0.003, side
        joint = hp.JOINT_NAMES.index(f"{side}_ankle")
        _, after = BODY.joint_frames(result.motion[-1])
        _, before = BODY.joint_frames(motion[-1])
        # The foot's orientation in the world, as a quaternion: no turn of over 2 degrees.
        assert abs(after[joint] @ before[joint]) > np.cos(np.radians(1.0)), side
    assert not len(result.breaches)


def up_a_stair(at, height, fps=30.0):
    """A walk at 1 m/s over flat ground, and a scene in which a stair begins at x = `at` [m]."""
    scene = floor()
    scene.add_static("stair", hp.Box((4.0, 2.0, height)), position=(at + 2.0, 0.0, height / 2.0))
    return gait(BODY, Walk(distance=3.0, speed=1.0), fps), scene


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("at", [0.9, 1.0, 1.1, 1.2, 1.3])
def test_feet_step_over_the_edge_of_a_stair_that_the_motion_knows_nothing_of(at, fps):
    """Lifted only once over it they met its riser with 30 to 250 N s, toes bent by 50 to 75 deg."""
    motion, scene = up_a_stair(at, 0.1, fps)
    result = hp.simulate(motion, scene, body=BODY)
    assert np.linalg.norm(result.contacts.impulse, axis=1).sum() < 0.5  # N s: a toe may brush it
    assert toes_angle(result.people[0]) < 1.0
    # Twice as much and more without looking ahead; a recording at more frames/s jerks less itself.
    assert knee_jerk(result.people[0]) < {30.0: 1.25, 60.0: 1.75, 120.0: 2.35}[fps]
    feet = lowest(result.motion)
    assert STANDS[0] < feet[-1] - 0.1 < STANDS[1]
    assert feet.min() > STANDS[0]


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_knee_that_is_raised_before_a_box_is_not_lifted_over_it(fps):
    """What is 0.4 m high is no step, however fast a foot rises before it: 3 to 5 cm too high."""
    motion = standing(0.0, frames=round(1.5 * fps), fps=fps)
    t = np.arange(len(motion)) / fps
    rises = 0.5 * (1.0 - np.cos(np.pi * np.clip((t - 1.0) / 0.25, 0.0, 1.0)))
    rotations = motion.rotations.copy()
    rotations[:, hp.JOINT_NAMES.index("left_hip"), 0] -= 1.0 * rises
    rotations[:, hp.JOINT_NAMES.index("left_knee"), 0] += 0.4 * rises
    motion = motion.with_frames(motion.translation, rotations)
    scene, toes = floor(), BODY.vertices(motion[0])[:, 1].min()
    scene.add_static("box", hp.Box((2.0, 1.0, 0.4)), position=(0.0, toes - 0.55, 0.2))
    result = hp.simulate(motion, scene, body=BODY)
    without = hp.simulate(motion, floor(), body=BODY)
    left = np.array([v for v in FEET if BODY.rest_vertices[v, 0] > 0.0])
    more = lowest(result.motion, left) - lowest(without.motion, left)
    assert more.max() < 0.03


def test_a_jump_of_the_motion_lifts_no_feet_for_what_is_metres_away():
    motion = standing(0.0, frames=60, fps=60.0)
    y = np.where(np.arange(60) < 30, 0.0, -0.5)
    motion = motion.with_frames(motion.translation + y[:, None] * [0.0, 1.0, 0.0], motion.rotations)
    scene = floor()
    for k in range(12):
        place = (0.0, -2.6 - 0.4 * k, 0.05 * (k + 1))
        scene.add_static(f"step{k}", hp.Box((3.0, 0.4, 0.1 * (k + 1))), position=place)
    high = [lowest(hp.simulate(motion, s, body=BODY).motion, FEET).max() for s in (scene, floor())]
    assert high[0] < high[1] + 1e-6  # 33 mm, at the speed of the jump for 0.2 s


def test_a_state_saved_before_a_stair_resumes_to_the_bit():
    motion, scene = up_a_stair(1.1, 0.1)
    whole = hp.simulate(motion, scene, body=BODY).motion
    sim = hp.Simulator(scene, body=BODY)
    sim.reset(motion[0])
    states = []
    for t in range(1, len(motion)):
        states.append(sim.get_state())
        sim.step(motion[t])
    for t in range(15, len(motion) - 1, 7):
        sim.set_state(states[t - 1])
        pose = [sim.step(motion[k]).pose for k in (t, t + 1)][-1]
        assert np.array_equal(pose.rotations, whole.rotations[t + 1])


def test_a_foot_that_was_taken_down_to_the_ground_leaves_it_as_the_motion_does():
    """It rests 11 mm over the ground beside the other one, is put down, and then rises.

    At once, it would be 1.5 times as hard.
    """
    motion, fps = standing(0.0, frames=60), 30.0
    t = np.arange(len(motion)) / fps
    rises = 0.5 * (1.0 - np.cos(np.pi * np.clip((t - 1.0) / 0.6, 0.0, 1.0)))
    rotations = motion.rotations.copy()
    for joint, bend in (("hip", -0.59), ("knee", 1.18), ("ankle", -0.59)):
        more = {"hip": -0.5, "knee": 1.0, "ankle": -0.5}[joint]
        rotations[:, hp.JOINT_NAMES.index(f"left_{joint}"), 0] = bend + more * rises
    motion = motion.with_frames(motion.translation, rotations).grounded(BODY, z=0.0)
    result = hp.simulate(motion, floor(), body=BODY)
    ankle = hp.JOINT_NAMES.index("left_ankle")
    height = [BODY.joints(m)[:, ankle, 2] for m in (motion, result.motion)]
    assert (height[0] - height[1])[:30].max() > 0.005
    hardest = [np.abs(np.diff(h, 2)).max() for h in height]
    assert hardest[1] < 1.02 * hardest[0]


@pytest.mark.parametrize("clip", ["asap_kick1", "asap_single_foot_jump2", "asap_squat3"])
def test_recorded_feet_stand_on_stairs(shared_data, clip):
    """Clips of flat ground, lifted along a slope of stairs of 10 cm.

    The heel of a foot that tilts on its toes is not what keeps it up: one hung 25 mm over a tread.
    """
    motions, scene, bodies = set_up(Case("sunk", clip, "stairs"), shared_data)
    result = hp.simulate(motions, scene, body=list(bodies))
    found = figures(result)
    assert abs(found["end_mm"]) < 5.0
    assert found["toes_deg"] < 10.0
    assert found["knee_jerk"] < 1.5
    assert found["slide_more_mm"] < 0.2
    assert found["unsupported_percent"] < 5.0
    assert found["peak_n"] < 400.0


def test_what_a_foot_is_about_to_kick_is_no_ground():
    """A ball 2 cm before the toes, lower than the ankle, does not lift the person."""
    scene = floor(top=-0.0012)
    feet = BODY.vertices(standing()[0])[FEET]
    toe = feet[feet[:, 1].argmin()]
    scene.add_object(
        "ball", hp.Sphere(0.05), mass=0.4, position=(toe[0], toe[1] - 0.07, 0.05), friction=1.0
    )
    result = hp.simulate(standing(0.0), scene, body=BODY, settings=WEIGHT)
    assert np.array_equal(result.motion.translation, standing(0.0).translation)


@pytest.mark.parametrize(("thing", "way"), [("chair", "far"), ("box", "sole"), ("box", "toe")])
def test_a_foot_that_pushes_a_thing_ahead_is_not_lifted_over_it(thing, way):
    """A tilted sole against the bar of a chair, 0.17 m high, or a box, ahead of it for a second."""
    take = take_of(PushCase(thing, way, "right", 0.3, "gap", seed=1))
    scene = take.sequence().scene
    result = hp.simulate(take.motions, scene, body=list(take.bodies))
    ankle = hp.JOINT_NAMES.index("right_ankle")
    body, motion = take.bodies[0], result.people[0].motion
    frames = np.arange(*take.span)
    off = body.joints(motion)[frames, ankle] - body.joints(take.motions[0])[frames, ankle]
    gone = np.ptp(result.objects[take.name].position[frames, 0])
    assert gone > 0.2
    assert off[:, 2].max() < 3e-3  # 27 to 41 mm where it stood on what its toes were against


def test_a_baseline_that_sets_poses_is_not_corrected():
    motion = standing(0.03, frames=5)
    settings = hp.baselines.Kinematic()
    result = hp.simulate(motion, floor(), body=BODY, settings=settings)
    assert np.array_equal(result.motion.translation, motion.translation)
    assert not result.people[0].corrected.any()


def t_pose(frames=75):
    """Somebody upright with straight legs and level arms."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    motion = hp.Motion(np.zeros((frames, 3)), rotations, 30.0)
    low = BODY.vertices(motion[0])[:, 2].min()
    return motion.with_frames(motion.translation + np.array([0.0, 0.0, 0.003 - low]), rotations)


def under_an_arm(pose):
    """Where the lowest skin half-way along the right upper arm is (3,) [m]."""
    joints = BODY.joints(pose)
    ends = [hp.JOINT_NAMES.index(name) for name in ("right_shoulder", "right_elbow")]
    middle = joints[ends].mean(axis=0)
    skin = BODY.vertices(pose)
    near = skin[(np.abs(skin - middle)[:, :2] < 0.06).all(axis=1)]
    return np.array([middle[0], middle[1], near[:, 2].min()])


def knees(pose):
    """Largest turn of the knees [deg]."""
    bent = pose.rotations[[hp.JOINT_NAMES.index(f"{s}_knee") for s in SIDES]]
    return np.rad2deg(np.linalg.norm(bent, axis=1).max())


@pytest.mark.parametrize("fps", [5.0, 8.0, 30.0])
def test_the_height_settles_at_any_frame_rate(fps):
    frames = int(4 * fps) + 2
    motion = standing(frames=frames, fps=fps)
    translation = motion.translation.copy()
    translation[2:, 2] += 0.04
    floating = motion.with_frames(translation, motion.rotations)
    result = hp.simulate(floating, floor(), body=BODY, settings=hp.Settings(contact="parts"))
    low = lowest(result.motion)
    assert low.min() > 0.0
    assert low.max() < 0.045
    assert low[-3:] == pytest.approx(0.003, abs=1e-3)


@pytest.mark.parametrize("person", [0, 1])
def test_what_a_person_holds_changes_nothing_of_how_it_stands(person):
    motion = standing(0.02, frames=20)
    people = [
        motion.with_frames(motion.translation + np.array([0.0, 5.0 * i, 0.0]), motion.rotations)
        for i in (0, 1)
    ]
    hand = BODY.joints(people[person][0])[hp.JOINT_NAMES.index("right_wrist")]
    scene = floor()
    scene.add_object(
        "stick", hp.Box((0.03, 0.03, 0.6)), mass=1.0, position=hand + np.array([0.0, 0.0, 0.5])
    )
    ends = []
    for holds in (False, True):
        settings = hp.Settings(contact="parts")
        sim = hp.Simulator(scene, body=[BODY, BODY], settings=settings, fps=30.0)
        sim.reset([m[0] for m in people])
        if holds:
            sim.attach("stick", "right_wrist", person=person)
        for t in range(1, len(motion)):
            frame = sim.step([m[t] for m in people])
        ends.append(frame.poses[person])
    assert knees(ends[1]) == pytest.approx(knees(ends[0]), abs=1e-3)
    assert ends[1].translation[2] == pytest.approx(ends[0].translation[2], abs=1e-4)


def test_what_a_person_holds_is_no_ground_of_its_own():
    motion = t_pose()
    scene = floor()
    below = under_an_arm(motion[0])
    box = hp.Box((0.15, 0.15, 0.05))
    scene.add_object("box", box, mass=0.5, position=below - [0.0, 0.0, 0.033])
    sim = hp.Simulator(scene, body=BODY, settings=hp.Settings(contact="parts"), fps=30.0)
    sim.reset(motion[0])
    sim.attach("box", "right_wrist")
    for t in range(1, len(motion)):
        frame = sim.step(motion[t])
    assert abs(frame.pose.translation[2] - motion.translation[0, 2]) < 1e-3
    assert knees(frame.pose) < 3.0


def test_a_saved_state_resumes_to_the_bit():
    motion = standing(0.05, frames=40)
    settings = hp.Settings()
    scene = floor()
    scene.add_static("wall", hp.Box((3.0, 0.1, 2.0)), position=(0.0, -0.8, 1.0))
    walk = motion.with_frames(
        motion.translation + np.linspace(0.0, 1.5, 40)[:, None] * [0.0, -1.0, 0.0], motion.rotations
    )
    sim = hp.Simulator(scene, body=BODY, settings=settings)
    sim.reset(walk[0])
    for t in range(1, 25):
        sim.step(walk[t])
    state = sim.get_state()
    ends = []
    for _ in range(2):
        sim.set_state(state)
        for t in range(25, 40):
            frame = sim.step(walk[t])
        ends.append(frame.pose)
    assert np.array_equal(ends[0].rotations, ends[1].rotations)
    assert np.array_equal(ends[0].translation, ends[1].translation)
    whole = hp.simulate(walk, scene, body=BODY, settings=settings).motion[39]
    assert np.array_equal(whole.rotations, ends[0].rotations)


@pytest.mark.parametrize("clip", ["asap_walk1", "asap_squat3", "asap_kick1"])
def test_recorded_feet_stand_with_their_toes_flat(shared_data, clip):
    motion = hp.Motion.load(shared_data / "motion" / f"{clip}.npz").grounded(BODY)
    sunk = motion.with_frames(motion.translation - [0.0, 0.0, 0.01], motion.rotations)
    result = hp.simulate(sunk, floor(), body=BODY, settings=WEIGHT)
    assert np.median(lowest(result.motion)) < 0.004
    toes = [hp.JOINT_NAMES.index(f"{side}_foot") for side in ("left", "right")]
    turned = np.abs(result.motion.rotations[:, toes] - sunk.rotations[:, toes]).max()
    # Without weight they turn by up to 1.7 rad.
    assert np.degrees(turned) < 10.0
    force = np.zeros(len(motion))
    np.add.at(force, result.contacts.frame, np.linalg.norm(result.contacts.impulse, axis=1))
    assert force.max() * result.fps < 400.0


def test_points_are_on_the_skin_and_cover_the_soles():
    points = footing_points(BODY)
    frames = BODY.rest_joints[points.joints] + points.local
    at = (points.weights[..., None] * frames).sum(axis=1)
    gap = np.linalg.norm(at[:, None] - BODY.rest_vertices[None], axis=2).min(axis=1)
    assert gap.max() < 1e-12
    assert np.abs(points.weights.sum(axis=1) - 1.0).max() < 1e-12
    for side in (slice(0, points.soles[0]), slice(points.soles[0], sum(points.soles))):
        sole = at[side]
        assert np.ptp(sole[:, 2]) > 0.2
        assert sole[:, 1].min() < BODY.rest_vertices[:, 1].min() + 1e-3
        # No edge lies under more than 3 mm of a sole before a point of it is over that.
        x = BODY.rest_vertices[FEET]
        x = x[(x[:, 0] * sole[:, 0].mean() > 0) & (x[:, 1] < x[:, 1].min() + 0.02)][:, [0, 2]]
        angle = np.radians(np.arange(0.0, 360.0, 2.0))
        ways = np.column_stack([np.cos(angle), np.sin(angle)])
        assert ((x @ ways.T).max(axis=0) - (sole[:, [0, 2]] @ ways.T).max(axis=0)).max() < 3e-3

"""Random people, obstacles, objects and settings: no penetration, and balanced momentum.

By default a few dozen cases, always the same. `HALFPHYSICS_FUZZ=SECONDS` runs new cases of each
kind for that time and prints the number of frames. A failing case is printed at once as the
code that makes it: put the `@example(...)` over the test. See fuzzing.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.fuzz_cases import (
    Case,
    Form,
    Person,
    Thing,
    build,
    cases,
    settings_of,
    start_of,
    things,
)
from support.fuzzing import count, drawn
from support.judges.clear_judge import Judge
from support.judges.coal_scene import Watch
from support.people import t_pose, violent

pytestmark = [pytest.mark.slow, pytest.mark.fuzz]

#: Clear starts stay clear; accuracy of coal's own distances [m].
COAL = 1e-6
#: Momentum is a sum of floating-point numbers, relative to its largest.
ROUNDING = 1e-10
#: A lost clearance returns at this speed at most [m/s].
REGAINED = 0.05
#: Up to this turn in a substep [rad] passive objects must gain no energy.
TURN = 0.3


@pytest.fixture(scope="module")
def body():
    return Body.default()


def play(run):
    """All frames of a run; each frame's conditions are checked on the way."""
    simulator = run.simulator
    stepper, world = simulator.world.stepper, simulator.world
    stepper.keep_pieces(True)  # the judge sees every committed pose
    frames = [simulator.reset(run.poses(0))]
    for t in range(1, run.length):
        before = stepper.qvel()
        frames.append(simulator.step(run.poses(t)))
        c, after = frames[-1].contacts, stepper.qvel()
        assert np.isfinite(frames[-1].substeps).all()
        assert np.isfinite(after).all()
        # No contact pulls.
        assert (np.einsum("ij,ij->i", c.impulse, c.normal) >= 0.0).all()
        # Contacts and gravity explain every change of an object's momentum.
        for place in world.objects:
            mass, index = world.scene.objects[place.name].mass, simulator.names.index(place.name)
            rows = slice(place.dof, place.dof + 3)
            gained = mass * (after[rows] - before[rows] - world.scene.gravity * simulator.dt)
            pushed = c.impulse[c.subject == index].sum(axis=0)
            pushed = pushed - c.impulse[c.other == index].sum(axis=0)
            size = mass * np.abs(before[rows]).max() + np.abs(c.impulse).sum() + mass
            assert np.abs(gained - pushed).max() <= ROUNDING * size
    return frames


def check_clear(run, frames):
    """By coal at every committed substep, and no body crossed an obstacle between two of them."""
    clear = False
    try:
        _check_clear(run, frames)
        clear = True
    finally:
        count(run.case.contact if run.motions else "things", frames, clear)


def _check_clear(run, frames):
    start = start_of(run)
    if run.motions:
        verdict = Judge(run.simulator).judge(start, frames)
        assert verdict.gap >= -COAL, f"{verdict.where} overlap by {-verdict.gap} m"
        assert not verdict.crossed, f"crossed: {verdict.crossed[:5]}"
    if run.simulator.world.objects or len(run.motions) > 1:
        watch = Watch(run.simulator)
        for f, frame in enumerate(frames):
            for k, qpos in enumerate(frame.substeps):
                gap, pair = watch.gap(qpos, statics="things")
                assert gap >= -COAL, f"{pair} overlap by {-gap} m in substep {k} of frame {f}"


def check_same_again(case):
    """A second simulator gives the same bits, also if it takes over half-way."""
    run, again = build(case), build(case)
    first, second = run.simulator, again.simulator
    first.reset(run.poses(0))
    second.reset(again.poses(0))
    half = again.length // 2
    for t in range(1, again.length):
        if t == half:
            state = second.get_state()
            second = build(case).simulator
            second.set_state(state)
        a, b = first.step(run.poses(t)), second.step(again.poses(t))
        np.testing.assert_array_equal(a.substeps, b.substeps)
        assert a.clearance == b.clearance


@drawn(14)
@given(case=cases(people=(1, 1), statics=(1, 3), most_things=0))
def test_a_person_goes_through_nothing(case):
    run = build(case)
    assume(run.simulator.world.scene.statics)
    check_clear(run, play(run))


@drawn(8)
@given(case=cases(people=(1, 2), statics=(0, 2), most_things=3))
def test_people_and_things_go_through_nothing(case):
    run = build(case)
    frames = play(run)
    check_clear(run, frames)
    check_same_again(case)


@drawn(10)
@given(
    thrown=things((-2.0, -0.5, 0.3), (0.9, 0.5, 2.2), 5, restitutions=(0.0, 0.0, 0.5)),
    case=cases(people=(0, 0), statics=(0, 0), most_things=0),
)
def test_things_go_through_nothing_and_gain_no_energy(thrown, case):
    case = Case(**{**vars(case), "things": thrown})
    run = build(case, floor=True)
    assume(run.simulator.world.objects)
    frames, energies = fall(run)
    check_clear(run, frames)
    for place in run.simulator.world.objects:
        x = np.concatenate([f.substeps[:, place.qpos : place.qpos + 3] for f in frames])
        assert x[:, 0].max() < 1.2  # this side of the wall
        assert x[:, 2].min() > 0.0  # above the floor
    if all(thing.form.restitution == 0.0 for thing in thrown):
        check_energy(run, energies)


def test_a_state_taken_in_the_middle_of_a_clash_goes_on_bit_for_bit():
    """Two people at 5 m/s; a simulator that took over in frame 7 once differed by up to 0.5 mm."""
    other = Person(betas=(-1.1555933531577653,), speed=5.0, wild=0.84593909, spin=3.2406, seed=6551)
    case = Case(people=(Person(speed=5.0, seed=227), other), fps=30, substeps=1)
    check_same_again(case)


@pytest.mark.parametrize("contact", ["parts", "skin"])
@pytest.mark.parametrize(("drive_time", "clearance"), [(0.02, 2e-4), (None, 0.001), (0.1, 1e-4)])
def test_people_who_clash_at_20_m_per_s_stay_apart(contact, drive_time, clearance):
    """Limbs bend fast while others fly at them: skin hulls change on the way."""
    case = Case(
        people=(
            Person((), "flailing", 14.851290610333573, 0.6191887905830068, 0.25, 1205),
            Person((), "flailing", 6.225906361975484, 0.0, -1.716933566113278, 15579),
        ),
        substeps=4, stiffness=0.0, drive_time=drive_time, root="recover",
        clearance=clearance, contact=contact,
    )  # fmt: skip
    run = build(case)
    assert len(run.motions) == 2
    check_clear(run, play(run))


#: A rod that rolls at 9 m/s, and one that spins after a fall onto its end.
RODS = {
    "rolling": Case(
        things=(
            Thing(
                Form("capsule", (0.05, 0.218, 0.1), (0.0, 0.0, 0.512), (0.0, 2.189, 0.0)),
                mass=3.0,
                velocity=(-9.016, -5.205, -1.643),
                spin=(0.0, 0.333, -5.316),
            ),
        ),
        fps=30,
        substeps=8,
    ),
    "spun": Case(
        things=(
            Thing(
                Form("capsule", (0.03125, 0.25, 0.25), (0.0, 0.0, 1.0), friction=0.3),
                mass=0.01,
                velocity=(0.0, 2.0, 0.0),
                spin=(0.0, 1.0, 0.0),
            ),
        ),
        fps=30,
        substeps=1,
    ),
}


@pytest.mark.parametrize("name", RODS)
def test_rods_that_turn_by_radians_in_a_substep_gain_no_energy(name):
    """In one step 360 rad/s at h = 1/240 s gained 15 J/kg, 100 rad/s at h = 1/30 s 3.8 J/kg."""
    run = build(RODS[name], floor=True)
    check_energy(run, fall(run)[1], any_turn=True)


def fall(run):
    """One and a half seconds without people: the frames, and (energy [J], turn of the fastest in
    a substep [rad]) after each."""
    run.simulator.reset([])
    frames, energies = [], [energy(run)]
    for _ in range(run.case.fps * 3 // 2):
        frames.append(run.simulator.step([]))
        energies.append(energy(run))
    return frames, energies


def check_energy(run, energies, any_turn=False):
    """No frame adds more energy than the recovery of a lost clearance may."""
    energies, turns = np.array(energies).T
    mass = sum(thing.mass for thing in run.simulator.world.scene.objects.values())
    height = min(run.case.clearance, REGAINED / run.case.fps)
    most = mass * (0.5 * REGAINED**2 + 9.81 * height) + ROUNDING * np.abs(energies).max()
    gains = np.diff(energies)
    if not any_turn:
        gains = gains[np.maximum(turns[1:], turns[:-1]) <= TURN]
    assert gains.max(initial=0.0) <= most


def energy(run):
    """Kinetic and potential energy of all objects [J], and the largest turn of one [rad]."""
    world, stepper = run.simulator.world, run.simulator.world.stepper
    qpos, qvel = stepper.qpos(), stepper.qvel()
    total = fastest = 0.0
    for place in world.objects:
        thing = world.scene.objects[place.name]
        v, w = qvel[place.dof : place.dof + 3], qvel[place.dof + 3 : place.dof + 6]
        x = qpos[place.qpos : place.qpos + 3]
        total += 0.5 * thing.mass * v @ v + 0.5 * w @ thing.inertia @ w
        total -= thing.mass * world.scene.gravity @ x
        fastest = max(fastest, float(np.linalg.norm(w)))
    return float(total), fastest / (run.case.fps * run.case.substeps)


@pytest.mark.parametrize(
    "name",
    ["kaykit_prototype/Primitive_Floor", "kaykit_prototype/Wall_Doorway", "kaykit_furniture/couch"],
)
def test_a_person_goes_through_no_furniture(shared_data, name):
    @drawn(2)
    @given(
        case=cases(people=(1, 1), statics=(0, 0), most_things=0),
        turn=st.floats(0.0, 6.0),
        y=st.floats(-0.5, 0.5),
        z=st.floats(-1.2, -0.3),
    )
    def check(case, turn, y, z):
        run = build(case)
        scene = Scene()
        path = shared_data / "meshes" / f"{name}.obj"
        at = {"position": (1.9, y, z), "quaternion": rot.exp([0.0, 0.0, turn])}
        scene.add_static("it", path, scale=0.7, up="y", **at)
        bodies = run.simulator.bodies
        run.simulator = Simulator(scene, body=bodies, settings=settings_of(case), fps=case.fps)
        assume(Judge(run.simulator).gap_to(scene.statics["it"], start_of(run)) > 0.002)
        check_clear(run, play(run))

    check()


@drawn(30)
@given(
    fps=st.sampled_from([24.0, 29.97, 30.0, 60.0, 100.0, 120.0]),
    substeps=st.sampled_from([1, 4, 8]),
    stiffness=st.sampled_from([0.0, 1.0, 10.0]),
    drive_time=st.sampled_from([None, 0.02]),
    beyond=st.sampled_from([0.0, 1e-15, -1e-12, 1e-7, 0.3]),
    far=st.sampled_from([0.0, 1000.0]),
    kind=st.sampled_from(["half turns", "violent"]),
    seed=st.integers(0, 2**16),
)
def test_free_motion_is_exact_whatever_it_does(
    body, fps, substeps, stiffness, drive_time, beyond, far, kind, seed
):
    """Any turns, half turns included, any size of rotation vectors, a kilometre away."""
    rng = np.random.default_rng(seed)
    if kind == "violent":
        motion = violent(10, fps=min(fps, 60.0), seed=seed)  # a root speed under 50 m/s
    else:
        axes = rng.normal(size=(55, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        turn = rot.exp((np.pi + beyond) * axes)
        quats = [rot.exp(rng.normal(size=(55, 3)))]
        for _ in range(9):
            quats.append(rot.multiply(quats[-1], turn))
        vectors = rot.log(np.array(quats))
        length = np.linalg.norm(vectors, axis=2, keepdims=True)
        vectors *= 1.0 + 2 * np.pi * rng.integers(-3, 4, size=length.shape) / length
        path = 3.0 / fps * rng.normal(size=(10, 3)) + far * rng.normal(size=3)
        motion = Motion(path, vectors, fps)
    chosen = Settings(substeps=substeps, stiffness=stiffness, drive_time=drive_time)
    simulator = Simulator(body=body, settings=chosen, fps=motion.fps)
    simulator.reset(motion[0])
    for t in range(1, len(motion)):
        pose = simulator.step(motion[t]).pose
        error = np.abs(body.joints(pose) - body.joints(motion[t])).max()
        assert error <= 1e-9  # [m]; the goal in free motion is 1e-6 mm


def test_the_checks_can_fail(body):
    """A run moved into a static is not clear; a case repeats itself."""
    case = Case(people=(), fps=30)
    assert eval(repr(case), {"Case": Case}) == case
    import trimesh

    scene = Scene()
    scene.add_static("it", trimesh.creation.box((0.2, 2.0, 2.0)), position=(1.0, 0.0, 0.0))
    motion = t_pose(np.zeros((3, 3)))
    simulator = Simulator(
        scene, body=body, settings=Settings(record="substeps", substeps=2), fps=30
    )
    frames = [simulator.reset(motion[0])]
    frames += [simulator.step(motion[t]) for t in (1, 2)]
    start = simulator.world.start([motion[0]])[0]
    assert Judge(simulator).judge(start, frames).clear
    moved = [np.concatenate([f.substeps for f in frames])][0]
    moved[:, 0] += 1.0
    assert not Judge(simulator).judge_poses(np.concatenate([start[None], moved])).clear
    moved[:, 0] += 5.0  # to the other side between two poses
    verdict = Judge(simulator).judge_poses(np.concatenate([start[None], moved]))
    assert verdict.gap >= 0.0
    assert verdict.crossed

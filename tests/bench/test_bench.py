"""`halfphysics bench`: it runs, its records are complete, and the peer does the same work."""

from __future__ import annotations

import json
import math
import warnings

import numpy as np
import pytest

from halfphysics import bench, metrics
from halfphysics.base import rotations as rot
from halfphysics.bench import clips, grasp, handling, near, room, sofa, timing
from halfphysics.bench.measuring import ring
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.pressing import inside, tracks
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import simulators
from halfphysics.bench.wall import past_face
from halfphysics.cli import MISTAKE, main
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import follow, simulate
from halfphysics.simulation.simulator import Simulator
from support.judges.skin_judge import SkinJudge

pytestmark = pytest.mark.slow

# Rounding of positions of a few metres through 8 substeps a frame; measured 1e-12 mm.
EXACT_MM = 1e-6
SETTINGS = {
    "free": 8,
    "live": 8,
    "stepper": 8,
    "itself": 4,
    "wall": 6,
    "near": 4,
    "grasp": 2,
    "lift": 2,
    "glass": 2,
    "sofa": 2,
    "soft-seat": 1,
    "soft-bed": 1,
    "lean": 8,
    "settle": 4,
    "tree": 4,
    "meeting": 2,
    "doorway": 2,
    "ground": 4,
    "setup": 1,
    "clip": 1,
    "batch": 2,
    "hosted": 2,
    "hosted-worlds": 2,
    "envs": 6,
    "instructions": 0,  # no valgrind, test_instructions.py
    "metrics": 4,
    "viewer": 3,
    "sweep": 4,
    "sweep-parts": 6,
    "sweep-memory": 2,
    "skinning": 1,
}
SWEEPS = {"sweep", "sweep-parts", "sweep-memory"}
WHOLE = {"setup", "clip", "batch"}
SOFT = {"soft-seat", "soft-bed"}
ALONE = {
    "envs",
    "hosted-worlds",
    "tree",
    "metrics",
    "viewer",
    "skinning",
    *WHOLE,
    *SWEEPS,
    *SOFT,
}  # no parts beside the skin
PRESSED = ("grasp", "lift", "glass", "sofa", "lean", "settle")
WITH_PEER = {
    *("free", "live", "stepper", "itself", "wall", "near"),
    *("sweep", "sweep-parts", "hosted", "hosted-worlds"),
    *WHOLE,
    *SOFT,
    *PRESSED,
}


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "tiny.npz"
    clips.story().motion[60:70].save(path)
    return path


@pytest.fixture(scope="module")
def measured(clip, tmp_path_factory):
    """The files that one quick run of all cases writes."""
    out = tmp_path_factory.mktemp("bench") / "bench.json"
    arguments = ["bench", "--quick", "--repeats", "1", "--motion", str(clip), "--json", str(out)]
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("error", HalfPhysicsWarning)  # no case starts in a doubtful place
        patch.setattr("halfphysics.bench.instructions.shutil.which", lambda name: None)
        assert main(arguments) == 0
    return json.loads(out.read_text())


def test_who_keeps_off_themselves_is_followed():
    for record in bench.run("itself", Options(quick=True, repeats=1)):
        assert record.checks["frames stepped"] == (0.0, None)
        assert record.checks["MPJPE [mm]"][0] < EXACT_MM


def test_how_people_stand_is_beside_their_rates():
    told = list(bench.run("ground", Options(quick=True, repeats=1)))
    for record in told:
        assert all(np.isfinite(ours) and peer is None for ours, peer in record.checks.values())
    # The first frames of the walk: nothing is touched, and nobody floats.
    free = told[1].checks
    assert free["floating [%]"][0] == free["peak [N]"][0] == 0.0


def test_all_cases_leave_complete_records(measured):
    assert measured["quick"]
    assert measured["repeats"] == 1
    assert {"mujoco", "numpy", "python", "cores", "threads"} <= set(measured["machine"])
    assert set(SETTINGS) == set(bench.CASES)
    for case, count in SETTINGS.items():
        records = [r for r in measured["records"] if r["case"] == case]
        # The given clip doubles the cases that play clips.
        assert len(records) == count * (2 if case in ("free", "live", "stepper") else 1)
        assert len({r["setting"] for r in records}) == len(records)
        for record in records:
            assert record["frames"] > 0
            units = {"metrics": "s", "tree": "s", "viewer": "updates/s", "setup": "s"}
            units |= {
                "envs": "steps/s",
                "sweep": "variants/s",
                "sweep-parts": "s",
                "sweep-memory": "MB",
            }
            assert record["unit"] == units.get(case, "frames/s")
            assert len(record["ours"]) == (10 if case == "sweep-memory" else 1)
            assert all(math.isfinite(x) and x > 0.0 for x in record["ours"])
            for name, there in (("parts", case not in ALONE), ("peer", case in WITH_PEER)):
                figures = record[name]
                assert (figures is not None) == there
                ratio = record["ratio" if name == "peer" else "parts_ratio"]
                assert (ratio is not None) == there
                if figures is not None:
                    assert ratio == record["ours"][0] / figures[0]


def test_both_sides_follow_free_motion_exactly(measured):
    free = [r for r in measured["records"] if r["case"] in ("free", "live")]
    assert {r["setting"].split(",")[0] for r in free} == {"walk", "tiny"}
    for record in free:
        ours, peer = record["checks"]["MPJPE [mm]"]
        assert ours <= EXACT_MM
        assert peer <= EXACT_MM


def test_moving_people_in_a_browser_takes_little(measured):
    """Of 30 updates a second a busy machine leaves some out."""
    figures = {r["setting"]: r["checks"] for r in measured["records"] if r["case"] == "viewer"}
    for setting, checks in figures.items():
        (rate, _), (kilobytes, _), (arrived, _) = (
            checks[name] for name in ("share of a core", "kB/s", "arrived/s")
        )
        assert arrived > 0.0, "the client got nothing"
        assert 0.0 < kilobytes < 300.0
        if "setters" not in setting:
            assert 0.0 < rate < 0.5


def test_sweeps_make_all_samples_and_their_parts_are_the_whole(measured):
    records = {r["setting"]: r for r in measured["records"] if r["case"] in SWEEPS}
    assert {tuple(r["checks"]["samples"]) for r in records.values() if r["case"] == "sweep"} == {
        (3.0, 3.0)
    }
    parts = {k: r["ours"][0] for k, r in records.items() if r["case"] == "sweep-parts"}
    whole = 1.0 / records["3 variants, one process; baseline: simulate alone"]["ours"][0]
    # Reading the clip, once, counts only toward the total.
    assert 0.2 * whole < sum(parts.values()) < 1.5 * whole


def test_the_wall_stops_us_and_not_the_peer(measured):
    walls = [r for r in measured["records"] if r["case"] == "wall"]
    for record in walls:
        ours, peer = record["checks"]["past the face [mm]"]
        assert ours == 0.0
        assert peer > 1.0  # soft contact; measured: tens of millimetres


def test_what_presses_touches_and_does_not_go_in(measured):
    """The skin by `metrics`; the parts by MuJoCo's collision: its hulls are ours in float32."""
    for case in PRESSED:
        records = [r for r in measured["records"] if r["case"] == case]
        assert max(r["checks"]["contacts"][0] for r in records) >= 2.0
        assert all(r["checks"]["skin inside [mm]"][0] == 0.0 for r in records)
        assert all(r["checks"]["parts inside [mm]"][0] < 1e-3 for r in records)
        assert max(r["checks"]["skin inside [mm]"][1] for r in records) > 0.5
        assert max(r["checks"]["parts inside [mm]"][1] for r in records) > 1.0
        assert {r["setting"].split(",")[-2] for r in records} == {" paper", " drive_time"}


def test_what_is_soft_is_pressed(measured):
    """In every frame of the short clips, and by a good part of the weight at their ends."""
    for record in [r for r in measured["records"] if r["case"] in SOFT]:
        assert record["checks"]["frames pressed"][0] > 0.5 * record["frames"]
        assert record["checks"]["load at the end [N]"][0] > 100.0
        assert record["checks"]["time lost [ms]"][0] == 0.0


def test_skin_and_parts_are_told_apart():
    """Each side keeps its own hulls clear: the skin over rigid parts touches static geometry."""
    who, scene = clips.body(), sofa.boxes()
    motion = sofa.sitting(who, floor=0.0)[20:50]
    skin, parts = (
        follow(simulator.world, [motion])
        for simulator in simulators(who, Settings(substeps=8), motion.fps, scene)
    )
    judge = SkinJudge(who, scene)
    assert judge.judge_result(skin, every=5, coal_every=5).clear
    assert not judge.judge_result(parts, every=5, coal_every=5).clear
    # The measure in the table can fail.
    assert inside(who, scene, skin.motion, skin.objects) == 0.0
    assert inside(who, scene, motion, {}) > 1.0


def test_the_peer_reads_back_where_things_are():
    play = grasp.lifting()
    who, motion = clips.body(), play.motion[:5]
    peer = MujocoLoop(who, motion.fps, 2, play.scene)
    qpos = peer.coordinates(motion.translation, motion.rotations, motion.axes)
    qpos[3, -7:-4] += [0.1, 0.2, 0.3]
    same, objects = tracks(peer, motion, play.scene, qpos)
    assert metrics.mpjpe_global(same, motion, who) <= EXACT_MM
    at = play.scene.objects["box"].position
    np.testing.assert_allclose(objects["box"].position[3] - at, [0.1, 0.2, 0.3], atol=1e-12)
    np.testing.assert_allclose(objects["box"].position[2], at, atol=1e-12)


def test_the_box_is_lifted_by_both_hands(measured):
    for record in [r for r in measured["records"] if r["case"] == "grasp"]:
        assert record["checks"]["held [%]"][0] == 100.0
        assert record["checks"]["lifted [mm]"][0] > 100.0  # of the 220 that the body rises


def test_suitcase_and_glass_are_lifted_and_stay_in_the_hands(measured):
    for case, least in (("lift", 300.0), ("glass", 180.0)):
        records = [r for r in measured["records"] if r["case"] == case]
        assert [r["setting"].split(",")[1].strip() for r in records] == ["paper", "drive_time"]
        for record in records:
            assert record["checks"]["lifted [mm]"][0] > least
            assert record["checks"]["slip [mm]"][0] < 10.0


def test_slip_is_measured_where_the_hand_has_the_thing():
    """An object that turns with the hand does not slip; one that leaves the hand does."""
    turn = rot.exp(np.linspace([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 5))
    arm = np.array([0.1, 0.0, 0.0])
    hand = np.linspace([0.0, 0.0, 0.0], [0.0, 0.3, 0.0], 5)
    carried = ObjectTrack(position=hand + rot.rotate(turn, arm), quaternion=turn)
    assert handling.slip(hand, turn, carried, 0) == pytest.approx(0.0, abs=1e-9)
    left = ObjectTrack(position=np.tile(arm, (5, 1)), quaternion=turn)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (5, 1))
    assert handling.slip(hand, still, left, 0) == pytest.approx(300.0)
    assert handling.slip(hand, still, left, 2) == pytest.approx(150.0)


def test_grasp_begins_clear_and_ends_in_the_air():
    play = grasp.lifting()
    who = clips.body()
    result = simulate(play.motion, play.scene, body=who, settings=Settings(substeps=8))
    assert result.clearance[0] >= 0.001
    hands = {part for part in result.contacts.part[result.contacts.frame == 75].tolist()}
    assert hands & set(grasp.HANDS["left"])
    assert hands & set(grasp.HANDS["right"])
    at_end = result.contacts.frame == 75
    names = {result.names[i] for i in result.contacts.other[at_end].tolist()}
    assert "box" in names
    assert "stand" not in names
    assert grasp.held_by_both(result) == 1.0
    # A box without contact: the measure can fail.
    away = play.motion.with_frames(
        play.motion.translation - np.array([2.0, 0.0, 0.0]), play.motion.rotations
    )
    alone = simulate(away, play.scene, body=who, settings=Settings(substeps=8))
    assert grasp.held_by_both(alone) == 0.0


@pytest.mark.parametrize("triangles", [8_000, 30_000])
def test_the_room_is_closed_and_its_pieces_are_convex(triangles):
    made = room.room(triangles)
    assert triangles <= len(made.mesh.faces) < 1.5 * triangles
    assert made.mesh.closed
    assert len(made.hulls) == len(room.furniture())
    for piece in room.furniture():
        vertices, faces = room.rounded_box(piece, 0.1)
        mesh = Mesh(vertices, faces)
        assert mesh.closed
        # The sides between rounded edges are flat or bulge: the hull adds only chords.
        assert mesh.volume == pytest.approx(mesh.hull.volume, rel=2e-3)
        assert mesh.volume > 0.0
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        np.testing.assert_allclose(low[:2], piece.low[:2], atol=1e-9)
        np.testing.assert_allclose(high[:2], piece.high[:2], atol=1e-9)


def test_what_stands_off_is_a_metre_off():
    motion = clips.story().motion[60:90]
    low, high = near.reached(motion)
    for piece in near._furniture(low - near.OFF, high + near.OFF):
        gap = max(low[1] - piece.high[1], piece.low[1] - high[1])
        assert gap == pytest.approx(near.OFF)


@pytest.mark.parametrize(
    "shape",
    [Sphere(0.3), Capsule(0.1, 0.4), Cylinder(0.2, 0.5), Box((0.1, 0.2, 0.3)), Plane()],
    ids=lambda shape: type(shape).__name__,
)
def test_the_peer_has_the_scene_where_ours_has_it(shape):
    """The smallest distance to a rotated object equals our own core's."""
    import mujoco

    who = clips.body()
    motion = clips.straight(0.0, 0.1, 0.0)
    turn = rot.exp([0.3, -1.2, 0.1])  # a plane is a wall before the person
    if isinstance(shape, Plane):
        shape = Plane((0.0, 0.6, 0.8), 0.05)
    scene = Scene()
    scene.add_static("it", shape, position=(1.0, 0.1, -0.1), quaternion=turn)
    settings = Settings(clearance_range=5.0)
    ours = Simulator(scene, body=who, settings=settings).reset(motion[0]).clearance
    peer = MujocoLoop(who, motion.fps, 2, scene)
    model, data = peer.model, peer.data
    qpos = peer.coordinates(motion.translation, motion.rotations, motion.axes)
    data.qpos[:] = qpos[0]
    mujoco.mj_kinematics(model, data)
    it = 0  # geoms are numbered by body, and the world comes first
    assert model.geom_bodyid[it] == 0
    if isinstance(shape, Plane):
        normal, points = data.geom_xmat[it].reshape(3, 3)[:, 2], who.vertices(motion)[0]
        theirs = ((points - data.geom_xpos[it]) @ normal).min()
    else:
        pairs = range(1, model.ngeom)
        theirs = min(mujoco.mj_geomDistance(model, data, i, it, 5.0, None) for i in pairs)
    assert 0.1 < ours < 5.0
    # A cylinder is the prism around it here; the parts' hulls hold the skin within a micrometre.
    assert ours == pytest.approx(theirs, abs=3e-4)
    assert peer.deepest(qpos) == 0.0
    qpos[:, :3] += 0.9 * (np.array([1.0, 0.1, -0.1]) - qpos[0, :3])
    assert peer.deepest(qpos) > 0.005


def test_what_is_past_the_face_is_measured_in_millimetres():
    who = clips.body()
    one = clips.straight(1.5, 1.0, -0.4)
    reach = past_face(who, one)
    further = one.with_frames(one.translation + np.array([0.1, 0.0, 0.0]), one.rotations)
    assert reach > 0.0
    assert past_face(who, further) == pytest.approx(reach + 100.0, abs=1e-6)
    before = one.with_frames(one.translation - np.array([9.0, 0.0, 0.0]), one.rotations)
    assert past_face(who, before) == 0.0


def test_the_peer_step_by_step_is_the_peer_at_once():
    motion = clips.story().motion[60:70]
    peer = MujocoLoop(clips.body(), motion.fps, 2)
    whole = peer.run(motion)
    assert metrics.mpjpe_global(whole, motion, clips.body()) <= EXACT_MM
    peer.reset(motion[0])
    for t in range(1, len(motion)):
        translation, rotations = peer.step(motion[t])
        np.testing.assert_array_equal(translation, whole.translation[t])
        np.testing.assert_array_equal(rotations, whole.rotations[t])


def test_sides_take_turns():
    order = []
    options = Options(repeats=3, quick=True)
    sides = ["ours", "parts", "peer"]
    done = timing.in_turns([lambda s=side: order.append(s) or s for side in sides], options)
    assert order == [*sides, *sides, *reversed(sides), *sides]
    assert [len(side.seconds) for side in done] == [3, 3, 3]
    assert [side.result for side in done] == sides


def test_a_ratio_pairs_the_runs_of_one_turn():
    record = Record(
        case="free",
        setting="",
        frames=1,
        ours=(100.0, 10.0, 60.0),
        parts=(100.0, 20.0, 120.0),
        peer=(50.0, 5.0, 20.0),
    )
    assert (record.parts_ratio, record.ratio) == (0.5, 2.0)
    assert (record.middle, record.parts_middle, record.peer_middle) == (60.0, 100.0, 20.0)
    alone = Record(case="free", setting="", frames=1, ours=(1.0,))
    assert alone.ratio is alone.parts_ratio is None


def test_the_ring_is_closed_and_faces_outwards():
    mesh = ring()
    assert mesh.faces.shape == (10_000, 3)
    edges = np.concatenate([mesh.faces[:, [i, (i + 1) % 3]] for i in range(3)])
    forward = {tuple(e) for e in edges.tolist()}
    assert len(forward) == len(edges)
    assert {(b, a) for a, b in forward} == forward
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    # A torus of these radii; the lumps change it by a hundredth.
    assert volume == pytest.approx(2.0 * np.pi**2 * 0.6 * 0.3**2, rel=0.03)


def test_one_table_per_case(clip, capsys):
    assert (
        main(["bench", "--quick", "--repeats", "1", "--case", "skinning", "--case", "doorway"]) == 0
    )
    out = capsys.readouterr().out
    assert "doorway: the demo's story" in out
    assert "skinning: " in out
    assert "free: " not in out
    assert "ours [frames/s]" in out
    assert "ours/parts" in out
    assert "ours/baseline" not in out  # neither run has one


def test_mistakes(tmp_path, capsys):
    assert main(["bench", "--case", "fre"]) == MISTAKE
    assert "unknown case 'fre', expected one of free, live" in capsys.readouterr().err
    assert main(["bench", "--json", str(tmp_path / "no" / "b.json")]) == MISTAKE
    assert "does not exist" in capsys.readouterr().err
    assert main(["bench", "--repeats", "0"]) == MISTAKE
    assert "repeats: expected a number of at least 1" in capsys.readouterr().err
    assert main(["bench", "--motion", str(tmp_path / "none.npz")]) == MISTAKE
    assert "none.npz" in capsys.readouterr().err
    with pytest.raises(InputError, match="unknown case 'x'"):
        bench.run("x", Options())

"""`halfphysics bench`: it runs, its records are complete, and the peer does the work we do."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from halfphysics import bench, metrics
from halfphysics.bench import clips, timing
from halfphysics.bench.measuring import ring
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.record import Options, Record
from halfphysics.bench.wall import past_face
from halfphysics.cli import MISTAKE, main
from halfphysics.errors import InputError

# Rounding of positions of a few metres through 8 substeps a frame; measured 1e-12 mm.
EXACT_MM = 1e-6
SETTINGS = {
    "free": 8,
    "live": 8,
    "stepper": 8,
    "wall": 6,
    "doorway": 2,
    "metrics": 1,
    "skinning": 1,
}
WITH_PEER = {"free", "live", "stepper", "wall"}


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "tiny.npz"
    clips.story().motion[60:70].save(path)
    return path


@pytest.fixture(scope="module")
def measured(clip, tmp_path_factory):
    """What one quick run of all cases writes."""
    out = tmp_path_factory.mktemp("bench") / "bench.json"
    arguments = ["bench", "--quick", "--repeats", "1", "--motion", str(clip), "--json", str(out)]
    assert main(arguments) == 0
    return json.loads(out.read_text())


def test_all_cases_leave_complete_records(measured):
    assert measured["quick"]
    assert measured["repeats"] == 1
    assert {"mujoco", "numpy", "python", "cores", "threads"} <= set(measured["machine"])
    assert set(SETTINGS) == set(bench.CASES)
    for case, count in SETTINGS.items():
        records = [r for r in measured["records"] if r["case"] == case]
        # The clip given doubles the cases that play clips.
        assert len(records) == count * (2 if case in ("free", "live", "stepper") else 1)
        assert len({r["setting"] for r in records}) == len(records)
        for record in records:
            assert record["frames"] > 0
            assert record["unit"] == ("s" if case == "metrics" else "frames/s")
            assert len(record["ours"]) == 1
            assert all(math.isfinite(x) and x > 0.0 for x in record["ours"])
            assert (record["peer"] is not None) == (case in WITH_PEER)
            assert (record["ratio"] is not None) == (case in WITH_PEER)


def test_both_sides_follow_free_motion_exactly(measured):
    free = [r for r in measured["records"] if r["case"] in ("free", "live")]
    assert {r["setting"].split(",")[0] for r in free} == {"walk", "tiny"}
    for record in free:
        ours, peer = record["checks"]["MPJPE [mm]"]
        assert ours <= EXACT_MM
        assert peer <= EXACT_MM


def test_the_wall_stops_us_and_not_the_peer(measured):
    walls = [r for r in measured["records"] if r["case"] == "wall"]
    for record in walls:
        ours, peer = record["checks"]["past the wall's face [mm]"]
        assert ours == 0.0
        assert peer > 1.0  # soft contact; measured: tens of millimetres


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
    done = timing.in_turns(lambda: order.append("ours"), lambda: order.append("peer"), options)
    warm, turn = ["ours", "peer"], ["ours", "peer"]
    assert order == [*warm, *turn, *reversed(turn), *turn]
    assert len(done.ours) == len(done.peer) == 3


def test_a_ratio_pairs_the_runs_of_one_turn():
    record = Record(
        case="free", setting="", frames=1, ours=(100.0, 10.0, 60.0), peer=(50.0, 5.0, 20.0)
    )
    assert record.ratio == 2.0
    assert record.middle == 60.0
    assert record.peer_middle == 20.0
    assert Record(case="free", setting="", frames=1, ours=(1.0,)).ratio is None


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

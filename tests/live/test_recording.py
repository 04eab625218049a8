"""A session as a result file, whole or cut off."""

from __future__ import annotations

import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.body.soft_skin import SoftSkin
from halfphysics.errors import FileError
from halfphysics.formats.results import unfinished
from halfphysics.live import schema
from halfphysics.live.incoming import IncomingPose
from halfphysics.live.recording import Recorder
from halfphysics.live.session import Session
from halfphysics.results.inside import Depths


def record(session, path, frames=50, during=None):
    """Record some steps; returns the recorder, still open, and the frames."""
    recorder = Recorder(path, session.simulator)
    session.listen(recorder.add)
    made = []
    for k in range(frames):
        if during is not None:
            during(k)
        name = session.people[0]
        target = session.newest.targets[name]
        pose = hp.Pose(np.add(target.translation, (0.01, 0.0, 0.0)), target.rotations)
        session.deliver(IncomingPose(name, pose, k / 90))
        made.append(session.step())
    session.unlisten(recorder.add)
    return recorder, made


def test_a_recording_is_the_frames(session, tmp_path):
    recorder, frames = record(session, tmp_path / "out.npz")
    recorder.close()
    assert not recorder.partial.exists()
    result = hp.Result.load(tmp_path / "out.npz")
    assert (len(result), result.fps, recorder.left_out) == (50, pytest.approx(90.0), 0)
    assert result.names == ("floor", "wall", "ball", "person0", "person1")
    for i, name in enumerate(("person0", "person1")):
        person = result.people[i]
        moved = np.stack([f.poses[name].rotations for f in frames])
        np.testing.assert_array_equal(person.motion.rotations, moved)
        asked = np.stack([f.targets[name].translation for f in frames])
        np.testing.assert_array_equal(person.reference.translation, asked)
        torque = np.stack([f.simulated.torques[i] for f in frames])
        np.testing.assert_array_equal(person.torque, torque)
    ball = np.stack([f.objects["ball"][0] for f in frames])
    np.testing.assert_array_equal(result.objects["ball"].position, ball)
    np.testing.assert_array_equal(result.clearance, [f.clearance for f in frames])
    assert len(result.contacts) == sum(len(f.contacts.part) for f in frames)
    np.testing.assert_array_equal(
        result.contacts.impulse, np.concatenate([f.contacts.impulse for f in frames])
    )
    assert result.scene.statics["wall"].shape == hp.Box((0.2, 4, 2))
    assert result.settings == session.simulator.settings


def test_what_comes_and_goes_rests_meanwhile(session, tmp_path):
    add = schema.Add("crate", "box:0.2:0.2:0.2", 2.0, (0.0, 3.0, 1.0))

    def during(k):
        if k in (10, 30):
            session.edit(add if k == 10 else schema.Remove("crate"), lambda reason: None)

    recorder, frames = record(session, tmp_path / "out.npz", during=during)
    recorder.close()
    result = hp.Result.load(tmp_path / "out.npz")
    assert len(result) == 50
    crate = result.objects["crate"].position
    there = np.stack([f.objects["crate"][0] for f in frames if "crate" in f.objects])
    np.testing.assert_array_equal(crate[10:30], there)
    np.testing.assert_array_equal(crate[:10], np.repeat(there[:1], 10, axis=0))
    np.testing.assert_array_equal(crate[30:], np.repeat(there[-1:], 20, axis=0))
    assert set(result.names[-2:]) == {"person0", "person1"}
    assert "crate" in result.scene.objects
    # Names of contacts are those of the frame in which they were.
    row = 0
    for frame in frames:
        for other in frame.contacts.other:
            assert result.names[result.contacts.other[row]] == frame.names[other]
            row += 1


def test_what_comes_beside_moving_and_articulated_things_is_measured(tmp_path, scene):
    """Free objects stand before these in a scene and its results, whenever they came."""
    file = tmp_path / "door.xml"
    file.write_text(
        "<mujoco><worldbody><body name='leaf'><joint name='hinge'/><geom type='box' "
        "size='0.4 0.02 0.5'/></body></worldbody></mujoco>"
    )
    scene.add_articulated("door", file, position=(5.0, 0.0, 1.0))
    scene.add_moving("belt", hp.Box((1, 1, 0.1)), [(5, 5, 0.5), (6, 5, 0.5)], fps=1.0)
    session = Session(scene)

    def during(k):
        if k == 5:
            add = schema.Add("crate", "box:0.2:0.2:0.2", 2.0, (0.0, 3.0, 0.1))
            session.edit(add, lambda reason: None)

    recorder, frames = record(session, tmp_path / "out.npz", 20, during)
    recorder.close()
    result = hp.Result.load(tmp_path / "out.npz")
    assert result.names == frames[-1].names
    assert tuple(result.objects) == ("ball", "crate", "belt", "door/leaf")
    assert len(result.parts()) == 20
    met = [f.names[i] for f in frames for i in f.contacts.other]
    assert [result.names[i] for i in result.contacts.other] == met


def test_what_is_added_to_the_scene_later_is_not_in_the_recording(session, scene, tmp_path):
    scene.add_static("late", hp.Box((1, 1, 1)), position=(0, 9, 0))
    recorder, _ = record(session, tmp_path / "out.npz", 5)
    recorder.close()
    result = hp.Result.load(tmp_path / "out.npz")
    assert set(result.scene.statics) == {"floor", "wall"}
    assert len(result.parts()) == 5


def test_overlaps_are_recorded(tmp_path):
    """Of a crate that starts in the floor; names of later frames have other indices."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("sunk", hp.Box((0.3, 0.3, 0.3)), mass=1.0, position=(2, 0, 0.1))
    session = Session(scene)

    def during(k):
        if k == 10:
            add = schema.Add("crate", "box:0.2:0.2:0.2", 2.0, (0.0, 3.0, 1.0))
            session.edit(add, lambda reason: None)

    recorder, frames = record(session, tmp_path / "out.npz", 20, during)
    recorder.close()
    result = hp.Result.load(tmp_path / "out.npz")
    assert len(result.inside.at(0)) > 0
    for k, frame in enumerate(frames):
        mine, got = frame.simulated.inside, result.inside.at(k)
        for name in ("person", "part", "depth"):
            np.testing.assert_array_equal(getattr(got, name), getattr(mine, name))
        for name in ("subject", "other"):
            now = [frame.names[i] for i in getattr(mine, name)]
            assert [result.names[i] for i in getattr(got, name)] == now
    assert len(result.breaches) == 0


def test_breaches_and_corrections_are_recorded(session, tmp_path):
    """None happen in a test: frames are told of some."""

    def told(frame):
        row = {"person": [1], "part": [3], "subject": [-1], "other": [1], "depth": [0.02]}
        odd = {"breaches": Depths(**row), "corrected": np.array([frame.frame % 3 == 0, True])}
        vars(frame.simulated).update(odd)

    session.listen(told)
    recorder, frames = record(session, tmp_path / "out.npz", 12)
    recorder.close()
    result = hp.Result.load(tmp_path / "out.npz")
    np.testing.assert_array_equal(result.breaches.frame, np.arange(12))
    assert {result.names[i] for i in result.breaches.other} == {"wall"}
    assert (result.breaches.depth == 0.02).all()
    corrected = [frame.frame % 3 == 0 for frame in frames]
    np.testing.assert_array_equal(result.people[0].corrected, corrected)
    assert result.people[1].corrected.all()


def soft_session():
    """Somebody with soft skin, far from a ball that lies on a mattress."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("bed", hp.Box((1, 1, 0.4)), position=(3, 0, 0.2), soft="mattress")
    scene.add_object("ball", hp.Sphere(0.1), mass=5.0, position=(3, 0, 0.49))
    skin = SoftSkin(thickness={"hands": 0.004})
    return Session(scene, settings=hp.Settings(soft_skin=skin), fps=30)


def test_pressures_are_recorded(tmp_path):
    session = soft_session()

    def during(k):
        if k == 10:  # names of later frames have other indices
            add = schema.Add("crate", "box:0.2:0.2:0.2", 2.0, (0.0, 3.0, 1.0))
            session.edit(add, lambda reason: None)

    recorder, frames = record(session, tmp_path / "out.npz", 20, during)
    recorder.close()
    result = hp.Result.load(tmp_path / "out.npz")
    assert result.settings == session.simulator.settings
    pressed, row = result.soft_contacts, 0
    for k, frame in enumerate(frames):
        mine = frame.simulated.soft_contacts
        got = pressed[row : row + len(mine)]
        assert (got.frame == k).all()
        for name in ("part", "vertex", "position", "normal", "depth", "pressure", "area"):
            assert np.array_equal(getattr(got, name), getattr(mine, name))
        for name in ("layer", "other"):
            now = [frame.names[i] for i in getattr(mine, name)]
            assert [result.names[i] for i in getattr(got, name)] == now
        row += len(mine)
    assert 0 < row == len(pressed)
    assert {result.names[i] for i in pressed.layer} == {"bed"}
    assert result.dents["bed"].depth.max() > 0.005


def test_very_many_pressures_are_read_of_every_second_frame(tmp_path, monkeypatch):
    recorder, _ = record(soft_session(), tmp_path / "out.npz", 12)
    recorder._frames.put(None)
    recorder._thread.join()
    recorder._file.close()
    whole = hp.Result.load(recorder.partial).soft_contacts
    monkeypatch.setattr("halfphysics.simulation.recording.MOST_PRESSED", len(whole) // 2 + 10)
    with pytest.warns(hp.HalfPhysicsWarning, match="of one frame in 2:"):
        some = hp.Result.load(recorder.partial).soft_contacts
    assert np.array_equal(some.pressure, whole[whole.frame % 2 == 0].pressure)


def test_an_unfinished_recording_is_a_result(session, tmp_path):
    """What was stepped more than a block ago is there, whatever happens to the process."""
    recorder, frames = record(session, tmp_path / "out.npz", frames=30)
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        try:
            result = hp.Result.load(recorder.partial)
            if len(result) == 30:
                break
        except FileError:
            pass
        time.sleep(0.05)
    assert len(result) == 30
    np.testing.assert_array_equal(
        result.motion.translation, [f.poses["person0"].translation for f in frames]
    )
    recorder.close()


def test_an_earlier_recording_is_not_overwritten(session, tmp_path):
    (tmp_path / "out.npz.unfinished").write_bytes(b"precious")
    with pytest.raises(FileError, match="not finished"):
        Recorder(tmp_path / "out.npz", session.simulator)
    assert (tmp_path / "out.npz.unfinished").read_bytes() == b"precious"


def test_without_frames_nothing_stays(session, tmp_path):
    """A session that did not start, as its port is in use, does not stop the next one."""
    for _ in range(2):
        Recorder(tmp_path / "out.npz", session.simulator).close()
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyError("a fault")])
def test_frames_after_a_block_that_was_cut_off_are_kept(session, tmp_path, monkeypatch, fault):
    """A disk that is full for a while costs the frames of that time only."""
    write, calls = unfinished.write_frames, []

    def fails_once(file, fields):
        calls.append(len(fields["clearance"]))
        write(file, fields)
        if len(calls) == 1:
            file.seek(-100, 2)
            file.truncate()
            raise fault

    monkeypatch.setattr(unfinished, "write_frames", fails_once)
    monkeypatch.setattr("halfphysics.live.recording._EVERY", 0.0)  # each frame is a block
    recorder, frames = record(session, tmp_path / "out.npz", frames=20)
    recorder.close()
    assert (calls[0], recorder.left_out) == (1, 1)
    result = hp.Result.load(tmp_path / "out.npz")
    np.testing.assert_array_equal(
        result.motion.translation, [f.poses["person0"].translation for f in frames[1:]]
    )


def test_a_folder_that_is_not_there(session, tmp_path):
    with pytest.raises(FileError, match="cannot write"):
        Recorder(tmp_path / "nowhere" / "out.npz", session.simulator)

"""The examples run, and their claims hold."""

from __future__ import annotations

import json
import runpy
import struct
from pathlib import Path

import numpy as np
import pytest

from support.paths import ROOT, TESTS

pytestmark = pytest.mark.slow

EXAMPLES = ROOT / "examples"


def example(name):
    """The names that an example defines."""
    return runpy.run_path(str(EXAMPLES / name), run_name="example")


def test_every_example_is_tested():
    tested = Path(__file__).read_text(encoding="utf-8")
    tested += (TESTS / "sweep" / "store" / "test_reading.py").read_text(encoding="utf-8")
    for path in EXAMPLES.glob("*.py"):
        assert f'("{path.name}"' in tested


def test_walk_into_wall(capsys):
    result = example("01_walk_into_wall.py")["main"]()
    # The face is at 1.95 m; the pelvis stays behind it while the walk goes on to 4 m.
    assert 1.5 < result.motion.translation[:, 0].max() < 1.95
    assert result.reference.translation[:, 0].max() > 3.9
    assert result.clearance.min() > 0.0
    assert "touched the wall" in capsys.readouterr().out


def test_kick_a_ball():
    found = example("02_kick_a_ball.py")["main"]()
    for mass, (speed, given, floor) in found.items():
        # Momentum is balanced; the speed is the mean over a frame in which friction acts.
        assert mass * speed == pytest.approx(given + floor, rel=0.02)
    speeds = [speed for speed, _, _ in found.values()]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] > 3.0
    assert speeds[-1] < 0.2 * speeds[0]


def test_own_scene(tmp_path):
    result = example("03_own_scene.py")["main"](tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["motion.npz", "result.npz", "room.yaml"]
    touched = {result.names[k] for k in np.unique(result.contacts.other)}
    assert {"post", "crate"} <= touched
    crate = result.objects["crate"].position
    assert crate[-1, 0] - crate[0, 0] > 0.2  # pushed along
    assert result.people[0].body.stature == pytest.approx(1.80)


def test_beside_a_robot():
    turned = [turn for turn, _ in example("04_beside_a_robot.py")["main"]().values()]
    assert turned == sorted(turned, reverse=True)  # the stiffer the joints, the less they give
    assert turned[0] > np.radians(10.0)
    assert turned[-1] < np.radians(2.0)


def test_first_steps_in_a_notebook(tmp_path, monkeypatch, capsys):
    """The cells run in their order, in one namespace; outputs are not kept in the file."""
    monkeypatch.chdir(tmp_path)
    notebook = json.loads((EXAMPLES / "first_steps.ipynb").read_text(encoding="utf-8"))
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    names = {"__name__": "__main__"}
    for cell in notebook["cells"]:
        assert cell["id"]
        if cell["cell_type"] != "code":
            continue
        assert cell["outputs"] == []
        assert cell["execution_count"] is None
        code = compile("".join(cell["source"]), f"first_steps.ipynb, {cell['id']}", "exec")
        exec(code, names)
    said = capsys.readouterr().out
    assert "the ball went" in said
    assert names["result"].clearance.min() > 0.0
    assert names["before"].depth_max_mm > 10.0
    assert names["after"].depth_max_mm == 0.0
    assert (tmp_path / "result.glb").is_file()


def test_ros2_messages(tmp_path):
    """Read back by rosbags, an implementation of CDR and of these messages of its own."""
    typesys = pytest.importorskip("rosbags.typesys")
    from support.results import takes

    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    names = example("09_ros2_messages.py")
    result = takes.result(1)
    (person,) = result.people
    topics = names["messages"](result, 7)
    tf, joints, markers = topics["tf"], topics["joint_states"], topics[f"markers_{person.name}"]
    found = store.deserialize_cdr(tf, "tf2_msgs/msg/TFMessage")
    assert store.serialize_cdr(found, "tf2_msgs/msg/TFMessage").tobytes() == tf
    positions, quaternions = person.body.joint_frames(person.motion[7])
    first = found.transforms[0]
    assert (first.header.frame_id, first.child_frame_id) == ("world", f"{person.name}/pelvis")
    place = first.transform.translation
    assert np.array_equal([place.x, place.y, place.z], positions[0])
    turn = first.transform.rotation
    assert np.array_equal([turn.w, turn.x, turn.y, turn.z], quaternions[0])
    assert len(found.transforms) == 55 + len(result.objects)
    state = store.deserialize_cdr(joints, "sensor_msgs/msg/JointState")
    assert list(state.name) == list(result.joints)
    assert np.allclose(state.position, [np.ravel(v[7])[0] for v in result.joints.values()])
    assert state.header.stamp.nanosec == round(7 / 30 * 1e9)
    assert store.serialize_cdr(state, "sensor_msgs/msg/JointState").tobytes() == joints
    (marker,) = store.deserialize_cdr(markers, "visualization_msgs/msg/MarkerArray").markers
    assert (marker.ns, marker.type, len(marker.points)) == (person.name, 7, 55)
    array = store.deserialize_cdr(markers, "visualization_msgs/msg/MarkerArray")
    again = store.serialize_cdr(array, "visualization_msgs/msg/MarkerArray").tobytes()
    assert again == markers
    result.save(tmp_path / "result.npz")
    assert names["main"](tmp_path / "result.npz", tmp_path / "ros2") == 3 * len(result.motion)


@pytest.mark.parametrize("seconds", [0.0, 7 / 30, 1000.9999999999999, 2.0**31 - 1.5])
def test_ros2_times_have_less_than_a_second_of_nanoseconds(seconds):
    cdr = example("09_ros2_messages.py")["Cdr"]()
    cdr.header(seconds, "world")
    whole, rest = struct.unpack_from("<iI", cdr.bytes(), 4)
    assert rest < 10**9
    assert whole + 1e-9 * rest == pytest.approx(seconds, abs=1e-6)


def test_people_who_react(capsys):
    result = example("07_people_who_react.py")["main"]()
    told = capsys.readouterr().out
    assert told.count("done True") == 2
    assert "person0 sits" in told
    touched = {result.names[k] for k in np.unique(result.contacts.other)}
    assert touched <= {"floor", "bench", "cup", "table"}, "nobody touches the pillar or each other"
    assert "bench" in touched


def test_learn_to_pass():
    """Few steps: that it runs, and says four scores; learning is for the campaign."""
    pytest.importorskip("stable_baselines3")
    found = example("08_learn_to_pass.py")["main"](steps=64, episodes=2, worlds=2)
    assert list(found) == ["by chance", "by hand", "PPO before", "PPO after"]


def test_soft_seat():
    """Two seats of much the same area: on the thin one the pressure peaks over the frame."""
    found = example("10_soft_seat.py")["main"]()
    pad, sofa = found.values()
    assert 2.0 < sofa[0] < 40.0  # [kPa]
    assert pad[0] > 1.5 * sofa[0]
    assert 200.0 < sofa[1] < 2500.0  # [cm^2]

"""Changes of a scene while it runs."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.errors import InputError
from halfphysics.live import bounds, schema
from halfphysics.live.edits import Editor
from halfphysics.motion.skeleton import JOINT_INDEX


@pytest.fixture
def editor(session):
    return Editor(session.simulator, session.people)


def scene_of(editor):
    return editor.simulator.world.scene


def step(session):
    """A frame; what is at rest stays."""
    return session.step()


def test_add_and_remove(session):
    editor = session._editor
    action = schema.Add("crate", "box:0.4:0.3:0.2", 5.0, (0.0, 2.0, 1.0), friction=0.3)
    assert editor.do(action, "a")
    assert scene_of(editor).objects["crate"].mass == 5.0
    assert scene_of(editor).objects["crate"].friction == 0.3
    frame = step(session)
    assert frame.objects["crate"][0][2] < 1.0  # it falls
    assert editor.do(schema.Remove("crate"), "a")
    assert "crate" not in step(session).objects


def test_mass_and_friction(editor):
    assert editor.do(schema.Mass("ball", 3.0), "a")
    assert editor.do(schema.Friction("wall", 0.2), "a")
    assert scene_of(editor).objects["ball"].mass == 3.0
    assert scene_of(editor).statics["wall"].friction == 0.2


def test_an_impulse_moves(session):
    assert not session._editor.do(schema.Impulse("ball", (0.0, 2.0, 0.0)), "a")
    before = session.newest.objects["ball"][0]
    moved = step(session).objects["ball"][0] - before
    assert moved[1] == pytest.approx(2.0 / 90.0, rel=0.05)


def test_stiffness_of_one_person(session):
    editor = session._editor
    assert not editor.do(schema.Stiffness({"arms": 0.5}, "person1"), "a")
    firmness = editor.simulator._firmness
    wrist = JOINT_INDEX["left_wrist"]
    assert (firmness[0, wrist], firmness[1, wrist]) == (1.0, 0.5)


def test_dragging_follows_the_pointer_and_ends_with_its_client(session):
    editor = session._editor
    editor.do(schema.Drag("ball", (1.0, 1.0, 0.1)), "a")
    for k in range(90):
        editor.do(schema.Drag("ball", (1.0, 1.0, 0.1 + 0.01 * k)), "a")
        frame = step(session)
    assert frame.objects["ball"][0][2] == pytest.approx(0.99, abs=0.1)
    session.leave("a")
    step(session)
    assert editor.drags == {}
    editor.do(schema.Drag("ball", (1.0, 1.0, 1.0)), "b")
    editor.do(schema.Drag("ball", None), "b")
    assert editor.drags == {}


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (schema.Add("a", "/etc/passwd", 1.0, (0, 0, 1)), "expected one of sphere"),
        (schema.Add("a", "room.glb", 1.0, (0, 0, 1)), "expected one of sphere"),
        (schema.Add("a", "plane", 1.0, (0, 0, 1)), "expected one of sphere"),
        (schema.Add("a", "sphere:1,scale=2", 1.0, (0, 0, 1)), "expected one of sphere"),
        (schema.Add("a", "sphere:-1", 1.0, (0, 0, 1)), "radius"),
        (schema.Add("ball", "sphere:1", 1.0, (0, 0, 1)), "already"),
        (schema.Add("person0", "sphere:1", 1.0, (9, 9, 1)), "person0"),
        (schema.Remove("wall"), "wall"),
        (schema.Mass("ball", float("nan")), "mass"),
        (schema.Friction("moon", 1.0), "expected one of"),
        (schema.Impulse("ball", (float("inf"), 0, 0)), "impulse"),
        (schema.Stiffness(1.0, "eve"), "expected one of person0, person1"),
        (schema.Drag("wall", (0, 0, 0)), "moves freely"),
    ],
)
def test_what_is_impossible_changes_nothing(editor, action, said):
    before = editor.simulator.get_state().numbers
    with pytest.raises(InputError, match=said):
        editor.do(action, "a")
    assert editor.simulator.get_state().numbers == before


@pytest.mark.parametrize("error", [InputError, RuntimeError])
def test_an_object_is_in_the_world_once_it_may_be(editor, monkeypatch, error):
    """Servers look at the world from another thread; and a fault leaves it as it was."""
    world, seen = editor.simulator.world, []

    def check(new, name):
        seen.append((name in new.names, editor.simulator.world is world))
        raise error("no")

    monkeypatch.setattr(bounds, "check_clear", check)
    with pytest.raises(error):
        editor.do(schema.Add("a", "sphere:0.1", 1.0, (5.0, 5.0, 1.0)), "a")
    assert seen == [(True, True)]
    assert editor.simulator.world is world
    assert editor.added == set()


def test_objects_are_bounded(editor, monkeypatch):
    monkeypatch.setattr(bounds, "MOST_OBJECTS", 2)
    editor.do(schema.Add("a", "sphere:0.1", 1.0, (5.0, 5.0, 1.0)), "a")
    with pytest.raises(InputError, match="Remove some first"):
        editor.do(schema.Add("b", "sphere:0.1", 1.0, (5.0, 6.0, 1.0)), "a")
    assert np.isfinite(editor.simulator.world.stepper.qpos()).all()

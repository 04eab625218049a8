"""Judging files: results, truths, processes, and what happens to files that cannot be read."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli.judge import Options
from halfphysics.cli.options import MotionOptions, SceneOptions
from halfphysics.errors import HalfPhysicsError
from halfphysics.formats import registry
from halfphysics.formats.format import Format
from halfphysics.formats.people import Track
from halfphysics.judging.judge import Judged, judge_one, judged
from halfphysics.judging.tasks import Task, tasks_of
from support.made_clips import walk


def test_judge_takes_paths(library):
    people = hp.judge(library, jobs=1)
    assert [one.verdict is None for one in people] == [False, True, False]
    one = hp.judge([library / "a.npz"], truth=library / "a.npz", jobs=1)[0].verdict
    assert one.values["mpjpe_mm"] == 0.0
    with pytest.raises(HalfPhysicsError, match="jobs: found 0"):
        hp.judge(library, jobs=0)
    with pytest.raises(HalfPhysicsError, match="no such file"):
        hp.judge(library / "a.npz", scene=library / "gone.yaml")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"paths": None}, "path: expected the path of a file.*found None"),
        ({"paths": []}, "paths: found none, expected motion or result files"),
        ({"paths": 3}, "path: expected the path of a file.*found 3"),
        ({"truth": 3}, "path: expected the path of a file.*found 3"),
        ({"jobs": 1.5}, "jobs: found 1.5, expected a whole number"),
    ],
)
def test_wrong_arguments_are_named(library, arguments, message):
    with pytest.raises(HalfPhysicsError, match=message):
        hp.judge(**({"paths": library} | arguments))
    assert len(hp.judge(library / "a.npz", jobs=np.int64(1))) == 1


def test_a_broken_file_is_one_answer_and_processes_change_nothing(library):
    tasks, options = tasks_of([library], None), Options()
    alone = judged(tasks, options, 1, bar=False)
    assert [one.verdict is None for one in alone] == [False, True, False]
    assert "broken.npz" in alone[1].error
    shared = judged(tasks, options, 2, bar=False)
    assert [(o.name, o.error) for o in shared] == [(o.name, o.error) for o in alone]
    for a, b in zip(alone, shared, strict=True):
        assert (a.verdict is None) == (b.verdict is None)
        if a.verdict is not None:
            assert dict(a.verdict.values) == dict(b.verdict.values)


def test_a_result_is_judged_in_its_scene(library):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(2.0, 0.0, 0.1))
    motions = [walk()[:6], walk(1)[:6]]
    moved = hp.Motion(
        motions[1].translation + np.array([0.0, 3.0, 0.0]), motions[1].rotations, 30.0
    )
    result = hp.simulate([motions[0], moved], scene)
    result.save(library / "result.npz")
    people = judge_one((Task(library / "result.npz"), Options()))
    assert len(people) == 2
    for one, person in zip(people, result.people, strict=True):
        assert one.name.endswith(f":{person.name}")
        direct = hp.metrics.judge(person.motion, person.body, result.scene, objects=result.objects)
        assert set(one.verdict.values) == set(direct.values)
        assert "hand_contact_percent" in one.verdict.values
        for key, value in direct.values.items():
            assert one.verdict[key] == pytest.approx(value, abs=1e-9, nan_ok=True), key


def test_a_scene_and_a_truth_of_another_length(library):
    walk()[:10].save(library / "short.npz")
    options = Options(around=SceneOptions(static=("wall=box:1:1:1",)))
    (fine,) = judge_one((Task(library / "a.npz", truth=library / "a.npz"), options))
    assert fine.verdict["mpjpe_mm"] == pytest.approx(0.0, abs=1e-9)
    assert np.isfinite(fine.verdict["non_collision_percent"])
    (wrong,) = judge_one((Task(library / "a.npz", truth=library / "short.npz"), options))
    assert wrong.verdict is None
    assert "truth: found 10 frames, expected 40" in wrong.error
    assert wrong.error.startswith(str(library / "a.npz"))


def test_a_fault_of_a_reader_is_an_error_of_its_clip(library, monkeypatch):
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("halfphysics.judging.judge._motion", fail)
    assert judge_one((Task(library / "a.npz"), Options())) == [
        Judged(
            str(library / "a.npz"),
            error=f"{library / 'a.npz'}: ZeroDivisionError: division by zero",
        )
    ]


def test_a_clip_that_takes_all_memory_is_an_error_of_its_own(library, monkeypatch):
    def fail(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("halfphysics.judging.judge._motion", fail)
    (one,) = judged([Task(library / "a.npz")], Options(), 1, bar=False)
    assert one.verdict is None
    assert "memory" in one.error


def test_a_truth_is_read_as_the_clips_are(library):
    """--frames cuts both."""
    options = Options(motion_file=MotionOptions(frames="0:12"))
    (one,) = judge_one((Task(library / "a.npz", truth=library / "deep" / "b.npz"), options))
    assert one.verdict.frames == 12
    assert one.verdict["mpjpe_mm"] > 1.0


def test_each_person_whom_a_file_tracks_is_judged(library, monkeypatch):
    """Over their own frames; one who is there too briefly is an error of their own."""
    lengths = {"anne": 20, "bert": 12, "carl": 1}
    format = Format(
        name="tracks",
        expects="tracks",
        sniff=lambda source: source.head[:6] == b"tracks",
        load=lambda source, options: walk()[: lengths[options.clip]],
        people=lambda source: [Track(name, 0, end) for name, end in lengths.items()],
    )
    monkeypatch.setitem(registry.FORMATS, "tracks", format)
    (library / "two.tracks").write_bytes(b"tracks of people")
    (task,) = tasks_of([library / "two.tracks"], None)
    people = judge_one((task, Options()))
    assert [one.name.rpartition(":")[2] for one in people] == list(lengths)
    assert [one.verdict and one.verdict.frames for one in people] == [20, 12, None]
    assert people[2].error.startswith(f"{library / 'two.tracks'}:carl: ")
    (bert,) = judge_one((task, Options(motion_file=MotionOptions(clip="bert"))))
    assert bert.verdict.frames == 12

"""The tasks by name."""

import pytest

from halfphysics.envs.task import Task
from halfphysics.envs.tasks import TASKS, names, task_class
from halfphysics.errors import InputError


def test_every_name_is_a_task_with_its_words():
    for name in names():
        made = task_class(name)
        assert issubclass(made, Task)
        assert made.__name__ == name
        assert TASKS[name][1].startswith("a robot")
        assert made.rewards


def test_a_name_that_is_not_there():
    with pytest.raises(InputError, match="'HandOver'"):
        task_class("HandOvr")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"count": 0}, "num_envs: found 0"),
        ({"count": None}, "num_envs: found None"),
        ({"threads": 0}, "threads"),
        ({"steps": 1.5}, "steps"),
    ],
)
def test_impossible_numbers(given, words):
    with pytest.raises(InputError, match=words):
        task_class("HandOver")(**({"count": 1} | given))


@pytest.mark.parametrize("name", [["HandOver"], None, 3, b"HandOver"])
def test_what_is_no_name_is_refused(name):
    with pytest.raises(InputError, match="task: found"):
        task_class(name)

"""Layouts of observations and actions: ranges, spaces, tables."""

import gymnasium
import numpy as np
import pytest

from halfphysics.envs.channels import XYZ, Channel, Layout
from halfphysics.envs.tasks import names, task_class
from support.paths import ROOT

LAYOUT = Layout(Channel("place", "m", -1.0, 2.0, XYZ), Channel("held", "", 0.0, 1.0))


def test_a_layout_is_a_box_of_its_ranges():
    space = LAYOUT.space()
    assert isinstance(space, gymnasium.spaces.Box)
    assert space.low.tolist() == [-1.0, -1.0, -1.0, 0.0]
    assert space.high.tolist() == [2.0, 2.0, 2.0, 1.0]
    assert space.dtype == np.float32


def test_what_is_beyond_its_range_is_cut_off():
    cut = LAYOUT.cut(np.array([[-3.0, 0.5, 9.0]]), np.array([1.0]))
    assert cut.dtype == np.float32
    assert cut.tolist() == [[-1.0, 0.5, 2.0, 1.0]]
    checked = LAYOUT.checked([[np.nan, np.inf, -9.0, 0.5]])
    assert checked.tolist() == [[0.0, 0.0, -1.0, 0.5]]


def test_the_table_says_what_the_numbers_mean():
    lines = LAYOUT.table().splitlines()
    assert lines[2] == "| 0 to 2 | place (x, y, z) | m | -1 to 2 |"
    assert lines[3] == "| 3 | held | 1 | 0 to 1 |"


@pytest.mark.parametrize("task", names())
def test_the_document_has_the_tables_and_the_rewards_of_every_task(task):
    text = (ROOT / "docs" / "envs.md").read_text(encoding="utf-8")
    made = task_class(task)
    for layout in (made.observed, made.actions, made.human_observed, made.human_actions):
        assert layout.table() in text, layout.table()
    for term, words in made.rewards.items():
        assert f"| `{term}` | {words} |" in text
    assert f'"halfphysics/{task}-v0"' in text

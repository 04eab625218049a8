"""The report in a terminal."""

from __future__ import annotations

import evidence_sample as sample
import pytest

from evidence.page import text


@pytest.fixture(scope="module")
def said():
    return text.summary(sample.document())


def test_what_is_not_reproduced_comes_first(said):
    lines = said.splitlines()
    counts = sample.document()["verdict"]
    assert lines[0].endswith(
        f"{counts['reproduced']} reproduced, {counts['direction']} direction confirmed, "
        f"{counts['not_reproduced']} not reproduced, "
        f"{counts['shown']} shown, {counts['missing']} missing"
    )
    first = said.split("\n\n")[1].splitlines()
    assert first[0] == "Not reproduced or missing:"
    assert [line.split()[0] for line in first[1:]] == ["✗", "✗", "–", "–", "table1:", "table4:"]
    assert first[1] == (
        "  ✗ table2, with half-physics, Depth_max [mm]: paper 0, ours 0.0213; expected 0.00"
    )


def test_every_figure_and_command_is_there(said):
    for section in sample.document()["sections"]:
        assert section["title"] in said
        assert f"  {section['command']}" in said.splitlines()
        for row in section["rows"]:
            for figure in row["figures"]:
                assert figure["name"][:30] in said


def test_columns_stand_under_each_other(said):
    table = said.split("Table 3: joint torques instead of velocities\n")[1].splitlines()[:3]
    assert table[0].index("paper") + 5 == table[1].index("83.109") + 6
    assert table[1].index("↗") == table[2].index("↗")
    assert table[0].index("expected") == table[1].index("at least 10")


def test_names_steer_no_terminal(said):
    assert "\x1b" not in said
    assert "\u202e" not in said
    said.encode("utf-8")


def test_an_empty_report_says_so():
    empty = {**sample.document(), "sections": [sample.section("x", "Nothing", "", [])]}
    assert text.summary(empty).endswith("Nothing\n  no rows")
    assert "Not reproduced" not in text.summary(empty)


def test_speed_is_said_the_same_way():
    assert "at least 952.94" in text.summary(sample.speed())


def test_rows_of_one_name_are_told_apart_by_their_data(said):
    table = said.split("Table 1")[1].split("\n\n")[0]
    assert "(dance, embedded, 12 clips)" in table
    assert "(daily motion, embedded, 8 clips)" in table


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
def test_terminals_without_our_signs_tell_verdicts_apart(said, encoding):
    plainer = text.summary(sample.document(), encoding=encoding)
    plainer.encode(encoding)
    assert [len(line) for line in plainer.splitlines()] == [len(x) for x in said.splitlines()]
    assert "  X table2, with half-physics" in plainer
    assert text.summary(sample.document(), encoding="utf-8") == said

"""Values of options: what is read, what is expected, and how help calls it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, get_type_hints

import pytest

from halfphysics.cli.joint_options import joint_spec
from halfphysics.cli.value_types import plain_spec
from halfphysics.settings import Settings

WORDS = Literal["skin", "parts"]


@pytest.mark.parametrize(
    ("kind", "metavar", "text", "value"),
    [
        (float, "NUMBER", "1e-3", 0.001),
        (int, "N", "12", 12),
        (str, "TEXT", "none", "none"),
        (Path, "PATH", "a/b", Path("a/b")),
        (float | None, "NUMBER", "none", None),
        (int | None, "N", "None", None),
        (str | None, "TEXT", "none", "none"),
        (Path | None, "PATH", "None", Path("None")),
        (WORDS, "skin|parts", "parts", "parts"),
        (WORDS | None, "skin|parts", "none", None),
        (float | Literal["lowest"] | None, "NUMBER|lowest", "lowest", "lowest"),
        (float | Literal["lowest"] | None, "NUMBER|lowest", "-1", -1.0),
        (str | tuple[int, int] | None, "TEXT", "640x480", "640x480"),
    ],
)
def test_what_is_read(kind, metavar, text, value):
    spec = plain_spec(kind)
    assert spec.metavar == metavar
    assert spec.instance_from_str([text]) == value


@pytest.mark.parametrize(
    ("kind", "text", "expected"),
    [
        (float, "x", "found 'x', expected a number"),
        (int | None, "1.5", "found '1.5', expected a whole number"),
        (WORDS, "hull", "found 'hull', expected skin or parts"),
        (float | Literal["lowest"], "low", "found 'low', expected a number or lowest"),
        (float, "none", "found 'none', expected a number"),
    ],
)
def test_what_is_expected(kind, text, expected):
    with pytest.raises(ValueError) as caught:
        plain_spec(kind).instance_from_str([text])
    assert str(caught.value) == expected


def test_other_types_are_left_to_tyro():
    assert plain_spec(tuple[int, ...]) is None
    assert plain_spec(bool) is None
    assert plain_spec(Literal[1, 2]) is None


def test_values_by_joint():
    types = get_type_hints(Settings)
    stiffness, strength = joint_spec(types["stiffness"]), joint_spec(types["strength"])
    assert stiffness.instance_from_str(["hands=1,legs=0.2"]) == {"hands": 1.0, "legs": 0.2}
    assert stiffness.instance_from_str(["2"]) == 2.0
    assert [strength.instance_from_str([word]) for word in ("none", "None", "human")] == [
        None,
        None,
        "human",
    ]
    assert strength.str_from_instance(None) == ["none"]
    with pytest.raises(ValueError, match="found 'x', expected human, none, or JOINTS=NUMBER"):
        strength.instance_from_str(["x"])
    assert joint_spec(float) is None

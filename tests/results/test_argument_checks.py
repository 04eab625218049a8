"""Wrong motions, bodies, scenes and settings are told the way to right ones."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics import Body, Motion, Scene, Settings
from halfphysics.errors import InputError
from halfphysics.results.argument_checks import (
    checked_bodies,
    checked_body,
    checked_motion,
    checked_scene,
    checked_settings,
    given_scene,
)
from halfphysics.simulation.sequence import Sequence

MOTION = Motion(np.zeros((2, 3)), np.zeros((2, 55, 3)), 30.0)
OF_A_SEQUENCE = " (s.motion, with s.scene, body=s.body and settings=s.settings)"
PATHS = ["a/b", Path("a/b")]


def test_right_ones_are_given_back():
    body, scene, settings = Body.default(), Scene(), Settings(stiffness=2.0)
    assert checked_motion(MOTION) is MOTION
    assert checked_body(body) is body
    assert checked_bodies((body, body)) == [body, body]
    assert checked_scene(scene) is given_scene(scene) is scene
    assert checked_settings(settings) is settings


def test_none_is_the_default():
    assert checked_body(None) is checked_bodies(None)[0] is Body.default()
    assert not checked_scene(None).statics
    assert not checked_scene(None).objects
    assert checked_settings(None) == Settings()


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize(
    ("check", "kind"),
    [
        (checked_motion, "Motion"),
        (checked_body, "Body"),
        (checked_bodies, "Body"),
        (checked_scene, "Scene"),
        (given_scene, "Scene"),
    ],
)
def test_a_path_is_told_how_to_load_it(check, kind, path):
    with pytest.raises(InputError) as caught:
        check(path)
    assert str(caught.value) == (
        f"{kind.lower()}: found {path!r}, expected a halfphysics.{kind}. "
        f"Load it: halfphysics.{kind}.load({path!r})"
    )


@pytest.mark.parametrize(
    ("value", "way"),
    [
        (
            Sequence(MOTION, Scene()),
            " (s.motion, with s.scene, body=s.body and settings=s.settings)",
        ),
        (
            Sequence((MOTION, MOTION), Scene()),
            " (s.motion, with s.scene, body=s.body and settings=",
        ),
        (SimpleNamespace(motion=MOTION), ", such as its .motion"),
        (SimpleNamespace(motion=3), ""),
        (None, ""),
        ([MOTION], ""),
    ],
)
def test_what_has_a_motion_is_told_where(value, way):
    with pytest.raises(InputError) as caught:
        checked_motion(value)
    assert f"expected a halfphysics.Motion{way}" in str(caught.value)
    assert way or str(caught.value).endswith("halfphysics.Motion")


def test_only_who_takes_lists_proposes_one():
    with pytest.raises(InputError, match=r"halfphysics\.Motion$"):
        checked_motion(iter([MOTION]))
    with pytest.raises(InputError, match=r"halfphysics\.Motion or a list of them$"):
        checked_motion(iter([MOTION]), listed=True)


def test_other_kinds():
    with pytest.raises(InputError, match="scene: found None, expected"):
        given_scene(None)
    with pytest.raises(InputError, match=r"settings: found 'a', expected halfphysics\.Settings$"):
        checked_settings("a")
    with pytest.raises(InputError, match=r"expected halfphysics\.Settings of these$"):
        checked_settings({"stiffness": 2.0})
    with pytest.raises(InputError, match=r"body: found 3, expected a halfphysics\.Body$"):
        checked_bodies([Body.default(), 3])

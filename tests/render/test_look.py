"""Colours that tell things apart, text that can be read, lights that stand beside the camera."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from halfphysics.render.look import (
    DARK,
    FILL,
    GHOST,
    KEY,
    LIGHT,
    PEOPLE,
    SKIN,
    TROUSERS,
    turned,
)

THEMES = pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])


def luminance(color):
    """Relative luminance of WCAG 2.1."""
    c = np.asarray(color)
    light = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return float(light @ [0.2126, 0.7152, 0.0722])


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_people_ghost_and_skin_have_colours_of_their_own():
    for one, other in itertools.combinations([*PEOPLE, GHOST, SKIN, TROUSERS], 2):
        assert np.linalg.norm(np.subtract(one, other)) > 0.12, (one, other)


@THEMES
def test_text_can_be_read_and_the_ground_is_near_its_sky(theme):
    assert contrast(theme.ink, theme.plate) > 7.0  # WCAG's AAA
    assert contrast(theme.ground, theme.horizon) < 1.5
    assert 1.15 < contrast(theme.line, theme.ground) < 2.0  # seen, but not before the people


@THEMES
def test_people_stand_out_from_the_ground(theme):
    for shirt in PEOPLE:
        assert np.linalg.norm(np.subtract(shirt, theme.ground)) > 0.2


@pytest.mark.parametrize("light", [KEY, FILL])
def test_lights_keep_their_place_beside_the_camera(light):
    assert turned(light, (0.0, -1.0)) == pytest.approx(light)  # the camera looks along +y
    for angle in (0.3, 1.9, 4.0):
        camera = np.array([np.cos(angle), np.sin(angle)])
        found = np.array(turned(light, (camera[0], camera[1])))
        assert found[2] == light[2]
        # Towards the camera, and to its right.
        assert found[:2] @ camera == pytest.approx(-light[1])
        assert found[:2] @ [-camera[1], camera[0]] == pytest.approx(light[0])

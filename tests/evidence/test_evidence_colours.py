"""The colours of the report's plots: visible on their background, distinct to the colour-blind."""

from __future__ import annotations

import re
from itertools import combinations

import numpy as np
import pytest

from evidence.page.html import _STYLE

#: Machado, Oliveira and Fernandes 2009, severity 1, on linear RGB.
SIGHTS = {
    "all colours": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([0.9505, 1.0, 1.089])


def linear(colour):
    values = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    ratio = TO_XYZ @ np.clip(rgb, 0, 1) / WHITE
    x, y, z = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def palettes():
    style = _STYLE.read_text(encoding="utf-8")
    grounds = re.findall(r"--paper: (#\w{6})", style)
    colours = re.findall(r"--s\d: (#\w{6})", style)
    assert len(grounds) == 2
    assert len(colours) == 12
    return {"light": (grounds[0], colours[:6]), "dark": (grounds[1], colours[6:])}


@pytest.mark.parametrize("name", ["light", "dark"])
def test_series_stand_out_from_the_ground(name):
    """WCAG 2 requires a contrast of 3 for graphics."""
    ground, colours = palettes()[name]
    for colour in colours:
        low, high = sorted(LUMINANCE @ linear(c) + 0.05 for c in (ground, colour))
        assert high / low >= 3.0, colour


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize("name", ["light", "dark"])
def test_series_are_told_apart(name, sight):
    """Fourteen CIELAB units are several times the least visible difference."""
    seen = {c: lab(np.array(SIGHTS[sight]) @ linear(c)) for c in palettes()[name][1]}
    for a, b in combinations(seen, 2):
        assert np.linalg.norm(seen[a] - seen[b]) >= 14.0, (a, b)
